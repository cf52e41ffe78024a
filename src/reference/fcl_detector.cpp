// Uses FCL's bounding volume hierarchies behind the detector's interface. Each cycle builds a model
// of every body from its posed triangles and collides the models of all enabled pairs. If parts
// matter, each part has a model. It does not refit the models of the last cycle, so its time
// includes building them.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/detail/traversal/collision/mesh_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/common/contact_geometry.h"
#include "core/common/part_table.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/triangle_distance.h"
#include "core/predicates/triangle_intersection.h"
#include "core/rules/margins.h"
#include "core/rules/nearest.h"
#include "reference/posed_triangles.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

// Holds the finite triangles of a body, or of one of its parts, and FCL's model of them. FCL's
// triangle k is triangles[k].
struct FclBody {
  PartId part;
  std::vector<PosedTriangle> triangles;
  Model model;

  FclBody(const Body& body, bool all_parts, PartId one, const CycleLimit& limit)
      : part(one), triangles(finiteTriangles(body, limit)) {
    const auto isOther = [&](const PosedTriangle& t) { return body.parts[t.index] != one; };
    if (!all_parts && !body.parts.empty()) {
      triangles.erase(std::remove_if(triangles.begin(), triangles.end(), isOther), triangles.end());
    }
    if (triangles.empty() || limit.wasOver()) return;
    model.beginModel(static_cast<int>(triangles.size()), static_cast<int>(3 * triangles.size()));
    for (const PosedTriangle& t : triangles) {
      const auto at = [&t](int k) {
        return fcl::Vector3d(t.posed.v[k].x, t.posed.v[k].y, t.posed.v[k].z);
      };
      model.addTriangle(at(0), at(1), at(2));
    }
    model.endModel();
  }
};

// Runs the same traversal as fcl::collide(), with a limit added.
class Traversal : public fcl::detail::MeshCollisionTraversalNodeOBBRSS<double> {
 public:
  explicit Traversal(const CycleLimit& limit) : pace_(limit, 512) {}
  // FCL asks this between its tests. The clock is read once in 512 times.
  bool canStop() const override { return pace_.over(); }

 private:
  mutable PacedLimit pace_;
};

// Builds a model of each body in every cycle, and collides all enabled pairs.
class FclDetector : public Detector {
 public:
  std::string backend() const override { return "fcl"; }
  void reset() override {}
  void swapResult(DetectionResult& result) override { result_.swap(result); }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    requireValid(options);
    requireInstant(options, backend());
    requireHostVertices(scene, backend());
    if (scene.anyRadius()) {
      throw std::invalid_argument("a body has a radius, which backend \"fcl\" does not know");
    }
    if (scene.anyPartMargin()) {
      throw std::invalid_argument(
          "parts of a body have margins of their own, which backend \"fcl\" does not know");
    }
    const Stopwatch cycle;
    Stopwatch watch;
    const CycleLimit limit(options.limits);
    result_.begin(scene, options, false);

    const Models bodies = modelsOf(scene, options, limit);
    result_.stages_ms.emplace_back("build", watch.lapMs());

    for (const auto& [a, b] : scene.enabledPairs()) {
      for (const auto& [of_a, of_b] : enabledModels(scene, bodies, a, b)) {
        if (!limit.over()) collide(*of_a, a, *of_b, b, limit);
      }
    }
    result_.stages_ms.emplace_back("collide", watch.lapMs());

    std::sort(result_.contacts.begin(), result_.contacts.end());
    // A pair of a body with itself was found from both sides.
    result_.contacts.erase(std::unique(result_.contacts.begin(), result_.contacts.end()),
                           result_.contacts.end());
    if (listsNearPairs(scene, options)) result_.separations_m.assign(result_.contacts.size(), 0);
    writeGeometry(scene, options, result_);
    if (options.nearest) {
      findNearest(scene, options, bodies, limit);
      result_.stages_ms.emplace_back("nearest", watch.lapMs());
    }
    listRejectedParts(scene, options.motion, result_);
    if (limit.wasOver()) result_.cutOff(limit.why());
    result_.detect_ms = result_.round_trip_ms = cycle.elapsedMs();
    return result_;
  }

 private:
  // The models of each body: of all of it, or of each part that is looked at.
  using Models = std::vector<std::vector<std::unique_ptr<FclBody>>>;

  // Builds the models, and counts rejected triangles.
  Models modelsOf(const Scene& scene, const Options& options, const CycleLimit& limit) {
    all_parts_ = !scene.partsMatter() && !options.nearest_by_part;
    const PartTable parts(scene);
    Models models(scene.bodyCount());
    for (BodyId b = 0; b < scene.bodyCount() && !limit.over(); ++b) {
      if (!scene.takesPart(b)) continue;
      const Body& body = scene.body(b);
      std::size_t finite = 0, count = body.mesh.triangleCount();
      const std::vector<PartId> all{0};
      for (const PartId part : all_parts_ ? all : body.listed_parts) {
        const bool is_idle = !all_parts_ && !parts.takesPart(parts.numberOf(b, part));
        if (is_idle) {
          count -= body.parts.empty() ? count
                                      : static_cast<std::size_t>(
                                            std::count(body.parts.begin(), body.parts.end(), part));
          continue;
        }
        models[b].push_back(std::make_unique<FclBody>(body, all_parts_, part, limit));
        finite += models[b].back()->triangles.size();
      }
      result_.counters.posed += body.mesh.triangleCount();
      result_.counters.rejected += count - finite;
    }
    return models;
  }

  // Returns the pairs of models of two bodies, or of one, that are enabled, each once.
  std::vector<std::pair<const FclBody*, const FclBody*>> enabledModels(const Scene& scene,
                                                                       const Models& models,
                                                                       BodyId a, BodyId b) const {
    std::vector<std::pair<const FclBody*, const FclBody*>> pairs;
    for (const auto& of_a : models[a]) {
      for (const auto& of_b : models[b]) {
        if (a == b && of_b->part < of_a->part) continue;
        if (all_parts_ || scene.partPairEnabled(a, of_a->part, b, of_b->part)) {
          pairs.emplace_back(of_a.get(), of_b.get());
        }
      }
    }
    return pairs;
  }

  // Collides two models, or a model with itself, and adds the pairs of triangles.
  void collide(const FclBody& body_a, BodyId a, const FclBody& body_b, BodyId b,
               const CycleLimit& limit) {
    if (body_a.triangles.empty() || body_b.triangles.empty()) return;
    fcl::CollisionRequest<double> request;
    // FCL stops after one contact unless it is asked for all.
    request.num_max_contacts = std::numeric_limits<std::size_t>::max();
    fcl::CollisionResult<double> found;
    const fcl::Transform3d identity = fcl::Transform3d::Identity();
    Traversal traversal(limit);
    fcl::detail::initialize(traversal, body_a.model, identity, body_b.model, identity, request,
                            found);
    fcl::detail::collide(&traversal);
    for (std::size_t i = 0; i < found.numContacts(); ++i) {
      const fcl::Contact<double>& contact = found.getContact(i);
      const PosedTriangle* first = &body_a.triangles[static_cast<std::size_t>(contact.b1)];
      const PosedTriangle* second = &body_b.triangles[static_cast<std::size_t>(contact.b2)];
      if (a == b) {
        // FCL visits each pair of a model with itself twice, and each triangle with itself.
        if (first == second || sharedVertices(first->received, second->received).any) continue;
        if (second->index < first->index) std::swap(first, second);
      }
      result_.contacts.push_back({a, first->index, b, second->index});
    }
  }

  // Adds the nearest pairs: of bodies that collide, their first contact; of others what FCL finds
  // nearest, with the distance of these two triangles. FCL may take other triangles at about the
  // same distance. Parts that collide have a distance of 0, and any contact.
  void findNearest(const Scene& scene, const Options& options, const Models& bodies,
                   const CycleLimit& limit) {
    const std::vector<NearestPair> touching = touchingPairs(scene, result_);
    auto next = touching.begin();
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a == b || limit.over()) continue;
      const bool touch = next != touching.end() && next->pair.body_a == a && next->pair.body_b == b;
      std::optional<NearestPair> nearest;
      if (touch) nearest = *next++;
      const bool named = !scene.body(a).parts.empty() || !scene.body(b).parts.empty();
      const bool by_part = options.nearest_by_part && named;
      for (const auto& [of_a, of_b] : enabledModels(scene, bodies, a, b)) {
        if (touch && !by_part) break;
        const auto found = nearestOf(scene, *of_a, a, *of_b, b);
        if (!found) continue;
        if (!nearest || found->distance_m < nearest->distance_m) nearest = found;
        if (by_part) result_.nearest_parts.push_back({{a, b, of_a->part, of_b->part}, *found});
      }
      if (nearest) result_.nearest.push_back(*nearest);
    }
    std::sort(result_.nearest_parts.begin(), result_.nearest_parts.end(),
              [](const NearestOfParts& x, const NearestOfParts& y) { return x.parts < y.parts; });
  }

  // Returns the nearest triangles of two models, if they are within the margin.
  static std::optional<NearestPair> nearestOf(const Scene& scene, const FclBody& of_a, BodyId a,
                                              const FclBody& of_b, BodyId b) {
    if (of_a.triangles.empty() || of_b.triangles.empty()) return std::nullopt;
    const fcl::Transform3d identity = fcl::Transform3d::Identity();
    const fcl::DistanceRequest<double> request;
    fcl::DistanceResult<double> found;
    fcl::distance(&of_a.model, identity, &of_b.model, identity, request, found);
    if (found.b1 < 0 || found.b2 < 0) return std::nullopt;
    const PosedTriangle& first = of_a.triangles[static_cast<std::size_t>(found.b1)];
    const PosedTriangle& second = of_b.triangles[static_cast<std::size_t>(found.b2)];
    PredicateState state{Predicates::kExact};
    const bool meet = trianglesIntersect(first.posed, second.posed, state);
    const float distance_m = meet ? 0 : comparedDistance(separation(first.posed, second.posed));
    if (distance_m > pairMargin(scene.body(a).margin_m, scene.body(b).margin_m)) {
      return std::nullopt;
    }
    return nearestPairOf(scene, {a, first.index, b, second.index}, distance_m);
  }

  bool all_parts_ = true;  // parts do not matter in this cycle
  DetectionResult result_;
};

}  // namespace

std::unique_ptr<Detector> makeFclDetector() { return std::make_unique<FclDetector>(); }

}  // namespace deformable_contact_monitor
