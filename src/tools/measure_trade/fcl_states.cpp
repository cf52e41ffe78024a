#include "tools/measure_trade/state_measurement.h"

#ifdef DCM_HAVE_FCL
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/math/bv/OBBRSS.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <map>
#include <vector>

#include "core/common/stopwatch.h"
#endif

namespace deformable_contact_monitor {

#ifdef DCM_HAVE_FCL
namespace {

using Model = fcl::BVHModel<fcl::OBBRSS<double>>;

std::unique_ptr<Model> modelOf(const Body& body) {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
  for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
    const Vec3f v = body.mesh.vertex(i);
    vertices.emplace_back(v.x, v.y, v.z);
  }
  for (std::size_t t = 0; t < body.mesh.triangleCount(); ++t) {
    const std::uint32_t* corner = &body.mesh.triangles[3 * t];
    triangles.emplace_back(corner[0], corner[1], corner[2]);
  }
  auto model = std::make_unique<Model>();
  model->beginModel(static_cast<int>(triangles.size()), static_cast<int>(vertices.size()));
  model->addSubModel(vertices, triangles);
  model->endModel();
  return model;
}

fcl::Transform3d toFcl(const RigidTransform& pose) {
  fcl::Transform3d out = fcl::Transform3d::Identity();
  out.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(pose.rotation);
  out.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation);
  return out;
}

class FclStateChecker : public StateChecker {
 public:
  std::string backend() const override { return "fcl"; }
  void reset() override { models_.clear(); }

  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& /*options*/) override {
    const auto isMoved = [&batch](BodyId id) {
      return std::find(batch.moved.begin(), batch.moved.end(), id) != batch.moved.end();
    };
    std::vector<std::pair<BodyId, BodyId>> pairs;
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a == b || (!isMoved(a) && !isMoved(b))) continue;
      pairs.emplace_back(a, b);
      for (const BodyId id : {a, b}) {
        std::unique_ptr<Model>& model = models_[scene.body(id).vertices_revision];
        if (model == nullptr) model = modelOf(scene.body(id));
      }
    }
    const Stopwatch watch;  // models are made once
    std::vector<const Model*> models;
    std::vector<fcl::Transform3d> poses;
    for (const Body& body : scene.bodies()) {
      const auto found = models_.find(body.vertices_revision);
      models.push_back(found == models_.end() ? nullptr : found->second.get());
      poses.push_back(toFcl(body.pose));
    }
    results_ = StateResults();
    results_.states.resize(batch.count);
    for (std::size_t state = 0; state < batch.count; ++state) {
      for (std::size_t i = 0; i < batch.moved.size(); ++i) {
        poses[batch.moved[i]] = toFcl(batch.poses[state * batch.moved.size() + i]);
      }
      const bool touch = std::any_of(pairs.begin(), pairs.end(), [&](const auto& pair) {
        const fcl::CollisionRequest<double> first_contact;
        fcl::CollisionResult<double> result;
        return fcl::collide(models[pair.first], poses[pair.first], models[pair.second],
                            poses[pair.second], first_contact, result) > 0;
      });
      results_.states[state].decision = touch ? PairDecision::kContact : PairDecision::kNone;
    }
    results_.check_ms = watch.elapsedMs();
    return results_;
  }

 private:
  std::map<std::uint64_t, std::unique_ptr<Model>> models_;  // by Body::vertices_revision
  StateResults results_;
};

}  // namespace

std::unique_ptr<StateChecker> makeFclStateChecker() { return std::make_unique<FclStateChecker>(); }
#else
std::unique_ptr<StateChecker> makeFclStateChecker() { return nullptr; }
#endif

}  // namespace deformable_contact_monitor
