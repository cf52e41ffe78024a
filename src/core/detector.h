// The detector's interface: every backend and every reference stands behind it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <string>
#include <utility>
#include <vector>

#include "core/export.h"
#include "core/host_list.h"
#include "core/options.h"
#include "core/pair_geometry.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// (body_a, triangle_a) < (body_b, triangle_b), lexicographically.
struct DCM_EXPORT TrianglePair {
  std::uint32_t body_a, triangle_a, body_b, triangle_b;

  // Uninitialised: to resize a list that is about to be filled costs nothing.
  TrianglePair() {}
  TrianglePair(std::uint32_t in_body_a, std::uint32_t in_triangle_a, std::uint32_t in_body_b,
               std::uint32_t in_triangle_b)
      : body_a(in_body_a),
        triangle_a(in_triangle_a),
        body_b(in_body_b),
        triangle_b(in_triangle_b) {}

  bool operator==(const TrianglePair& o) const {
    return body_a == o.body_a && triangle_a == o.triangle_a && body_b == o.body_b &&
           triangle_b == o.triangle_b;
  }
  bool operator<(const TrianglePair& o) const {
    if (body_a != o.body_a) return body_a < o.body_a;
    if (triangle_a != o.triangle_a) return triangle_a < o.triangle_a;
    if (body_b != o.body_b) return body_b < o.body_b;
    return triangle_b < o.triangle_b;
  }
};

using TrianglePairs = HostList<TrianglePair>;

// When two triangles touch first, as parts [0, 1] of a step: certainly not before `low`, and
// certainly at some time in [low, high]; at most 2^-20 apart where predicates are exact. 0 and 0:
// at the step's beginning.
struct FirstContact {
  float low, high;
};

// What is certain of the distance of two bodies, body_a < body_b [m], scene frame. Triangles that
// were rejected take no part.
struct DCM_EXPORT BodyDistance {
  BodyId body_a = 0, body_b = 0;
  float low_m = 0;  // no two points of their triangles are nearer; 0: nothing is known
  // Two points of the witness's triangles are at most so far apart; 0: these intersect, by the
  // exact verdict. +inf: there is no witness, and what follows means nothing.
  float high_m = std::numeric_limits<float>::infinity();
  TrianglePair witness{0, 0, 0, 0};
  // Those two points, each within 2^-22 of its own largest coordinate [m]; where the triangles
  // intersect, near what they have in common.
  Vec3f point_a, point_b;
  bool is_listed = false;           // all contacts of the pair are in DetectionResult::contacts
  std::uint32_t contact_count = 0;  // how many of the pair's are there
};

// Work done in one cycle [triangles or pairs]; of one meaning on every backend, and 0 where one
// does not do that work. CUDA puts tiles of up to 32 triangles into clusters: a cluster's triangles
// are those of its tiles, and what its sweeps visit are pairs of triangles of tiles that meet.
struct DCM_EXPORT Counters {
  std::uint64_t triangles = 0;        // in the scene
  std::uint64_t rejected = 0;         // left out for a non-finite vertex
  std::uint64_t posed = 0;            // of bodies whose vertices were brought into the scene frame
  std::uint64_t culled = 0;           // of enabled pairs, but outside every partner's box
  std::uint64_t clustered = 0;        // assigned to clusters
  std::uint64_t large = 0;            // very large or far off: on the list of their own
  std::uint64_t clusters = 0;         // in use
  std::uint64_t cluster_entries = 0;  // sum of the clusters' sizes
  std::uint64_t largest_cluster = 0;
  std::uint64_t interval_overlaps = 0;  // pairs that the sweeps along the principal axes visited
  std::uint64_t candidates = 0;         // pairs that came to the predicates
  std::uint64_t exact = 0;              // of them, undecided by the floating-point filters
  std::uint64_t undecided = 0;  // of the contacts: assumed to be some, by conservative predicates
};

struct DCM_EXPORT DetectionResult {
  TrianglePairs contacts;  // sorted, each once
  // Distance of each contact's triangles [m], 0 where they intersect, above 0 elsewhere. There iff
  // Scene::anyMargin(): some body that takes part has a margin. Empty otherwise: then all of them
  // intersect. Empty too in swept motion, which knows no margins.
  std::vector<float> separations_m;
  // Of each contact, if options.geometry; else empty. Empty too if the limits left no time for all
  // of it: that alone is no cut-off, for the list is what it is.
  std::vector<PairGeometry> geometry;
  // Of each contact, if options.first_times; else empty. A contact that a pad alone makes (see
  // within_pad) has the time before which it is certainly none, and 1.
  std::vector<FirstContact> first_times;
  // Of each contact, there iff motion is swept and Scene::anyPad(): 1 if it is none on the straight
  // ways but may be one within the pads.
  std::vector<std::uint8_t> within_pad;
  // Bodies that take part in swept motion without an earlier state: they stood still.
  std::vector<BodyId> without_step;
  // Of each enabled pair of two bodies, ascending, where a bounded detector looked at bounds
  // (bounded_detector.h); else empty. Of a pair that is not listed, `contacts` holds what was seen
  // to intersect on the way.
  std::vector<BodyDistance> distances;
  // Contacts that were found and counted but are not in the list: the backend's memory limit was
  // reached, or no time was left to sort them. Which ones is arbitrary.
  std::uint64_t left_out = 0;
  // Pairs found are contacts, but others may be missing: time or memory ran out.
  bool cut_off = false;
  std::string cut_off_because;  // kNoTime, "stopped", "memory_limit_mib"; empty: it was not
  bool guaranteed = false;      // the settings in force cannot lose a contact; a cycle cut off may
  bool started_cold = false;    // nothing of earlier cycles was of use, so this one took longer
  Counters counters;
  // Times [ms] of the stages (core/common/stages.h) in their order. A backend on which stages
  // overlap gives several as one ("transform_to_narrow_phase"), one that has other stages gives
  // those.
  std::vector<std::pair<std::string, double>> stages_ms;
  double detect_ms = 0;            // vertices in the backend's memory to contacts there
  std::uint64_t memory_bytes = 0;  // in use on a device; 0 where that is not counted
  double round_trip_ms = 0;        // scene on the host to sorted contacts on the host

  // Forgets the last cycle, counts the scene's triangles and looks for bodies without a step: so
  // every backend begins a cycle.
  void begin(const Scene& scene, const Options& options, bool is_guaranteed);

  // Whether it was cut off by its deadline.
  bool isOutOfTime() const { return cut_off && cut_off_because == kNoTime; }

  // Says that the cycle was cut off; the first reason stays.
  void cutOff(const std::string& because);
};

// A detector keeps buffers and prototypes from cycle to cycle. One thread at a time.
class DCM_EXPORT Detector {
 public:
  Detector() = default;
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;
  virtual ~Detector() = default;

  // "cpu", "cuda", "fcl", "brute_force".
  virtual std::string backend() const = 0;

  // Finds every contact of the scene's enabled pairs. The result belongs to the detector: no copy
  // is made, and it is valid until the next call or the detector's end.
  // A cycle that ends early, by options.limits, is no error: see cut_off. The next one is as if it
  // had not been.
  // Throws std::invalid_argument, listing all problems(options), and where a body's vertices are on
  // a device that this backend cannot read; a std::runtime_error (BackendError) where it fails.
  virtual const DetectionResult& detect(const Scene& scene, const Options& options) = 0;

  // With default options.
  const DetectionResult& detect(const Scene& scene) { return detect(scene, Options()); }

  // Memory from which this backend reads meshes soonest, for Scene::useMemory(). It is the
  // process's own, outlives all detectors, and any backend and the user may read it; it is good
  // for as long as nobody calls cudaDeviceReset().
  virtual std::pmr::memory_resource& vertexMemory() { return *std::pmr::new_delete_resource(); }

  // Forgets what earlier cycles left (warm starts); exact results never depend on it.
  virtual void reset() = 0;
};

}  // namespace deformable_contact_monitor
