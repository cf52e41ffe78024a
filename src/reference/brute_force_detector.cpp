// Compares every pair of triangles, one by one: closed boxes first, then the exact predicates, then
// the distance.
//
// It has no clusters, no sweep and no float32 filter, so that a mistake in one of these shows as a
// difference to this result. During a time interval it asks for the verdict on every pair.
#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/bounds/radii.h"
#include "core/common/contact_geometry.h"
#include "core/common/cycle_limit.h"
#include "core/common/part_table.h"
#include "core/common/posed_body.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/detector.h"
#include "core/predicates/narrow_phase.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_pad.h"
#include "core/predicates/swept_triangle.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/margins.h"
#include "core/rules/nearest.h"
#include "reference/posed_triangles.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

// A triangle of a body during the time interval.
struct MovingBodyTriangle {
  std::uint32_t index;      // in the body's mesh
  MovingTriangle received;  // in the body's frames
  MovingTriangle moving;    // in the scene frame
};

// A contact in continuous detection.
struct SweptContact {
  FirstContact first;
  // True if the triangles come within their pads, but do not meet on the straight lines.
  bool within_pad;
};

// Returns the triangles of a body in ascending order of index. Triangles with a vertex that is not
// finite in either state are left out. A body without an earlier state stands still. Once the limit
// is over, some are missing.
std::vector<MovingBodyTriangle> movingTriangles(const Body& body, const CycleLimit& limit) {
  const PosedBody from = PosedBody::earlier(body), to(body);
  const auto count = static_cast<std::uint32_t>(body.mesh.triangleCount());
  std::vector<MovingBodyTriangle> triangles;
  PacedLimit pace(limit, 1 << 14);
  for (std::uint32_t t = 0; t < count && !pace.over(); ++t) {
    const MovingTriangle moving{from.triangle(t), to.triangle(t)};
    if (isFinite(moving)) triangles.push_back({t, {from.received(t), to.received(t)}, moving});
  }
  return triangles;
}

// Returns the contact of a pair, or nothing. Adds to the counters candidates, exact and undecided.
std::optional<SweptContact> sweptContactOf(const MovingBodyTriangle& a, const MovingBodyTriangle& b,
                                           bool same_body, float pad_m, const Options& options,
                                           Counters& counters) {
  SharedVertices shared;
  if (same_body) shared = sharedTrajectories(a.received, b.received);
  if (shared.any && options.adjacent == AdjacentPairs::kSkip) return std::nullopt;
  PredicateState state{options.predicates};
  const SweptVerdict verdict =
      sweptVerdict(a.moving, b.moving, shared, options.adjacent, options.first_times, state);
  ++counters.candidates;
  counters.exact += state.exact > 0;
  if (verdict.part == PartVerdict::kMeet) {
    counters.undecided += state.undecided;
    return SweptContact{{verdict.first_low, verdict.first_high}, false};
  }
  // Triangles that share a vertex are always within their pads, so only the straight lines count.
  if (pad_m == 0 || shared.any) return std::nullopt;
  const PadVerdict pad = withinPad(a.moving, b.moving, pad_m);
  if (!pad.may_touch) return std::nullopt;
  // They may touch from first_low on; when they do is not known.
  return SweptContact{{pad.first_low, 1}, true};
}

// Compares closed boxes. It is written independently of predicates/aabb.h.
bool boxesIntersect(const Triangle& a, const Triangle& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto range = [axis](const Triangle& t) {
      return std::minmax({t.v[0][axis], t.v[1][axis], t.v[2][axis]});
    };
    const auto in_a = range(a), in_b = range(b);
    if (in_a.first > in_b.second || in_b.first > in_a.second) return false;
  }
  return true;
}

// Returns how far two triangles are certainly apart along some axis [m], or 0.
double gapAlongAxes(const Triangle& a, const Triangle& b) {
  double gap = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto range = [axis](const Triangle& t) {
      return std::minmax({double{t.v[0][axis]}, double{t.v[1][axis]}, double{t.v[2][axis]}});
    };
    const auto in_a = range(a), in_b = range(b);
    gap = std::max({gap, in_a.first - in_b.second, in_b.first - in_a.second});
  }
  return gap;
}

// Returns the nearest two triangles that count and are at most the margin apart, or nothing. It
// leaves out only pairs that are farther apart along one axis than the nearest pair so far.
template <class Counts>
std::optional<ComparedPair> nearestOf(const std::vector<PosedTriangle>& of_a,
                                      const std::vector<PosedTriangle>& of_b, const Counts& counts,
                                      float margin_m, const CycleLimit& limit) {
  constexpr double kRounding = 1 + 1e-6, kLeastStep = 0x1p-149;  // of distances to float32
  std::optional<ComparedPair> best;
  PacedLimit pace(limit, 512);
  for (const PosedTriangle& a : of_a) {
    for (const PosedTriangle& b : of_b) {
      if (pace.over()) return std::nullopt;
      if (!counts(a.index, b.index)) continue;
      const float most_m = best ? best->distance_m : margin_m;
      if (gapAlongAxes(a.posed, b.posed) > most_m * kRounding + kLeastStep) continue;
      PredicateState state{Predicates::kExact};
      const bool meet = trianglesIntersect(a.posed, b.posed, state);
      const float distance_m = meet ? 0 : comparedDistance(separation(a.posed, b.posed));
      const ComparedPair pair{distance_m, a.index, b.index};
      if (distance_m <= margin_m && (!best || pair.precedes(*best))) best = pair;
    }
  }
  return best;
}

// A contact that was found, before sorting.
struct Found {
  TrianglePair pair;
  float separation_m;
};

// A contact that was found in continuous detection, before sorting.
struct FoundSwept {
  TrianglePair pair;
  SweptContact contact;
};

// A detector that is slow and simple. It gives the same contacts as the backends.
class BruteForceDetector : public Detector {
 public:
  std::string backend() const override { return "brute_force"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireValid(options);
    requireHostVertices(scene, backend());
    const Stopwatch watch;
    const CycleLimit limit(options.limits);
    result_.begin(scene, options, true);
    const PartTable parts(scene);
    parts_ = &parts;
    if (!limit.over()) find(scene, options, limit);
    if (options.nearest) findNearest(scene, options, limit);
    listRejectedParts(scene, options.motion, result_);
    parts_ = nullptr;
    if (limit.wasOver()) result_.cutOff(limit.why());
    result_.detect_ms = result_.round_trip_ms = watch.elapsedMs();
    return result_;
  }

 private:
  // Selects discrete or continuous detection.
  void find(const Scene& scene, const Options& options, const CycleLimit& limit) {
    if (options.motion == Motion::kSwept) {
      sweep(scene, options, limit);
    } else {
      detectAtOnce(scene, options, limit);
    }
  }

  // Compares every pair of triangles of every enabled pair of bodies, for discrete detection.
  void detectAtOnce(const Scene& scene, const Options& options, const CycleLimit& limit) {
    found_.clear();
    const std::vector<std::vector<PosedTriangle>> bodies = posedBodies(scene, limit);
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (limit.over()) break;
      margin_m_ =
          pairMargin(listedMargin(scene.body(a), options), listedMargin(scene.body(b), options));
      compare(a, bodies[a], b, bodies[b], options, limit);
    }
    writeContacts(listsNearPairs(scene, options));
    writeGeometry(scene, options, result_);
  }

  // Does the same for continuous detection.
  void sweep(const Scene& scene, const Options& options, const CycleLimit& limit) {
    std::vector<std::vector<MovingBodyTriangle>> bodies(scene.bodyCount());
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      if (!scene.takesPart(b) || limit.over()) continue;
      bodies[b] = movingTriangles(scene.body(b), limit);
      dropIdle(scene, b, bodies[b]);
    }
    swept_.clear();
    PacedLimit pace(limit, 512);
    for (const auto& [a, b] : scene.enabledPairs()) {
      const float pad_m = pairPad(scene.body(a).pad_m, scene.body(b).pad_m);
      for (std::size_t i = 0; i < bodies[a].size(); ++i) {
        // In one body, a triangle is not compared with itself, and each pair comes once.
        for (std::size_t j = a == b ? i + 1 : 0; j < bodies[b].size() && !pace.over(); ++j) {
          if (!parts_->enabled(a, bodies[a][i].index, b, bodies[b][j].index)) continue;
          const auto contact =
              sweptContactOf(bodies[a][i], bodies[b][j], a == b, pad_m, options, result_.counters);
          if (contact) {
            swept_.push_back({{a, bodies[a][i].index, b, bodies[b][j].index}, *contact});
          }
        }
      }
    }
    std::sort(swept_.begin(), swept_.end(),
              [](const FoundSwept& x, const FoundSwept& y) { return x.pair < y.pair; });
    const bool pads = scene.anyPad();
    for (const FoundSwept& found : swept_) {
      result_.contacts.push_back(found.pair);
      if (options.first_times) result_.first_times.push_back(found.contact.first);
      if (pads) result_.within_pad.push_back(found.contact.within_pad ? 1 : 0);
    }
  }

  // Returns the finite triangles of all bodies that take part, and counts the rejected ones.
  std::vector<std::vector<PosedTriangle>> posedBodies(const Scene& scene, const CycleLimit& limit) {
    std::vector<std::vector<PosedTriangle>> bodies(scene.bodyCount());
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      if (!scene.takesPart(b)) continue;
      bodies[b] = finiteTriangles(scene.body(b), limit);
      if (limit.over()) break;
      dropIdle(scene, b, bodies[b]);
    }
    return bodies;
  }

  // Removes triangles of parts that take no part from a body's finite triangles, and counts the
  // rejected ones.
  template <class List>
  void dropIdle(const Scene& scene, BodyId b, List& finite) {
    const auto isIdle = [&](std::size_t t) { return !parts_->takesPart(parts_->of(b, t)); };
    const std::size_t count = scene.body(b).mesh.triangleCount();
    std::size_t rejected = count - finite.size();
    for (std::size_t t = 0; t < count; ++t) rejected -= isIdle(t) ? 1 : 0;
    for (const auto& triangle : finite) rejected += isIdle(triangle.index) ? 1 : 0;
    finite.erase(std::remove_if(finite.begin(), finite.end(),
                                [&](const auto& triangle) { return isIdle(triangle.index); }),
                 finite.end());
    result_.counters.posed += count;
    result_.counters.rejected += rejected;
  }

  // Tests the triangles of two bodies, or of one body with itself.
  void compare(BodyId a, const std::vector<PosedTriangle>& of_a, BodyId b,
               const std::vector<PosedTriangle>& of_b, const Options& options,
               const CycleLimit& limit) {
    constexpr std::uint64_t kLook = 512;  // pairs
    PacedLimit pace(limit, kLook);
    for (std::size_t i = 0; i < of_a.size(); ++i) {
      for (std::size_t j = a == b ? i + 1 : 0; j < of_b.size(); ++j) {
        if (pace.over()) return;
        if (!parts_->enabled(a, of_a[i].index, b, of_b[j].index)) continue;
        const Verdict verdict = verdictOn(of_a[i], of_b[j], a == b, options);
        if (!verdict.contact) continue;
        found_.push_back({{a, of_a[i].index, b, of_b[j].index}, verdict.separation_m});
      }
    }
  }

  // Asks no filter before the predicates, so that a mistake in a filter would show.
  Verdict verdictOn(const PosedTriangle& a, const PosedTriangle& b, bool same_body,
                    const Options& options) {
    // With a margin, triangles may be in contact although their boxes are apart.
    if (margin_m_ == 0 && !boxesIntersect(a.posed, b.posed)) return {};
    PairFacts facts;
    facts.margin_m = margin_m_;
    if (same_body) facts.shared = sharedVertices(a.received, b.received);
    if (facts.shared.any && options.adjacent == AdjacentPairs::kSkip) return {};
    PredicateState state{options.predicates};
    const Verdict verdict = fullVerdict(a.posed, b.posed, facts, state);
    ++result_.counters.candidates;
    result_.counters.exact += state.exact > 0;
    result_.counters.undecided += verdict.contact && state.undecided;
    return verdict;
  }

  // Finds the nearest pair of each two bodies at the present moment, from all pairs of triangles.
  void findNearest(const Scene& scene, const Options& options, const CycleLimit& limit) {
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a == b) continue;
      const auto enabled = [&, a = a, b = b](std::uint32_t triangle_a, std::uint32_t triangle_b) {
        return parts_->enabled(a, triangle_a, b, triangle_b);
      };
      const auto nearest = nearestOfBodies(scene, a, b, enabled, limit);
      if (nearest) result_.nearest.push_back(*nearest);
      const bool named = !scene.body(a).parts.empty() || !scene.body(b).parts.empty();
      if (!options.nearest_by_part || !named) continue;
      for (const PartId part_a : scene.body(a).listed_parts) {
        for (const PartId part_b : scene.body(b).listed_parts) {
          if (!scene.partPairEnabled(a, part_a, b, part_b)) continue;
          const auto inParts = [&, a = a, b = b](std::uint32_t triangle_a,
                                                 std::uint32_t triangle_b) {
            return parts_->of(a, triangle_a) == parts_->numberOf(a, part_a) &&
                   parts_->of(b, triangle_b) == parts_->numberOf(b, part_b);
          };
          const auto of_parts = nearestOfBodies(scene, a, b, inParts, limit);
          if (of_parts) result_.nearest_parts.push_back({{a, b, part_a, part_b}, *of_parts});
        }
      }
    }
    std::sort(result_.nearest_parts.begin(), result_.nearest_parts.end(),
              [](const NearestOfParts& x, const NearestOfParts& y) { return x.parts < y.parts; });
  }

  // Returns the nearest pair of two bodies among the pairs of triangles that count.
  template <class Counts>
  static std::optional<NearestPair> nearestOfBodies(const Scene& scene, BodyId a, BodyId b,
                                                    const Counts& counts, const CycleLimit& limit) {
    const std::vector<PosedTriangle> of_a = finiteTriangles(scene.body(a), limit);
    const std::vector<PosedTriangle> of_b = finiteTriangles(scene.body(b), limit);
    const float margin_m = pairMargin(scene.body(a).margin_m, scene.body(b).margin_m);
    const auto nearest = nearestOf(of_a, of_b, counts, margin_m, limit);
    if (!nearest) return std::nullopt;
    const TrianglePair pair{a, nearest->triangle_a, b, nearest->triangle_b};
    return nearestPairOf(scene, pair, nearest->distance_m);
  }

  // Sorts the contacts and copies them to the result.
  void writeContacts(bool margins) {
    std::sort(found_.begin(), found_.end(),
              [](const Found& x, const Found& y) { return x.pair < y.pair; });
    for (const Found& f : found_) {
      result_.contacts.push_back(f.pair);
      if (margins) result_.separations_m.push_back(f.separation_m);
    }
  }

  const PartTable* parts_ = nullptr;  // of this cycle
  float margin_m_ = 0;                // of the pair of bodies at hand
  std::vector<Found> found_;
  std::vector<FoundSwept> swept_;
  DetectionResult result_;
};

}  // namespace

std::unique_ptr<Detector> makeBruteForceDetector() {
  return withRadiiAndPartMargins(std::make_unique<BruteForceDetector>());
}

}  // namespace deformable_contact_monitor
