#include "fcl_distance.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/distance.h>

#include <algorithm>
#include <cstddef>
#include <limits>

#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

std::vector<fcl::Vector3d> verticesOf(const Body& body) {
  const PosedBody posed(body);
  std::vector<fcl::Vector3d> vertices;
  vertices.reserve(body.mesh.vertexCount());
  for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
    const Vec3f v = posed.vertex(i);
    vertices.emplace_back(v.x, v.y, v.z);
  }
  return vertices;
}

std::unique_ptr<Model> modelOf(const Body& body) {
  auto model = std::make_unique<Model>();
  std::vector<fcl::Triangle> triangles;
  for (std::size_t t = 0; t < body.mesh.triangleCount(); ++t) {
    const std::uint32_t* corner = &body.mesh.triangles[3 * t];
    triangles.emplace_back(corner[0], corner[1], corner[2]);
  }
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(body.mesh.vertexCount()));
  model->addSubModel(verticesOf(body), triangles);
  model->endModel();
  return model;
}

}  // namespace

struct FclDistance::Models {
  std::vector<std::unique_ptr<Model>> of_body;
};

FclDistance::FclDistance(const Scene& scene, FclTree tree)
    : tree_(tree), models_(std::make_unique<Models>()) {
  for (const Body& body : scene.bodies()) models_->of_body.push_back(modelOf(body));
}

FclDistance::~FclDistance() = default;

double FclDistance::leastDistance(const Scene& scene, const std::vector<BodyId>& moved) {
  for (const BodyId id : moved) {
    std::unique_ptr<Model>& model = models_->of_body[id];
    if (tree_ == FclTree::kRebuilt) {
      model = modelOf(scene.body(id));
      continue;
    }
    model->beginReplaceModel();
    model->replaceSubModel(verticesOf(scene.body(id)));
    model->endReplaceModel(true, tree_ == FclTree::kRefitBottomUp);
  }
  double least_m = std::numeric_limits<double>::infinity();
  const fcl::Transform3d identity = fcl::Transform3d::Identity();
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a == b) continue;
    fcl::DistanceRequest<double> request;
    fcl::DistanceResult<double> result;
    fcl::distance(models_->of_body[a].get(), identity, models_->of_body[b].get(), identity, request,
                  result);
    least_m = std::min(least_m, result.min_distance);
  }
  return least_m;
}

}  // namespace deformable_contact_monitor
