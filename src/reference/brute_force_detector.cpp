// Every pair of triangles, one by one: closed boxes, then the exact predicates, then the distance.
#include "reference/brute_force_detector.h"

#include <algorithm>
#include <chrono>

#include "core/predicates/triangle_distance.h"
#include "reference/posed_triangles.h"

namespace deformable_contact_monitor {
namespace {

bool boxesOverlap(const Triangle& a, const Triangle& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto range = [axis](const Triangle& t) {
      return std::minmax({t.v[0][axis], t.v[1][axis], t.v[2][axis]});
    };
    const auto in_a = range(a), in_b = range(b);
    if (in_a.first > in_b.second || in_b.first > in_a.second) return false;
  }
  return true;
}

struct Found {
  TrianglePair pair;
  float separation_m;
};

class BruteForceDetector : public Detector {
 public:
  std::string backend() const override { return "brute_force"; }
  void reset() override {}

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireValid(options);
    const auto start = std::chrono::steady_clock::now();
    result_ = DetectionResult();
    result_.guaranteed = options.predicates != Predicates::kFast;
    result_.counters.triangles = scene.triangleCount();

    std::vector<std::vector<PosedTriangle>> bodies(scene.bodyCount());
    for (BodyId b = 0; b < scene.bodyCount(); ++b) {
      if (!scene.takesPart(b)) continue;
      bodies[b] = finiteTriangles(scene.body(b));
      result_.counters.posed += scene.body(b).mesh.triangleCount();
      result_.counters.rejected += scene.body(b).mesh.triangleCount() - bodies[b].size();
    }
    std::vector<Found> found;
    bool margins = false;
    for (BodyId a = 0; a < scene.bodyCount(); ++a) {
      margins = margins || scene.body(a).margin_m > 0;
      for (BodyId b = a; b < scene.bodyCount(); ++b) {
        if (!scene.pairEnabled(a, b)) continue;
        margin_m_ = std::max(scene.body(a).margin_m, scene.body(b).margin_m);
        for (std::size_t i = 0; i < bodies[a].size(); ++i) {
          for (std::size_t j = a == b ? i + 1 : 0; j < bodies[b].size(); ++j) {
            float separation_m = 0;
            if (isContact(bodies[a][i], bodies[b][j], a == b, options, &separation_m)) {
              found.push_back({{a, bodies[a][i].index, b, bodies[b][j].index}, separation_m});
            }
          }
        }
      }
    }
    std::sort(found.begin(), found.end(),
              [](const Found& x, const Found& y) { return x.pair < y.pair; });
    for (const Found& f : found) {
      result_.contacts.push_back(f.pair);
      if (margins) result_.separations_m.push_back(f.separation_m);
    }
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    result_.detect_ms = result_.round_trip_ms = elapsed.count();
    return result_;
  }

 private:
  bool isContact(const PosedTriangle& a, const PosedTriangle& b, bool same_body,
                 const Options& options, float* separation_m) {
    if (margin_m_ == 0 && !boxesOverlap(a.posed, b.posed)) return false;
    const SharedVertices shared =
        same_body ? sharedVertices(a.received, b.received) : SharedVertices();
    if (shared.any && options.adjacent == AdjacentPairs::kSkip) return false;
    ++result_.counters.candidates;
    PredicateState state;
    state.mode = options.predicates;
    bool contact = shared.any ? meetBeyondShared(a.posed, b.posed, shared, state)
                              : trianglesIntersect(a.posed, b.posed, state);
    if (!contact && margin_m_ > 0 && !shared.any) {
      const double distance_m = separation(a.posed, b.posed);
      contact = distance_m <= margin_m_;
      *separation_m = static_cast<float>(distance_m);
    }
    result_.counters.exact += state.exact;
    result_.counters.undecided += state.undecided;
    return contact;
  }

  float margin_m_ = 0;  // of the pair of bodies at hand
  DetectionResult result_;
};

}  // namespace

std::unique_ptr<Detector> makeBruteForceDetector() {
  return std::make_unique<BruteForceDetector>();
}

}  // namespace deformable_contact_monitor
