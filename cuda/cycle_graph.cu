#include "cuda/cycle_graph.cuh"
#include "cuda/stages/stages.cuh"

namespace deformable_contact_monitor {
namespace {

void refine(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream) {
  for (int i = 0; i < shape.refinements; ++i) {
    launchMovePrototypes(cycle, stream);
    launchListNeighbours(cycle, stream);
  }
}

}  // namespace

void CycleGraph::forget() {
  if (graph_ != nullptr) cudaGraphExecDestroy(graph_);
  graph_ = nullptr;
}

void CycleGraph::prepare(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (graph_ != nullptr && shape == shape_) return;
  forget();
  shape_ = shape;
  // Other threads' detectors may allocate meanwhile.
  checkCuda(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal),
            "cudaStreamBeginCapture");
  cudaGraph_t recorded = nullptr;
  try {
    enqueue(cycle, shape, stream);
  } catch (...) {  // a stream that went on recording would fail for ever
    cudaStreamEndCapture(stream, &recorded);
    cudaGraphDestroy(recorded);
    throw;
  }
  checkCuda(cudaStreamEndCapture(stream, &recorded), "cudaStreamEndCapture");
  const cudaError_t status = cudaGraphInstantiate(&graph_, recorded, 0);
  cudaGraphDestroy(recorded);
  checkCuda(status, "cudaGraphInstantiate");
}

void CycleGraph::enqueue(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream) {
  if (shape.identify) {
    started_.record(stream);
    started_.makeWait(identity_branch_.get());
    launchIdentify(cycle, identity_branch_.get());
    identified_.record(identity_branch_.get());
  }
  launchPose(cycle, shape.device, stream);
  launchAssign(cycle, shape.device, stream);
  assigned_.record(stream);
  assigned_.makeWait(adapt_branch_.get());
  launchSizeBins(cycle, adapt_branch_.get());
  sized_.record(adapt_branch_.get());
  if (shape.identify) identified_.makeWait(stream);
  launchSort(cycle, stream);
  sorted_.record(stream);
  sorted_.makeWait(large_branch_.get());
  launchLarge(cycle, large_branch_.get());
  large_done_.record(large_branch_.get());
  refine(cycle, shape, adapt_branch_.get());
  sorted_.makeWait(adapt_branch_.get());
  launchFrames(cycle, adapt_branch_.get());
  adapted_.record(adapt_branch_.get());
  launchSweep(cycle, shape.device, stream);
  large_done_.makeWait(stream);
  sized_.makeWait(stream);
  launchJudge(cycle, shape.device, stream);
  adapted_.makeWait(stream);
}

void CycleGraph::launch(cudaStream_t stream) {
  checkCuda(cudaGraphLaunch(graph_, stream), "cudaGraphLaunch");
}

void CycleGraph::runTimed(const CycleView& cycle, const CycleShape& shape, cudaStream_t stream) {
  mark_[0].record(stream);
  launchPose(cycle, shape.device, stream);
  mark_[1].record(stream);
  launchAssign(cycle, shape.device, stream);
  mark_[2].record(stream);
  if (shape.identify) launchIdentify(cycle, stream);
  mark_[3].record(stream);
  launchSort(cycle, stream);
  mark_[4].record(stream);
  launchSweep(cycle, shape.device, stream);
  mark_[5].record(stream);
  launchLarge(cycle, stream);
  launchSizeBins(cycle, stream);
  mark_[6].record(stream);
  launchJudge(cycle, shape.device, stream);
  mark_[7].record(stream);
  refine(cycle, shape, stream);
  launchFrames(cycle, stream);
  mark_[8].record(stream);
  checkCuda(cudaGetLastError(), "a stage of the cycle");
}

std::vector<std::pair<std::string, double>> CycleGraph::times() const {
  constexpr const char* kNames[kStages] = {"pose",  "assign", "identify", "sort",
                                           "sweep", "large",  "judge",    "adapt"};
  std::vector<std::pair<std::string, double>> times;
  for (int i = 0; i < kStages; ++i) {
    times.emplace_back(kNames[i], CudaEvent::between(mark_[i], mark_[i + 1]));
  }
  return times;
}

}  // namespace deformable_contact_monitor
