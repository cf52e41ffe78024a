// A device of several, without a device: the CPU finds all contacts, and those of the partition are
// kept, by the rule that the devices have.
#pragma once

#include <cstdint>
#include <memory>
#include <memory_resource>
#include <string>
#include <utility>
#include <vector>

#include "core/common/posed_body.h"
#include "core/cpu_detector.h"
#include "core/rules/margins.h"
#include "core/rules/posed_vertex.h"
#include "cuda/partitions/partitioned_detector.h"

namespace deformable_contact_monitor {

class PartitionStandIn : public PartitionDetector {
 public:
  std::string backend() const override { return "stand-in"; }
  void reset() override { all_->reset(); }
  void swapResult(DetectionResult& result) override { result_.swap(result); }
  std::pmr::memory_resource& vertexMemory() override {
    static std::pmr::synchronized_pool_resource memory;
    return memory;
  }
  void setPartition(const ScenePartition& partition) override { partition_ = partition; }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    result_ = all_->detect(scene, options);
    const std::vector<TrianglePair> all = result_.contacts;
    const auto keep = [&](auto& list) {
      if (list.size() != all.size()) return;
      std::size_t kept = 0;
      for (std::size_t i = 0; i < all.size(); ++i) {
        if (isHere(scene, options, all[i])) list[kept++] = list[i];
      }
      list.resize(kept);
    };
    keep(result_.contacts);
    keep(result_.separations_m);
    keep(result_.geometry);
    keep(result_.first_times);
    keep(result_.within_pad);
    return result_;
  }

 private:
  static Triangle posed(const Body& body, const RigidTransform& pose, const float* xyz,
                        std::uint32_t triangle) {
    Triangle t;
    for (std::size_t k = 0; k < 3; ++k) {
      const float* v = xyz + std::size_t{3} * body.mesh.triangles[3 * std::size_t{triangle} + k];
      t.v[k] = posedVertex(pose, pose.isIdentity(), {v[0], v[1], v[2]});
    }
    return t;
  }

  static Aabb boxIn(const Scene& scene, const Options& options, BodyId id, std::uint32_t triangle) {
    const Body& body = scene.body(id);
    const float* const xyz = body.mesh.vertices.data();
    const Aabb now = boxOf(posed(body, body.pose, xyz, triangle));
    if (options.motion == Motion::kInstant) return inflated(now, body.margin_m);
    Aabb then = now;
    if (body.earlier) {
      const bool has_own = !body.earlier->vertices.empty();
      then = boxOf(
          posed(body, body.earlier->pose, has_own ? body.earlier->vertices.data() : xyz, triangle));
    }
    return partitionBox({then, now}, grownPad(body.pad_m));
  }

  bool isHere(const Scene& scene, const Options& options, const TrianglePair& pair) const {
    return partition_.owns(boxIn(scene, options, pair.body_a, pair.triangle_a),
                           boxIn(scene, options, pair.body_b, pair.triangle_b));
  }

  std::unique_ptr<Detector> all_ = makeCpuDetector();
  ScenePartition partition_;
  DetectionResult result_;
};

}  // namespace deformable_contact_monitor
