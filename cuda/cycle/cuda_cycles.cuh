// The CUDA backend: one detector's arrays, graphs and cycles.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "core/common/stopwatch.h"
#include "core/rules/cluster_count.h"
#include "cuda/cuda_detector.h"
#include "cuda/cycle/cold_start.h"
#include "cuda/cycle/cycle_graph.cuh"
#include "cuda/cycle/open_pairs.cuh"
#include "cuda/memory/device_scene.cuh"
#include "cuda/memory/host_copy.cuh"
#include "cuda/memory/host_stop.cuh"
#include "cuda/memory/pinned_memory.cuh"
#include "cuda/partitions/partition_detector.h"
#include "cuda/stages/output.cuh"

namespace deformable_contact_monitor {

class CudaDetector : public ShareDetector {
 public:
  explicit CudaDetector(const CudaSettings& settings)
      : settings_(settings),
        device_(DeviceTraits::of(settings.device)),
        cluster_counts_{3000, 8192, 100000, device_.multiprocessors} {
    result_.contacts.moveTo(pinnedMemory());
    arrays_.host_counters.pointTo(counters_.data());
    arrays_.host_stop.pointTo(stop_.word());
  }
  ~CudaDetector() override {
    cudaSetDevice(settings_.device);
    stop_.set();
    cudaStreamSynchronize(stream_.get());
  }
  std::string backend() const override { return "cuda"; }
  void reset() override { cold_ = true; }
  std::pmr::memory_resource& vertexMemory() override { return lentMemory(); }
  void setShare(const SceneShare& share) override { share_ = share; }
  const DetectionResult& detect(const Scene& scene, const Options& options) override;

 private:
  void findContacts(const Scene& scene, const Options& options, const CycleLimit& limit,
                    const Stopwatch& watch);
  bool upload(const Scene& scene, const Options& options, const CycleLimit& limit);
  bool adaptTo(const Scene& scene, const DeviceScene::Change& change, const Options& options,
               const CycleLimit& limit, ColdStart& start);
  ColdStart look(const Scene& scene, const Options& options, const CycleLimit& limit, Look how);
  void setParams(const Options& options, const CycleLimit& limit);
  void group(const Scene& scene, const Options& options, bool any_new);
  bool isToBeLookedAt(const DeviceScene::Change& change);
  bool isAlike(const ColdStart& start, const DeviceScene::Change& change,
               const Options& options) const;
  void startCold(const ColdStart& start, const Options& options);
  void makeArrays();
  void addParams();
  void startCycle(const CycleShape& shape);
  void sizeBins(const Options& options, bool new_clusters);
  void runCycle(const Options& options);
  bool runUntilItFits(const Options& options, const CycleLimit& limit);
  bool runInPasses(const Options& options, const CycleLimit& limit);
  bool isCutOff(const CycleLimit& limit) const;
  bool makeRoom();
  bool sweepInPasses(const Options& options, const CycleLimit& limit);
  void fetchContacts(const Options& options, bool few);
  void completeContacts(const CycleLimit& limit);
  void decideOpenPairs(const Options& options, const CycleLimit& limit);
  CycleShape shapeOf(const Options& options, int refinements) const;
  void wait(const CycleLimit& limit) { stop_.wait(stream_, limit); }
  std::uint32_t listable(std::uint64_t contacts) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(contacts, sizes_.contacts));
  }
  void noteGrowth(const CycleCounters& counted, const Options& options);

  CudaSettings settings_;
  const DeviceTraits device_;
  const ClusterCountPolicy cluster_counts_;
  CudaStream stream_;
  HostCopies copies_{stream_.get()};  // of this cycle, as many as can wait for its first launch
  CudaEvent cycle_start_, cycle_end_;
  DeviceMemory memory_;
  CycleSizes sizes_;
  CycleArrays arrays_{memory_};
  DeviceScene scene_{settings_.device, memory_, sizes_, arrays_.scene};
  CycleGraph graphs_[2];  // with and without refinement of the prototypes
  PinnedBuffer<CycleParams> params_{1};
  CycleParams sent_params_;
  bool params_sent_ = false;  // sent_params_ are on the device
  PinnedBuffer<CycleCounters> counters_{1};
  HostStop stop_;
  ContactOutput output_{8 * device_.multiprocessors};
  OpenPairs open_pairs_;     // in swept motion
  double decide_ms_ = 0;     // what they took in this cycle
  double earlier_ms_ = 0;    // of the device, for tries of this cycle that did not fit
  bool all_decided_ = true;  // no limit was over before or while they were
  SceneMeasurer measurer_;
  bool sample_misled_ = false;  // in the last cycle
  SceneScale scale_;
  SizeRule size_rule_;
  SceneShare share_;
  bool cold_ = true;
  Motion motion_ = Motion::kInstant;   // of the last cycle
  std::uint32_t wanted_clusters_ = 0;  // by what the last cycle found
  int asked_clusters_ = 0;             // by the options of the last cold start
  std::uint32_t large_at_start_ = 0;
  std::uint64_t come_and_gone_ = 0;  // triangles, since the scene was looked at
  std::uint64_t last_contacts_ = 0;
  int cycles_since_refresh_ = 0;
  DetectionResult result_;
};

}  // namespace deformable_contact_monitor
