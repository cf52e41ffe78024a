// The settings of a detector.
#pragma once

#include <string>
#include <vector>

#include "core/export.h"
#include "core/limits.h"
#include "core/pair_settings.h"

namespace deformable_contact_monitor {

enum class Motion {
  kInstant,  // contacts at one moment
  kSwept,    // contacts at some time of the step from Body::earlier to the bodies' present state
};

struct Options {
  Motion motion = Motion::kInstant;
  bool first_times = false;  // DetectionResult::first_times is asked for; swept only
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  Predicates predicates = Predicates::kExact;
  // Share [0, 1] of each triangle, about its centroid, that decides its clusters. 1: complete by
  // proof; below, contacts at cluster borders are lost; 0: hard clustering. On CUDA a tile, up to
  // 32 triangles of a body that lie together, is in the clusters of each of its triangles.
  float overlap = 1;

  // What follows costs or saves time and never changes the result while overlap is 1 and predicates
  // are exact. Below exact, it decides with the earlier cycles which pairs come to be undecided.
  int clusters = 0;        // 0: from the scene; at most kMaxClusters
  float fuzzifier = 2;     // [1.05, 4]
  int iterations = 1;      // of fuzzy c-means a refresh, warm-started, [0, 100]
  int refresh_period = 1;  // cycles between refreshes, >= 1
  int threads = 0;         // of the CPU backend; 0: all cores

  // [m], finite and >= 0. Above 0, a bounded detector (bounded_detector.h) may decide by distances
  // that are off by so much; every other detector is exact whatever it is.
  float tolerance_m = 0;

  bool geometry = false;  // DetectionResult::geometry is asked for; instant only

  Limits limits;  // what ends a cycle early; none by default
};

constexpr int kMaxClusters = 65535;

// Whether the settings cannot lose a contact: complete by proof.
DCM_EXPORT bool isGuaranteed(const Options& options);

// One clear line for each value out of range; empty if there is none.
DCM_EXPORT std::vector<std::string> problems(const Options& options);

// Throws std::invalid_argument, listing all problems(options).
DCM_EXPORT void requireValid(const Options& options);

// Throws std::invalid_argument, naming the backend, if motion is swept: for those that know one
// moment alone.
DCM_EXPORT void requireInstant(const Options& options, const std::string& backend);

// "beyond_shared", "skip".
DCM_EXPORT const char* toString(AdjacentPairs adjacent);

// "instant", "swept".
DCM_EXPORT const char* toString(Motion motion);

// "exact", "conservative", "fast".
DCM_EXPORT const char* toString(Predicates predicates);
// The inverse. Throws std::invalid_argument at any other name.
DCM_EXPORT Predicates toPredicates(const std::string& name);

}  // namespace deformable_contact_monitor
