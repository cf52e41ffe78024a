// Makes the outputs of detect_contacts: lists of pairs, a JSON report, and a summary for people.
// The functions return text; detect_contacts.cpp writes it to files or to standard output.
#pragma once

#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/detect_contacts/detect_arguments.h"

namespace deformable_contact_monitor {

// The times of repeated detections of one scene [ms].
struct DetectionTimes {
  std::vector<double> detect, round_trip;
  std::vector<std::vector<std::pair<std::string, double>>> stages;

  // Appends the times of one detection. `detect` and `round_trip` are as in DetectionResult;
  // `stages` has the names and times of its stages.
  void add(const DetectionResult& result);
};

// Returns a line "bodyA triA bodyB triB" for each contact, sorted; numbers count from 0.
std::string pairLines(const TrianglePairs& contacts);

// Returns a line "bodyA triA bodyB triB first_low first_high" for each contact of a time interval,
// in the same order (see FirstContact); numbers have nine digits.
std::string timeLines(const DetectionResult& result);

// Returns a line "bodyA triA bodyB triB ax ay az bx by bz nx ny nz separation flags" for each
// contact, in the same order (see PairGeometry). Numbers have nine digits, which restore the
// float32.
std::string geometryLines(const DetectionResult& result);

// Returns one JSON object. Counts are those of the last detection; times are over all detections:
// `first`, `median` and `p95`.
std::string jsonReport(const DetectArguments& arguments, const Scene& scene,
                       const std::string& backend, const DetectionResult& last,
                       const DetectionTimes& times);

// Returns a few lines: which bodies touch, and in how many pairs of triangles. With a tolerance or
// a budget, also the state of each pair of bodies.
std::string summary(const DetectArguments& arguments, const Scene& scene,
                    const std::string& backend, const DetectionResult& last,
                    const DetectionTimes& times);

}  // namespace deformable_contact_monitor
