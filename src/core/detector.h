// The interface of all detectors, and their results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory_resource>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/export.h"
#include "core/host_list.h"
#include "core/options.h"
#include "core/pair_geometry.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Two triangles, with (body_a, triangle_a) < (body_b, triangle_b) lexicographically.
struct DCM_EXPORT TrianglePair {
  std::uint32_t body_a, triangle_a, body_b, triangle_b;

  // Leaves the members uninitialised, so that resizing a list that will be filled costs nothing.
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

// When two triangles touch first, as parts [0, 1] of the time interval: certainly not before `low`,
// and certainly at some time in [low, high]. With exact predicates these are at most 2^-20 apart.
// Both are 0 if the triangles touch at the beginning. A detector gives the times of the straight
// lines. Those of SubStepDetector (substeps.h) hold for bodies that rotate too.
struct FirstContact {
  float low, high;
};

// Bounds of the distance of two bodies, body_a < body_b, in the scene frame [m]. Rejected triangles
// take no part.
struct DCM_EXPORT BodyDistance {
  BodyId body_a = 0, body_b = 0;
  float low_m = 0;  // no two points of their triangles are nearer than this; 0: nothing is known
  // Two points of the witness's triangles are at most so far apart. 0: these triangles intersect,
  // decided exactly. +inf: there is no witness, and the next three members mean nothing.
  float high_m = std::numeric_limits<float>::infinity();
  TrianglePair witness{0, 0, 0, 0};
  // Those two points [m], each with an error of at most 2^-22 of its largest coordinate, or 2^-50
  // of the distance if that is more, plus 2^-24 of the smaller triangle's longest edge. If the
  // triangles intersect, the points are near their intersection.
  Vec3f point_a, point_b;
  // The nearest pair of the two bodies is known (options.nearest): it is the witness, and in
  // DetectionResult::nearest, or they are farther apart than their margin, and high_m is +inf.
  bool is_exact = false;
  bool is_listed = false;           // all contacts of the pair are in DetectionResult::contacts
  std::uint32_t contact_count = 0;  // how many contacts of the pair are in that list
};

// The nearest triangles of two bodies that touch or are at most their margin apart, at the present
// moment also in swept motion. Only triangles with finite vertices count.
struct DCM_EXPORT NearestPair {
  // The two triangles that are nearest to each other; of several at the same float32 distance, the
  // least by (triangle_a, triangle_b). body_a < body_b.
  TrianglePair pair{0, 0, 0, 0};
  // Their distance [m], right to 2^-28 of itself before it is rounded to float32. 0: they touch.
  float distance_m = 0;
  // The closest points of the two triangles [m], scene frame, each with an error of at most 2^-22
  // of its largest coordinate, or 2^-50 of the distance if that is more, plus 2^-24 of the smaller
  // triangle's longest edge. If they touch: one point near their intersection, twice.
  Vec3f point_a, point_b;
  Vec3f normal;  // a unit vector from a to b, scene frame; zero if they touch

  bool operator==(const NearestPair& o) const {
    return pair == o.pair && distance_m == o.distance_m && point_a == o.point_a &&
           point_b == o.point_b && normal == o.normal;
  }
  // Compares the bodies alone: no list has two pairs of the same.
  bool operator<(const NearestPair& o) const {
    return std::make_pair(pair.body_a, pair.body_b) < std::make_pair(o.pair.body_a, o.pair.body_b);
  }
};

// The nearest pair of two parts.
struct DCM_EXPORT NearestOfParts {
  PartPair parts;
  NearestPair nearest;

  bool operator==(const NearestOfParts& o) const {
    return parts == o.parts && nearest == o.nearest;
  }
  bool operator<(const NearestOfParts& o) const { return parts < o.parts; }
};

// How many triangles of a part take no part because one of their vertices is not finite.
struct DCM_EXPORT RejectedPart {
  BodyId body;
  PartId part;
  std::uint64_t count;  // at least 1

  bool operator==(const RejectedPart& o) const {
    return body == o.body && part == o.part && count == o.count;
  }
};

// Work done in one cycle [triangles or pairs]. Counters mean the same on every backend, and are 0
// if a backend does not do that work. CUDA puts tiles of up to 32 triangles into clusters, so the
// triangles of a cluster are those of its tiles, and its sweeps visit all pairs of triangles of two
// tiles that overlap.
struct DCM_EXPORT Counters {
  std::uint64_t triangles = 0;  // in the scene
  std::uint64_t rejected = 0;   // left out for a non-finite vertex; in parts that take part
  std::uint64_t posed = 0;      // of bodies whose vertices were transformed to the scene frame
  // In enabled pairs of bodies, but outside the boxes of all partners, or in a part without a pair.
  std::uint64_t culled = 0;
  std::uint64_t clustered = 0;        // assigned to clusters
  std::uint64_t large = 0;            // very large or far away, so handled as oversized triangles
  std::uint64_t clusters = 0;         // in use
  std::uint64_t cluster_entries = 0;  // sum of the clusters' sizes
  std::uint64_t largest_cluster = 0;
  std::uint64_t interval_overlaps = 0;  // pairs visited by sweeps along principal axes
  std::uint64_t candidates = 0;         // pairs passed to the predicates
  std::uint64_t exact = 0;              // candidates that floating-point filters did not decide
  std::uint64_t undecided = 0;          // contacts that conservative predicates only assume

  // Adds what a part of a cycle counted of its own work, such as an interval of a motion or a
  // partition of the scene. The counters that depend on how the parts overlap (triangles, rejected,
  // posed, culled, clusters) are left to the caller.
  void addWork(const Counters& part);
};

struct DCM_EXPORT DetectionResult {
  TrianglePairs contacts;  // sorted, each once
  // Distance of each contact's triangles [m]: 0 if they intersect, else above 0. Empty unless
  // near pairs are listed (options.near_pairs) and Scene::anyMargin(): then all contacts intersect.
  std::vector<float> separations_m;
  // Geometry of each contact, if options.geometry is set; else empty. Also empty if the limits left
  // no time for all of it. That alone does not set cut_off, because the list is complete.
  HostList<PairGeometry> geometry;
  // First time of each contact, if options.first_times is set; else empty. For a contact within the
  // pads only (see within_pad), `low` is the time before which it is certainly none, and `high`
  // is 1.
  std::vector<FirstContact> first_times;
  // For each contact, 1 if it is not a contact on the straight lines, but may be one within the
  // pads; else 0. Some of these stay farther apart than their pads, by up to 1/2048 of the way that
  // they move relative to each other, rarely by more. Empty unless motion is swept and
  // Scene::anyPad().
  std::vector<std::uint8_t> within_pad;
  // Bodies that take part in swept motion without an earlier state. They count as standing still.
  std::vector<BodyId> without_step;
  // Bounds of each enabled pair of two bodies, ascending, if a pool with tilings decided by bounds
  // (detector_pool.h); on CUDA, where they are exact, with a tolerance, or if a cycle that searched
  // nearest pairs was cut off; else empty. Of a pair that is not listed, `contacts` has those that
  // were found on the way.
  std::vector<BodyDistance> distances;
  // Of each enabled pair of two bodies that touch, or are at most the larger of their margins
  // apart, their nearest triangles, ascending by (body_a, body_b), if options.nearest is set; else
  // empty. Those that are listed are exact. A pair that is missing is farther apart, unless the
  // cycle was cut off, or the pair was decided within options.tolerance_m (see `distances`). With
  // swept motion they are of the present state, while `contacts` are those of the interval.
  std::vector<NearestPair> nearest;
  // The same for each enabled pair of parts of two bodies, ascending, if options.nearest_by_part is
  // set. Pairs of bodies without named parts are not listed. The nearest pair of two bodies is the
  // one of these that is nearest, and of several the least by its triangles.
  std::vector<NearestOfParts> nearest_parts;
  // Counters::rejected of the bodies with named parts, by part, ascending. Parts without rejected
  // triangles are not listed. If the cycle was cut off, the counts may leave out triangles.
  std::vector<RejectedPart> rejected_parts;
  // How many contacts were found, but are not in the list, because the backend's memory limit was
  // reached or no time was left to sort them. Which ones are missing is arbitrary.
  std::uint64_t left_out = 0;
  // Time or memory ran out: listed pairs are contacts, but others may be missing.
  bool cut_off = false;
  std::string cut_off_because;  // kNoTime, "stopped" or "memory_limit_mib"; empty: it was not
  bool guaranteed = false;      // the settings lose no contact; a cut-off still may
  bool started_cold = false;    // no data of earlier cycles could be used, so it took longer
  Counters counters;
  // Times of the stages in their order [ms]. A backend whose stages overlap reports several of them
  // as one ("transform_to_narrow_phase"). A backend with other stages reports those.
  std::vector<std::pair<std::string, double>> stages_ms;
  double detect_ms = 0;      // from vertices to contacts, both in the backend's memory
  double round_trip_ms = 0;  // from the scene to sorted contacts, both on the host
  // Memory that this process takes of the detector's devices, with all of its detectors: arrays,
  // the reserve, kernels with the stacks of their threads, and the driver's context [bytes]; 0 on
  // the CPU. The driver tells it, as nvidia-smi does. Where the driver does not (Jetson, containers
  // that number processes by themselves), it is what the library has allocated, and memory_is_whole
  // is not set.
  std::uint64_t memory_bytes = 0;
  bool memory_is_whole = false;
  std::uint64_t detector_bytes = 0;  // device memory of this detector's arrays; 0 on the CPU

  // Begins a cycle, in every backend: clears the last result, counts the scene's triangles and
  // finds bodies without an earlier state.
  void begin(const Scene& scene, const Options& options, bool is_guaranteed);

  // Returns the distance of a contact's triangles [m]; 0 if they intersect.
  float separationM(std::size_t contact) const {
    return separations_m.empty() ? 0 : separations_m[contact];
  }
  // Returns whether the two triangles of a contact touch; otherwise they are only near.
  bool touches(std::size_t contact) const { return separationM(contact) <= 0; }
  // Returns the pairs of bodies with triangles that touch.
  std::set<std::pair<BodyId, BodyId>> touchingBodies() const;

  // Returns whether every triangle took part, no contact was left out and nothing was cut off.
  bool isWhole() const { return counters.rejected == 0 && left_out == 0 && !cut_off; }
  // Returns whether the result is whole and its settings find every pair by proof. Undecided pairs
  // are in the list as contacts, so they do not make it incomplete.
  bool isComplete() const { return guaranteed && isWhole(); }

  // Returns whether the deadline ended the cycle early.
  bool isOutOfTime() const { return cut_off && cut_off_because == kNoTime; }

  // Records that the cycle was cut off. The first reason is kept.
  void cutOff(const std::string& because);

  // Exchanges the contents of two results without a copy of the contacts. If their contacts lie in
  // different memory resources, the contacts of `other` are dropped first: use it only where
  // `other` has served its purpose.
  void swap(DetectionResult& other);
};

// Finds contacts in scenes. It keeps buffers and prototypes from cycle to cycle. One thread at a
// time.
class DCM_EXPORT Detector {
 public:
  Detector() = default;
  Detector(const Detector&) = delete;
  Detector& operator=(const Detector&) = delete;
  virtual ~Detector() = default;

  // Returns "cpu", "cuda", "fcl" or "brute_force".
  virtual std::string backend() const = 0;

  // Finds every contact of the scene's enabled pairs. The result belongs to the detector and is
  // valid until the next call or the detector's end. A cycle that options.limits end early is not
  // an error (see DetectionResult::cut_off), and does not affect the next one. Throws
  // std::invalid_argument with all problems(options), or if a body's vertices are on a device that
  // this backend cannot read. Throws a std::runtime_error (BackendError) if the backend fails.
  virtual const DetectionResult& detect(const Scene& scene, const Options& options) = 0;

  // Does the same with default options.
  const DetectionResult& detect(const Scene& scene) { return detect(scene, Options()); }

  // Hands the result of the last detect() over to `result`, so that a caller can keep it without a
  // copy while the detector goes on. The detector takes the old contents of `result` in exchange
  // and reuses their memory. Call it at most once after each detect() that returned; the reference
  // that detect() returned then refers to those old contents.
  virtual void swapResult(DetectionResult& result) = 0;

  // Returns the memory from which this backend reads meshes fastest, for Scene::useMemory(). It
  // belongs to the process and outlives all detectors. Any backend and the user may read it. It is
  // valid until somebody calls cudaDeviceReset().
  virtual std::pmr::memory_resource& vertexMemory() { return *std::pmr::new_delete_resource(); }

  // Forgets what earlier cycles left for warm starts. Exact results never depend on that.
  virtual void reset() = 0;
};

}  // namespace deformable_contact_monitor
