// Times detections with tolerances and budgets, and checks every claim against the exact contacts.
//
// The distance of claimed triangles is computed here by plain geometry in double, independently of
// the detectors: the nearest points of two disjoint triangles are at a corner and a face, at a
// corner and an edge, or on two edges.
#include "tools/measure_trade/bound_measurement.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "core/body_distance.h"
#include "core/common/posed_body.h"
#include "core/common/rejected_bodies.h"
#include "tools/common/backend_choice.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_grid.h"

namespace deformable_contact_monitor {
namespace {

using Corners = std::array<Vec3d, 3>;

Corners cornersOf(const Triangle& t) {
  return {toDouble(t.v[0]), toDouble(t.v[1]), toDouble(t.v[2])};
}

// Returns the distance of a point to a segment.
double toPoint(const Vec3d& p, const Vec3d& from, const Vec3d& to) {
  const Vec3d way = to - from;
  const double square = dot(way, way);
  const double at = square > 0 ? std::clamp(dot(p - from, way) / square, 0.0, 1.0) : 0.0;
  return length(p - (from + way * at));
}

// Returns the distance of two segments if they are nearest at inner points, else infinity; the ends
// are checked by toPoint(). The common perpendicular of the two lines gives the nearest points.
// Parallel segments are nearest at an end, too.
double betweenInner(const Vec3d& p, const Vec3d& p_to, const Vec3d& q, const Vec3d& q_to) {
  const Vec3d u = p_to - p, v = q_to - q, w = p - q, n = cross(u, v);
  const double square = dot(n, n);
  if (square == 0) return INFINITY;
  const double s = dot(cross(v, w), n) / square, t = dot(cross(u, w), n) / square;
  if (s < 0 || s > 1 || t < 0 || t > 1) return INFINITY;
  return length((p + u * s) - (q + v * t));
}

// Returns true if the point's projection lies on the triangle. Otherwise an edge is nearer.
bool isOver(const Vec3d& p, const Corners& t, const Vec3d& n) {
  for (int k = 0; k < 3; ++k) {
    if (dot(cross(t[(k + 1) % 3] - t[k], p - t[k]), n) < 0) return false;
  }
  return true;
}

// Returns the distance of a's corners to the inside of `b`, and 0 if an edge of `a` passes through
// it.
double toInside(const Corners& a, const Corners& b) {
  const Vec3d n = cross(b[1] - b[0], b[2] - b[0]);
  const double size = length(n);
  if (size == 0) return INFINITY;
  double gap = INFINITY;
  std::array<double, 3> height;
  for (int k = 0; k < 3; ++k) {
    height[k] = dot(a[k] - b[0], n) / size;
    if (isOver(a[k], b, n)) gap = std::min(gap, std::abs(height[k]));
  }
  for (int k = 0; k < 3; ++k) {
    const double from = height[k], to = height[(k + 1) % 3];
    if (from == to || (from > 0) == (to > 0)) continue;
    if (isOver(a[k] + (a[(k + 1) % 3] - a[k]) * (from / (from - to)), b, n)) return 0;
  }
  return gap;
}

// Adds the states of one detection to the sums, and checks them.
class Counting {
 public:
  Counting(const Scene& scene, const std::set<BodyPair>& truth, std::string frame,
           BoundMeasurement* sum)
      : scene_(scene), truth_(truth), frame_(std::move(frame)), sum_(sum) {}

  // Takes the bounds of each pair, or the list of contacts of a detection without bounds. A pair of
  // a body with rejected triangles is UNKNOWN unless the others touch.
  void add(const DetectionResult& result) {
    const RejectedBodies rejected(scene_, Motion::kInstant, result.counters.rejected);
    if (result.distances.empty()) return addExact(result, rejected);
    for (const BodyDistance& distance : result.distances) {
      const PairDecision decision =
          decide(rejected.certain(distance), scene_, sum_->setting.tolerance_m);
      add({distance.body_a, distance.body_b}, decision);
      if (decision == PairDecision::kContact) addClaim(distance.witness);
    }
  }

 private:
  // Takes the states of a detection without tolerance: a pair that was not found is decided unless
  // the detection was cut off, or triangles were rejected.
  void addExact(const DetectionResult& result, const RejectedBodies& rejected) {
    const std::set<BodyPair> found = result.touchingBodies();
    for (const BodyPair& bodies : scene_.enabledPairs()) {
      if (bodies.first == bodies.second) continue;
      const bool is_open = result.cut_off || rejected.hasOneOf(bodies.first, bodies.second);
      add(bodies, found.count(bodies) > 0 ? PairDecision::kContact
                  : is_open               ? PairDecision::kOpen
                                          : PairDecision::kNone);
    }
  }

  // Counts one pair, and compares its state with the truth.
  void add(const BodyPair& bodies, PairDecision decision) {
    // A contact that is reported as NONE is a broken promise. UNKNOWN is not: the budget ended the
    // detection.
    const bool is_true = truth_.count(bodies) > 0, claimed = decision == PairDecision::kContact;
    ++sum_->pairs;
    sum_->decided += decision != PairDecision::kOpen;
    sum_->contacts.add({is_true, claimed, claimed && is_true});
    if (!is_true || claimed || decision == PairDecision::kOpen) return;
    ++sum_->missed;
    if (sum_->setting.overlap < 1) return;
    fail("says that " + scene_.body(bodies.first).name + " and " + scene_.body(bodies.second).name +
         ", which intersect, do not");
  }

  // Checks that the claimed triangles are within the tolerance, but for rounding.
  void addClaim(const TrianglePair& witness) {
    const Triangle a = PosedBody(scene_.body(witness.body_a)).triangle(witness.triangle_a);
    const Triangle b = PosedBody(scene_.body(witness.body_b)).triangle(witness.triangle_b);
    const double gap_m = triangleGapM(a, b);
    sum_->largest_claim_m = std::max(sum_->largest_claim_m, gap_m);
    double largest = 0;
    for (const Triangle& t : {a, b}) {
      for (const Vec3f& v : t.v) {
        largest = std::max(
            {largest, std::abs(double{v.x}), std::abs(double{v.y}), std::abs(double{v.z})});
      }
    }
    // triangleGapM() rounds relative to the size of the coordinates.
    constexpr double kRounding = 1e-12;
    if (gap_m <= double{sum_->setting.tolerance_m} + kRounding * largest) return;
    fail("claims a contact of triangles that are " + numberText(gap_m) + " m apart");
  }

  // Keeps the first broken promise, which is enough for a report of the defect.
  void fail(const std::string& how) {
    if (sum_->broken.empty()) sum_->broken = describe(sum_->setting) + " " + how + ", in " + frame_;
  }

  const Scene& scene_;
  const std::set<BodyPair>& truth_;
  const std::string frame_;
  BoundMeasurement* const sum_;
};

}  // namespace

// Takes the least distance over all pairs of a corner and a face, a corner and an edge, and two
// edges.
double triangleGapM(const Triangle& a, const Triangle& b) {
  const Corners p = cornersOf(a), q = cornersOf(b);
  double gap = std::min(toInside(p, q), toInside(q, p));
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Vec3d &p_to = p[(i + 1) % 3], &q_to = q[(k + 1) % 3];
      gap = std::min({gap, toPoint(p[i], q[k], q_to), toPoint(q[k], p[i], p_to),
                      betweenInner(p[i], p_to, q[k], q_to)});
    }
  }
  return gap;
}

std::string describe(const BoundSetting& setting) {
  if (setting.overlap < 1) return "overlap " + numberText(setting.overlap);
  if (!setting.isBounded()) return setting.backend == "cpu" ? "exact" : "exact, " + setting.backend;
  std::string text = "tolerance " + numberText(setting.tolerance_m) + " m";
  if (setting.budget_ms > 0) text += ", budget " + numberText(setting.budget_ms) + " ms";
  return text;
}

double BoundMeasurement::decidedShare() const { return share(decided, pairs); }
double BoundMeasurement::p99OverBudget() const {
  return setting.budget_ms > 0 ? percentile(ms, 0.99) / setting.budget_ms : 0;
}

// Self-contacts are left out, because tolerances are about pairs of two bodies.
TouchingPairs touchingBodies(FrameSource* frames, Detector* exact, const Options& options,
                             const SayProgress& progress) {
  TouchingPairs truth;
  bool any_pair = false;
  frames->rewind();
  while (frames->next()) {
    progress("exact contacts of " + frames->label());
    truth.push_back(exact->detect(frames->scene(), options).touchingBodies());
    for (const auto& [a, b] : frames->scene().enabledPairs()) any_pair = any_pair || a != b;
  }
  if (!any_pair) {
    throw std::runtime_error(
        "--tolerance: no frame has an enabled pair of two bodies, and a body with itself has no "
        "tolerance");
  }
  return truth;
}

void measureBounds(FrameSource* frames, const TouchingPairs& truth, const CycleCounts& cycles,
                   const Options& options, Detector* detector, TilingCache* tilings,
                   BoundMeasurement* sum) {
  Options bounded = options;
  // These three vary; everything else is as in `options`.
  bounded.tolerance_m = sum->setting.tolerance_m;
  bounded.overlap = sum->setting.overlap;
  forEachCycle(frames, cycles, [&](std::size_t frame, bool is_counted) {
    const Scene& scene = frames->scene();
    if (tilings != nullptr) makeTilings(scene, tilings);
    // The time includes everything that a caller waits for.
    const SteadyTime start = std::chrono::steady_clock::now();
    if (sum->setting.budget_ms > 0) {
      bounded.limits.deadline = start + fromSeconds(sum->setting.budget_ms / 1e3);
    }
    const DetectionResult& result = detector->detect(scene, bounded);
    const double ms = 1e3 * toSeconds(std::chrono::steady_clock::now() - start);
    if (!is_counted) return;
    if (sum->ms.size() == frame) sum->rejected += result.counters.rejected;  // the first pass
    sum->ms.push_back(ms);
    Counting(scene, truth.at(frame), frames->label(), sum).add(result);
  });
}

}  // namespace deformable_contact_monitor
