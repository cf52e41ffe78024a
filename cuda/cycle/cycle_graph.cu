// Enqueues the steps of a cycle on one main stream and four branches, and records them as a CUDA
// graph. The steps that can run side by side are on different branches; events order them.
#include <type_traits>

#include "cuda/cycle/cycle_graph.cuh"

namespace deformable_contact_monitor {
namespace {

enum StepNumber {
  kVertexIdentities,
  kTransform,
  kAssign,
  kEntryIds,
  kBins,
  kSort,
  kOversized,
  kCluster,
  kFrames,
  kSweep,
  kSweepTriangles,
  kNarrowPhase,
  kNearest,
  kStepCount
};

// The stream that a step runs on: the cycle's own stream, or one of the branches.
enum Branch {
  kMain = -1,
  kIdentityBranch,
  kAdaptBranch,
  kOversizedBranch,
  kNearestBranch,
  kBranchCount
};

constexpr unsigned after(StepNumber step) { return 1U << step; }

// One launch of the cycle. A step starts when the earlier steps of its own branch and the steps in
// `after` (a bit for each StepNumber) have ended.
struct Step {
  Stage stage;
  Launch launch;
  Branch branch;
  unsigned after;
};

// Lists the steps of a cycle, in an order in which they may also run one after the other. Some
// launches use programmatic dependent launch, so they must directly follow another one on their
// stream: launchAssign follows launchTransform, launchSweep follows launchSort,
// launchSweepTriangles follows launchSweep, and launchEntryIds follows launchVertexIdentities.
constexpr Step kList[kStepCount] = {
    {Stage::kTransform, launchVertexIdentities, kIdentityBranch, 0},
    {Stage::kTransform, launchTransform, kMain, 0},
    {Stage::kAssign, launchAssign, kMain, 0},
    {Stage::kTransform, launchEntryIds, kIdentityBranch, 0},
    {Stage::kAssign, launchAssignBins, kAdaptBranch, after(kAssign)},
    {Stage::kSort, launchSort, kMain, 0},
    {Stage::kOversized, launchOversized, kOversizedBranch, after(kSort) | after(kEntryIds)},
    {Stage::kCluster, launchCluster, kAdaptBranch, 0},
    {Stage::kSort, launchSortFrames, kAdaptBranch, after(kSort)},
    {Stage::kSweep, launchSweep, kMain, 0},
    {Stage::kSweep, launchSweepTriangles, kMain, after(kEntryIds)},
    {Stage::kNarrowPhase, launchNarrowPhase, kMain, after(kOversized) | after(kBins)},
    {Stage::kNearest, launchNearest, kNearestBranch, after(kTransform)},
};

// The last steps of branches that nothing else waits for: the end of the cycle does.
constexpr unsigned kLast = after(kFrames) | after(kNearest);

// Returns the steps whose end another branch waits for, as bits. Only these record an event.
constexpr unsigned awaited() {
  unsigned steps = kLast;
  for (const Step& step : kList) steps |= step.after;
  return steps;
}

// Returns the arrays' addresses and sizes as bytes, for comparison.
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
  // Other threads may allocate memory meanwhile, which the stricter capture modes forbid.
  checkCuda(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal),
            "cudaStreamBeginCapture");
  cudaGraph_t recorded = nullptr;
  try {
    enqueue(cycle, shape, stream);
  } catch (...) {
    // Ends the capture after a failure too, or every later use of the stream would fail.
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

// Updates the arguments of the instantiated graph if the recorded steps are the same, which is
// faster than instantiating it again. Returns false if they differ. Scenes with and without
// clusters differ in the number of nodes. That number is compared first, because the driver would
// report the difference as an error.
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
  cudaGetLastError();  // the graphs differ, which is no failure
  return false;
}

// Enqueues all steps. A branch is forked from the main stream by its first step, and joined where a
// step of the main stream waits for it.
void CycleGraph::enqueue(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  static_assert(kStepCount == kSteps && kBranchCount == kBranches);
  started_.record(stream);
  unsigned forked = 0;
  for (int s = 0; s < kStepCount; ++s) {
    const Step& step = kList[s];
    if (s == kNearest && !shape.nearest) continue;
    cudaStream_t on = stream;
    if (step.branch != kMain) {
      on = branch_[step.branch].get();
      if ((forked >> step.branch & 1) == 0 && step.after == 0) started_.makeWait(on);
      forked |= 1U << step.branch;
    }
    for (int other = 0; other < s; ++other) {
      if ((step.after >> other & 1) != 0) done_[other].makeWait(on);
    }
    step.launch(cycle, shape, on);
    if ((awaited() >> s & 1) != 0) done_[s].record(on);
  }
  done_[kFrames].makeWait(stream);
  if (shape.nearest) done_[kNearest].makeWait(stream);
}

// An error that the device reports here was reported before.
void CycleGraph::waitForBranches() {
  for (const CudaStream& branch : branch_) cudaStreamSynchronize(branch.get());
}

void CycleGraph::runTimed(const CycleArrays& cycle, const CycleShape& shape, cudaStream_t stream) {
  times_nearest_ = shape.nearest;
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
    if (s == kNearest && !times_nearest_) continue;
    times.add(kList[s].stage, CudaEvent::between(mark_[s], mark_[s + 1]));
  }
  return times;
}

}  // namespace deformable_contact_monitor
