// What detect_contacts writes: pairs, JSON, and a summary for people.
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

  void add(const DetectionResult& result);
};

// A line "bodyA triA bodyB triB" for each contact, sorted, 0-based, nothing else.
std::string pairLines(const TrianglePairs& contacts);

// A line "bodyA triA bodyB triB first_low first_high" for each contact of a step, in the same
// order, as FirstContact; numbers with nine digits.
std::string timeLines(const DetectionResult& result);

// A line "bodyA triA bodyB triB ax ay az bx by bz nx ny nz separation flags" for each contact, in
// the same order, as PairGeometry; numbers with nine digits, which give back the float32.
std::string geometryLines(const DetectionResult& result);

// One JSON object: counts are of the last detection, times of all of them: `first` the first alone,
// `median` and `p95` over all.
std::string jsonReport(const DetectArguments& arguments, const Scene& scene,
                       const std::string& backend, const DetectionResult& last,
                       const DetectionTimes& times);

// A few lines; which bodies touch and in how many pairs. With a tolerance or a budget, how each
// pair of bodies stands, too.
std::string summary(const DetectArguments& arguments, const Scene& scene,
                    const std::string& backend, const DetectionResult& last,
                    const DetectionTimes& times);

}  // namespace deformable_contact_monitor
