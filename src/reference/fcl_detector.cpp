// Uses FCL's bounding volume hierarchies behind the detector's interface. Each cycle builds a model
// of every body from its posed triangles and collides the models of all enabled pairs. It does not
// refit the models of the last cycle, so its time includes building them.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/detail/traversal/collision/mesh_collision_traversal_node.h>
#include <fcl/narrowphase/detail/traversal/collision_node.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "core/common/contact_geometry.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/predicates/triangle_distance.h"
#include "core/rules/margins.h"
#include "core/rules/nearest.h"
#include "reference/posed_triangles.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

// Holds one body's finite triangles and FCL's model of them. FCL's triangle k is triangles[k].
struct FclBody {
  std::vector<PosedTriangle> triangles;
  Model model;

  FclBody(const Body& body, const CycleLimit& limit) : triangles(finiteTriangles(body, limit)) {
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
    const Stopwatch cycle;
    Stopwatch watch;
    const CycleLimit limit(options.limits);
    result_.begin(scene, options, false);

    std::vector<std::unique_ptr<FclBody>> bodies;
    for (BodyId b = 0; b < scene.bodyCount() && !limit.over(); ++b) {
      if (!scene.takesPart(b)) {
        bodies.push_back(nullptr);
        continue;
      }
      const Body& body = scene.body(b);
      bodies.push_back(std::make_unique<FclBody>(body, limit));
      result_.counters.posed += body.mesh.triangleCount();
      result_.counters.rejected += body.mesh.triangleCount() - bodies[b]->triangles.size();
    }
    result_.stages_ms.emplace_back("build", watch.lapMs());

    for (BodyId a = 0; a < scene.bodyCount(); ++a) {
      for (BodyId b = a; b < scene.bodyCount() && !limit.over(); ++b) {
        if (scene.pairEnabled(a, b)) collide(*bodies[a], a, *bodies[b], b, limit);
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
      findNearest(scene, bodies, limit);
      result_.stages_ms.emplace_back("nearest", watch.lapMs());
    }
    if (limit.wasOver()) result_.cutOff(limit.why());
    result_.detect_ms = result_.round_trip_ms = cycle.elapsedMs();
    return result_;
  }

 private:
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
  // same distance.
  void findNearest(const Scene& scene, const std::vector<std::unique_ptr<FclBody>>& bodies,
                   const CycleLimit& limit) {
    const std::vector<NearestPair> touching = touchingPairs(scene, result_);
    auto next = touching.begin();
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a == b || limit.over()) continue;
      if (next != touching.end() && next->pair.body_a == a && next->pair.body_b == b) {
        result_.nearest.push_back(*next++);
        continue;
      }
      const FclBody &of_a = *bodies[a], &of_b = *bodies[b];
      if (of_a.triangles.empty() || of_b.triangles.empty()) continue;
      const fcl::Transform3d identity = fcl::Transform3d::Identity();
      const fcl::DistanceRequest<double> request;
      fcl::DistanceResult<double> found;
      fcl::distance(&of_a.model, identity, &of_b.model, identity, request, found);
      if (found.b1 < 0 || found.b2 < 0) continue;
      const PosedTriangle& first = of_a.triangles[static_cast<std::size_t>(found.b1)];
      const PosedTriangle& second = of_b.triangles[static_cast<std::size_t>(found.b2)];
      const float distance_m = comparedDistance(separation(first.posed, second.posed));
      if (distance_m > pairMargin(scene.body(a).margin_m, scene.body(b).margin_m)) continue;
      result_.nearest.push_back(
          nearestPairOf(scene, {a, first.index, b, second.index}, distance_m));
    }
  }

  DetectionResult result_;
};

}  // namespace

std::unique_ptr<Detector> makeFclDetector() { return std::make_unique<FclDetector>(); }

}  // namespace deformable_contact_monitor
