#include <type_traits>

#include "cuda/cycle/cycle_graph.cuh"

namespace deformable_contact_monitor {
namespace {

enum StepNumber {
  kIdentities,
  kPose,
  kAssign,
  kIds,
  kBins,
  kSort,
  kLarge,
  kCluster,
  kFrames,
  kSweep,
  kPairs,
  kJudge,
  kStepCount
};

// Where a step runs: on the cycle's own stream, or beside it.
enum Branch { kMain = -1, kIdentityBranch, kAdaptBranch, kLargeBranch, kBranchCount };

constexpr unsigned behind(StepNumber step) { return 1U << step; }

struct Step {
  Stage stage;
  Launch launch;
  Branch branch;
  unsigned behind;  // steps of other branches that must be over; those ahead on its own are
};

// A cycle, in an order in which the steps may also run one after the other. On its stream
// launchAssign stands right behind launchPose, launchSweep behind launchSort, launchPairs behind
// launchSweep, and launchPoseIds behind launchPoseIdentities, for they start early.
constexpr Step kList[kStepCount] = {
    {Stage::kTransform, launchPoseIdentities, kIdentityBranch, 0},
    {Stage::kTransform, launchPose, kMain, 0},
    {Stage::kAssign, launchAssign, kMain, 0},
    {Stage::kTransform, launchPoseIds, kIdentityBranch, 0},
    {Stage::kAssign, launchAssignBins, kAdaptBranch, behind(kAssign)},
    {Stage::kSort, launchSort, kMain, 0},
    {Stage::kOversized, launchLarge, kLargeBranch, behind(kSort) | behind(kIds)},
    {Stage::kCluster, launchCluster, kAdaptBranch, 0},
    {Stage::kSort, launchSortFrames, kAdaptBranch, behind(kSort)},
    {Stage::kSweep, launchSweep, kMain, 0},
    {Stage::kSweep, launchPairs, kMain, behind(kIds)},
    {Stage::kNarrowPhase, launchJudge, kMain, behind(kLarge) | behind(kBins)},
};

// Steps whose end somebody on another branch waits for.
constexpr unsigned awaited() {
  unsigned steps = behind(kFrames);  // the end of the cycle does
  for (const Step& step : kList) steps |= step.behind;
  return steps;
}

// They hold addresses and numbers alone.
std::vector<unsigned char> bytesOf(const CycleArrays& cycle) {
  static_assert(std::is_trivially_copyable_v<CycleArrays>);
  const auto* bytes = reinterpret_cast<const unsigned char*>(&cycle);
  return {bytes, bytes + sizeof cycle};
}

std::size_t nodesOf(cudaGraph_t graph) {
  std::size_t nodes = 0;
  checkCuda(cudaGraphGetNodes(graph, nullptr, &nodes), "cudaGraphGetNodes");
  return nodes;
}

}  // namespace

void CycleGraph::forget() {
  if (graph_ != nullptr) cudaGraphExecDestroy(graph_);
  graph_ = nullptr;
}

bool CycleGraph::isLast(const CycleArrays& cycle, const CycleShape& shape) const {
  return shape == shape_ && arrays_ == bytesOf(cycle);
}

void CycleGraph::run(const CycleArrays& cycle, const CycleShape& shape, CudaEvent& start,
                     cudaStream_t stream) {
  if (!isLast(cycle, shape)) {
    arrays_ = bytesOf(cycle);
    shape_ = shape;
    is_recorded_ = false;
    start.record(stream);
    enqueue(cycle, shape, stream);
    return;
  }
  if (!is_recorded_) record(cycle, shape, stream);
  start.record(stream);
  checkCuda(cudaGraphLaunch(graph_, stream), "cudaGraphLaunch");
}

void CycleGraph::record(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
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
  cudaError_t status = cudaSuccess;
  if (!update(recorded)) {
    forget();
    status = cudaGraphInstantiateWithFlags(&graph_, recorded, 0);
  }
  graph_nodes_ = nodesOf(recorded);
  cudaGraphDestroy(recorded);
  checkCuda(status, "cudaGraphInstantiateWithFlags");
  graph_shape_ = shape_;
  is_recorded_ = true;
}

// Where the steps are the same, only their arguments have to be changed; false if they are not. By
// their number scenes with and without clusters are told apart: the driver would call it an error.
bool CycleGraph::update(cudaGraph_t recorded) const {
  if (graph_ == nullptr || !(graph_shape_ == shape_)) return false;
  if (nodesOf(recorded) != graph_nodes_) return false;
#if CUDART_VERSION >= 12000
  cudaGraphExecUpdateResultInfo result{};
  const cudaError_t status = cudaGraphExecUpdate(graph_, recorded, &result);
#else
  cudaGraphNode_t node = nullptr;
  cudaGraphExecUpdateResult result{};
  const cudaError_t status = cudaGraphExecUpdate(graph_, recorded, &node, &result);
#endif
  if (status == cudaSuccess) return true;
  cudaGetLastError();  // another graph: no error
  return false;
}

void CycleGraph::enqueue(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  static_assert(kStepCount == kSteps && kBranchCount == kBranches);
  started_.record(stream);
  unsigned forked = 0;
  for (int s = 0; s < kStepCount; ++s) {
    const Step& step = kList[s];
    cudaStream_t on = stream;
    if (step.branch != kMain) {
      on = branch_[step.branch].get();
      if ((forked >> step.branch & 1) == 0 && step.behind == 0) started_.makeWait(on);
      forked |= 1U << step.branch;
    }
    for (int other = 0; other < s; ++other) {
      if ((step.behind >> other & 1) != 0) done_[other].makeWait(on);
    }
    step.launch(cycle, shape, on);
    if ((awaited() >> s & 1) != 0) done_[s].record(on);
  }
  done_[kFrames].makeWait(stream);
}

void CycleGraph::runTimed(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  for (int s = 0; s < kStepCount; ++s) {
    mark_[s].record(stream);
    kList[s].launch(cycle, shape, stream);
  }
  mark_[kStepCount].record(stream);
  checkCuda(cudaGetLastError(), "a stage of the cycle");
}

StageTimes CycleGraph::times() const {
  StageTimes times;
  for (int s = 0; s < kStepCount; ++s) {
    times.add(kList[s].stage, CudaEvent::between(mark_[s], mark_[s + 1]));
  }
  return times;
}

}  // namespace deformable_contact_monitor
