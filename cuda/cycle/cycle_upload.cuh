// Brings the scene and the settings of a cycle to the device.
#pragma once

#include "core/common/cycle_limit.h"
#include "core/detector.h"
#include "cuda/cycle/cold_start.h"
#include "cuda/cycle/device_cycle.cuh"
#include "cuda/cycle/scene_inspector.cuh"

namespace deformable_contact_monitor {

// Belongs to one detector. After send() has returned true, the device has everything that a cycle
// reads: scene, tiles, prototypes, settings, and arrays of sufficient size.
class CycleUpload {
 public:
  explicit CycleUpload(DeviceCycle& cycle)
      : cycle_(cycle), inspector_({4000, 8192, 100000, cycle.device.multiprocessors}) {}

  // Makes the next cycle a cold start, which uses nothing of earlier scenes.
  void reset() { inspector_.startColdNext(); }
  // Restricts the next cycles to the pairs of a partition of the scene.
  void setPartition(const ScenePartition& partition) { partition_ = partition; }

  // Enqueues the upload of the scene and sets result.started_cold. Returns false if there is
  // nothing to detect or the limit was over. Throws CudaError, and std::invalid_argument if device
  // vertices cannot be read.
  bool send(const Scene& scene, const Options& options, const CycleLimit& limit,
            DetectionResult& result);

  // Decides after a cycle how the next one begins (SceneInspector::endCycle()).
  void endCycle(const Options& options, bool started_cold);
  // Rebuilds the tiles if bodies may have deformed, unless the next cycle is a cold start anyway.
  // Call it when the result is complete and nobody waits for the stream, because it takes device
  // time.
  void endDetection();

 private:
  bool inspectAndSend(const Scene& scene, const DeviceScene::Change& change, const Options& options,
                      const CycleLimit& limit, bool& started_cold, ColdStart& start);
  bool adapt(const Scene& scene, const DeviceScene::Change& change, const Options& options,
             const CycleLimit& limit, bool& started_cold, ColdStart& start);
  void setParams(const Options& options, const CycleLimit& limit);
  void sendBodiesAndMakeTiles(const Scene& scene, const Options& options, bool any_new);
  void sendSeeds(const ColdStart& start, const Options& options);
  void sizeBins(const Options& options, bool new_clusters);

  DeviceCycle& cycle_;
  SceneInspector inspector_;
  ScenePartition partition_;
};

}  // namespace deformable_contact_monitor
