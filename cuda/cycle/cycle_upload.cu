// Uploads the scene of a cycle. There are three cases. A cold start inspects the scene and makes
// everything anew. A scene whose bodies have changed is inspected briefly, beside the upload, and
// may turn out to need a cold start. Any other scene only sends what has changed.
#include "core/bounds/exact_distances.h"
#include "core/common/parallel.h"
#include "cuda/cycle/cycle_upload.cuh"

namespace deformable_contact_monitor {
namespace {

// Returns whether the settings let certified vertex fans decide pairs of triangles.
bool asksForFans(const Options& options) {
  return options.motion == Motion::kInstant && options.adjacent == AdjacentPairs::kBeyondShared &&
         options.predicates != Predicates::kConservative;
}

// Returns whether they do. A fan decides pairs that share a vertex by its number.
bool usesFans(const DeviceScene& scene, const Options& options) {
  return scene.tables().any_self_mesh && asksForFans(options);
}

}  // namespace

bool CycleUpload::send(const Scene& scene, const Options& options, const CycleLimit& limit,
                       DetectionResult& result) {
  DeviceScene& on_device = cycle_.scene;
  const cudaStream_t stream = cycle_.stream.get();
  CycleSizes& sizes = cycle_.sizes;
  const bool was_cold = inspector_.isColdFor(options);
  if (!was_cold) sizes.growInAdvance(cycle_.counted(), cycle_.settings.memory_limit_bytes);
  const bool reseeds = !was_cold && inspector_.wantedClusters() != sizes.clusters;
  if (reseeds) sizes.prepareClusters(inspector_.wantedClusters());
  const std::uint32_t samples = cycle_.arrays.clusters.sample_count;
  inspector_.beginCycle(options);
  cycle_.copies.forget();
  if (was_cold) {
    cycle_.forgetSentParams();
    on_device.forgetSent();
    cycle_.nearest.forgetSent();
    cycle_.stream.synchronise();  // a failed cycle may have left work that reads the host's memory
  }
  const DeviceScene::Change change = on_device.layOut(scene, options.motion, asksForFans(options));
  if (on_device.triangleCount() == 0) return false;
  result.started_cold = was_cold;
  ColdStart start;
  if (!inspectAndSend(scene, change, options, limit, result.started_cold, start)) return false;
  // Of several devices, the first one searches the nearest pairs of the whole scene.
  cycle_.nearest.layOut(scene, on_device.tables(), searchesNearest(options) && partition_.isFirst(),
                        options.nearest && options.nearest_by_part);
  cycle_.growArrays();
  cycle_.nearest.send(cycle_.copies);
  if (result.started_cold) {
    sendSeeds(start, options);
    sendBodiesAndMakeTiles(scene, options, true);
  } else if (reseeds) {
    launchClusterSeeds(cycle_.arrays, samples, stream);
    launchClusterStart(cycle_.arrays, stream);
    cycle_.cycles_since_refresh = 0;
  }
  setParams(options, limit);
  const bool new_clusters = result.started_cold || reseeds;
  if (new_clusters || change.more_triangles > 0) sizeBins(options, new_clusters);
  return true;
}

// Inspects the scene where that is needed, and sends its layout and vertices. A warm start that
// turns out to need a cold one sets `started_cold`. Returns false if the limit was over.
bool CycleUpload::inspectAndSend(const Scene& scene, const DeviceScene::Change& change,
                                 const Options& options, const CycleLimit& limit,
                                 bool& started_cold, ColdStart& start) {
  DeviceScene& on_device = cycle_.scene;
  const cudaStream_t stream = cycle_.stream.get();
  const bool was_cold = started_cold;
  const bool inspects = inspector_.needsInspection(change, on_device.triangleCount()) || was_cold;
  const bool on_host = !on_device.anyFromDevice();
  // A cold start on the host is inspected before the upload, so that all memory is allocated at
  // once.
  const bool inspects_first = was_cold && on_host;
  if (inspects_first && !adapt(scene, change, options, limit, started_cold, start)) {
    return false;
  }
  // Any other scene is inspected on another thread during the upload.
  BesideTask brief_inspection;
  if (inspects && !was_cold && on_host) {
    brief_inspection.start(
        [&] { start = inspector_.inspect(scene, partition_, options, limit, Inspection::kBrief); });
  }
  on_device.sendLayout(scene, stream);
  on_device.sendVertices(scene, options.motion, cycle_.copies, stream);
  if (inspects) cycle_.copies.launch();  // the inspection may take long or end the cycle
  if (!was_cold) sendBodiesAndMakeTiles(scene, options, change.any);
  brief_inspection.wait();
  if (inspects && !inspects_first) {
    const bool adapted = on_host ? adapt(scene, change, options, limit, started_cold, start)
                                 : adapt(on_device.onHost(scene, stream), change, options, limit,
                                         started_cold, start);
    if (!adapted) {
      cycle_.stream.synchronise();  // the caller may change the vertices once this returns
      return false;
    }
  }
  return true;
}

// Adapts rules and sizes to the inspected scene. Returns false if the limit was over.
bool CycleUpload::adapt(const Scene& scene, const DeviceScene::Change& change,
                        const Options& options, const CycleLimit& limit, bool& started_cold,
                        ColdStart& start) {
  return inspector_.adapt({scene, partition_, change, cycle_.scene.triangleCount()}, options, limit,
                          cycle_.settings.memory_limit_bytes, started_cold, start, cycle_.sizes);
}

void CycleUpload::setParams(const Options& options, const CycleLimit& limit) {
  const DeviceScene& scene = cycle_.scene;
  CycleParams& params = cycle_.params[0];
  params = cycleParams(options, scene.triangleCount(), scene.groupCount(), scene.anyLengths(),
                       scene.tables().part_use);
  params.scale = inspector_.scale();
  params.diagonals = DiagonalFrame(inspector_.frame());
  params.axes = AxisFrame(inspector_.frame());
  params.size = SizeBounds(inspector_.sizeRule());
  params.limited = limit.isSet() ? 1 : 0;
  params.partition = partition_;
  params.any_self = scene.anySelf() ? 1 : 0;
  params.identities = scene.knownIdentities(options);
  params.fans = usesFans(scene, options) ? 1 : 0;
}

// Sends poses and margins. Then builds the tiles of new and changed bodies, and the vertex rings
// that certified fans need. `any_new`: whether there are such bodies.
void CycleUpload::sendBodiesAndMakeTiles(const Scene& scene, const Options& options, bool any_new) {
  cycle_.scene.sendBodies(scene, options, inspector_.scale(), cycle_.copies);
  if (any_new) cycle_.copies.launch();
  cycle_.scene.makeTiles(cycle_.stream.get());
  if (usesFans(cycle_.scene, options)) cycle_.scene.findFans(cycle_.stream.get());
}

// Sends the seeds and makes them the prototypes.
void CycleUpload::sendSeeds(const ColdStart& start, const Options& options) {
  inspector_.setSeeds(start, options);
  const cudaStream_t stream = cycle_.stream.get();
  checkCuda(
      cudaMemcpyAsync(cycle_.arrays.clusters.prototypes.data(), start.seeds.data(),
                      start.seeds.size() * sizeof(start.seeds[0]), cudaMemcpyHostToDevice, stream),
      "cudaMemcpyAsync to the device");
  launchClusterStart(cycle_.arrays, stream);
  cycle_.stream.synchronise();  // the copy reads the caller's seeds
  cycle_.cycles_since_refresh = 0;
}

// Measures how much room each bin needs, by running the first stages of a cycle. If the clusters
// are new, their frames do not fit the scene yet, so a second run also computes the frames.
void CycleUpload::sizeBins(const Options& options, bool new_clusters) {
  if (cycle_.arrays.usesBruteForce()) return;
  const CycleShape shape = cycle_.shapeOf(options, 0);
  const cudaStream_t stream = cycle_.stream.get();
  cycle_.start(shape);
  launchTransform(cycle_.arrays, shape, stream);
  launchAssign(cycle_.arrays, shape, stream);
  launchAssignBins(cycle_.arrays, shape, stream);
  if (!new_clusters) return;
  cycle_.start(shape);
  launchTransform(cycle_.arrays, shape, stream);
  launchAssign(cycle_.arrays, shape, stream);
  launchSort(cycle_.arrays, shape, stream);
  launchSortFrames(cycle_.arrays, shape, stream);
}

void CycleUpload::endCycle(const Options& options, bool started_cold) {
  if (options.motion == Motion::kInstant) {
    const bool searched = cycle_.params[0].identities == KnownIdentities::kAll;
    cycle_.scene.setEqualVertices(cycle_.counted(), searched);
  }
  inspector_.endCycle(cycle_.counted(), options, cycle_.sizes.clusters,
                      cycle_.arrays.clusters.sample_count, cycle_.scene.triangleCount(),
                      started_cold);
}

void CycleUpload::endDetection() {
  if (!inspector_.isCold()) cycle_.scene.makeTilesAgain(cycle_.stream.get());
}

}  // namespace deformable_contact_monitor
