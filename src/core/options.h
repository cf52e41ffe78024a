// The settings of a detection.
#pragma once

#include <string>
#include <vector>

#include "core/export.h"
#include "core/limits.h"
#include "core/pair_settings.h"

namespace deformable_contact_monitor {

enum class Motion {
  kInstant,  // contacts at one moment
  kSwept,    // contacts at any time from the bodies' earlier states to their present ones
};

struct Options {
  Motion motion = Motion::kInstant;
  bool first_times = false;  // fill DetectionResult::first_times; swept motion only
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  Predicates predicates = Predicates::kExact;
  // The part of each triangle around its centroid, in [0, 1], that is assigned to clusters. With 1
  // no contact is lost, by proof; with less, contacts at borders of clusters are lost; 0 is hard
  // clustering. On CUDA a tile of up to 32 triangles is in the clusters of each of its triangles.
  float overlap = 1;

  // The following settings change only the time of a cycle, and never its result, while overlap is
  // 1 and predicates are exact. With conservative ones they, and earlier cycles, decide which pairs
  // remain undecided.
  int clusters = 0;        // 0: chosen from the scene; at most kMaxClusters
  float fuzzifier = 2;     // [1.05, 4]
  int iterations = 1;      // of fuzzy c-means per refresh, warm-started, [0, 100]
  int refresh_period = 1;  // cycles between refreshes, >= 1
  int threads = 0;         // of the CPU backend; 0: one per core

  // Allowed error of distances [m], finite and >= 0. Above 0, a detector pool with tilings
  // (detector_pool.h) may decide pairs of bodies with such an error on the CPU. All other detectors
  // are exact; CUDA then fills in DetectionResult::distances, too.
  float tolerance_m = 0;

  // What margins are for. By default, DetectionResult::contacts lists all pairs of triangles within
  // them, in instant motion; if a margin is large beside the triangles, that list and its cost are
  // long. With `nearest`, a search finds the nearest pair of each two bodies instead
  // (DetectionResult::nearest), and contacts are those that touch, unless `near_pairs` asks for the
  // list as well.
  bool nearest = false;
  bool near_pairs = false;
  // With `nearest`, also finds the nearest pair of each pair of parts
  // (DetectionResult::nearest_parts). Each pair of parts costs a search of its own.
  bool nearest_by_part = false;

  bool geometry = false;  // fill DetectionResult::geometry; instant motion only

  Limits limits;  // end a cycle early; none by default
};

constexpr int kMaxClusters = 65535;

// Returns whether the settings certainly lose no contact.
DCM_EXPORT bool isGuaranteed(const Options& options);

// Returns one line for each value that is out of range.
DCM_EXPORT std::vector<std::string> problems(const Options& options);

// Throws std::invalid_argument, listing all problems(options).
DCM_EXPORT void requireValid(const Options& options);

// Throws std::invalid_argument unless a number of threads is in [0, 1024].
DCM_EXPORT void requireThreads(int threads);

// Throws std::invalid_argument, naming the backend, if motion is swept. For backends without
// continuous collision detection.
DCM_EXPORT void requireInstant(const Options& options, const std::string& backend);

// Returns "beyond_shared" or "skip".
DCM_EXPORT const char* toString(AdjacentPairs adjacent);

// Returns "instant" or "swept".
DCM_EXPORT const char* toString(Motion motion);

// Returns "exact" or "conservative".
DCM_EXPORT const char* toString(Predicates predicates);
// Returns the predicates of that name. Throws std::invalid_argument for any other name.
DCM_EXPORT Predicates toPredicates(const std::string& name);

}  // namespace deformable_contact_monitor
