// Decides whether a cycle continues from the last one or starts cold, and with which clusters,
// scale and sizes. It inspects the scene on the host when the scene's bodies have changed.
#pragma once

#include <cstdint>

#include "core/common/cycle_limit.h"
#include "core/options.h"
#include "core/predicates/aabb.h"
#include "core/rules/clustering.h"
#include "core/rules/scene_scale.h"
#include "cuda/cycle/cold_start.h"
#include "cuda/memory/cycle_sizes.cuh"
#include "cuda/memory/device_scene.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector. Each cycle calls beginCycle() first and endCycle() last. If a cycle
// throws in between, the state of the device is unknown, so the next cycle starts cold.
class SceneInspector {
 public:
  explicit SceneInspector(const ClusterCountPolicy& policy) : policy_(policy) {}

  // Returns whether the next cycle starts cold for every scene.
  bool isCold() const { return cold_; }
  void startColdNext() { cold_ = true; }
  // Returns whether a cycle with these options must start cold. It must also do so if the motion or
  // the requested number of clusters has changed.
  bool isColdFor(const Options& options) const;

  // Notes that a cycle begins; until endCycle() the state counts as cold.
  void beginCycle(const Options& options);

  // Returns whether a change of the layout needs an inspection. Small changes add up until one is
  // made.
  bool needsInspection(const DeviceScene::Change& change, std::uint32_t triangles);

  // Measures the scene on the host; see SceneMeasurer. The result is meaningless if the limit was
  // over.
  ColdStart inspect(const Scene& scene, const ScenePartition& partition, const Options& options,
                    const CycleLimit& limit, Inspection inspection);

  // The inputs of adapt().
  struct Inspected {
    const Scene& scene;
    const ScenePartition& partition;
    const DeviceScene::Change& change;
    std::uint32_t triangles;  // on the device
  };
  // Decides whether to start cold, unless `started_cold` is set already, and sets the rules and
  // sizes for the inspected scene. `start` is the result of a brief inspection, or has no seeds if
  // there was none; on return it is the inspection that was used. Returns false if the limit was
  // over.
  bool adapt(const Inspected& inspected, const Options& options, const CycleLimit& limit,
             std::uint64_t memory_limit_bytes, bool& started_cold, ColdStart& start,
             CycleSizes& sizes);

  // Records that the prototypes are the seeds of `start`, in the scale of `start`, which becomes
  // the frame too.
  void setSeeds(const ColdStart& start, const Options& options);

  // Decides after a cycle how the next one begins, and moves the frame. If many more triangles are
  // oversized than at the last inspection, the next cycle starts cold. If the scene needs another
  // number of clusters, it gets new ones from samples of this cycle, or starts cold if these are
  // too few. `samples`: the number of samples that were taken.
  void endCycle(const CycleCounters& counted, const Options& options, std::uint32_t clusters,
                std::uint32_t samples, std::uint32_t triangles, bool started_cold);

  // Returns the number of clusters that the scene of the last cycle needs.
  std::uint32_t wantedClusters() const { return wanted_clusters_; }
  const SceneScale& scale() const { return scale_; }
  // Returns the scale for the frames of rounded boxes: it brings most of what was live in the last
  // cycles into [-0.4, 0.4]. It follows a scene that moves or changes its size.
  const SceneScale& frame() const { return frame_; }
  const SizeRule& sizeRule() const { return size_rule_; }

 private:
  void moveFrame(const Aabb& tiles);
  bool isAlike(const ColdStart& start, const Inspected& inspected, const Options& options,
               std::uint32_t clusters) const;

  const ClusterCountPolicy policy_;
  SceneMeasurer measurer_;
  SceneScale scale_, frame_;
  Aabb covered_;  // by the tiles of the last cycles [m]
  SizeRule size_rule_;
  bool cold_ = true;
  bool sample_unrepresentative_ = false;  // the last cold start's sample misjudged the scene
  Motion motion_ = Motion::kInstant;      // of the last cycle
  std::uint32_t wanted_clusters_ = 0;
  int asked_clusters_ = 0;  // Options::clusters of the last cold start
  std::uint32_t oversized_at_start_ = 0;
  std::uint64_t changed_triangles_ = 0;  // since the last inspection
};

}  // namespace deformable_contact_monitor
