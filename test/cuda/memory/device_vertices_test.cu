// Vertices that the caller keeps on the device: results as of the same vertices from the host,
// behind whatever the caller's stream still does.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/stream.cuh"
#include "cuda/memory/device_buffer.cuh"
#include "nearest_pairs.h"
#include "pair_sets.h"
#include "random_scenes.h"
#include "refusal.h"
#include "scene_walk.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// Null where there is no device.
std::unique_ptr<Detector> makeIfThere() {
  try {
    return makeCudaDetector();
  } catch (const CudaError& error) {
    EXPECT_FALSE(isCudaRequired()) << error.what();
    return nullptr;
  }
}

// Gives bodies of a scene vertices on the device, with those that they have on the host.
class Mover {
 public:
  // Copies them in `stream`. The body's host vertices are NaN from then on, so that any use of them
  // shows.
  void toDevice(Scene* scene, BodyId id, cudaStream_t stream = nullptr) {
    std::vector<float> vertices = scene->body(id).mesh.vertices;
    if (vertices.empty()) return;
    if (id >= memory_.size()) memory_.resize(id + 1);
    if (!memory_[id]) memory_[id] = std::make_unique<DeviceBuffer<float>>();
    memory_[id]->grow(vertices.size() + 1, stream);
    float* const to = memory_[id]->data() + 1;  // aligned to a float, and to no more
    checkCuda(cudaMemcpyAsync(to, vertices.data(), vertices.size() * sizeof(float),
                              cudaMemcpyHostToDevice, stream),
              "cudaMemcpyAsync");
    checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    std::fill(vertices.begin(), vertices.end(), std::nanf(""));
    scene->setVertices(id, vertices.data(), vertices.size() / 3);
    scene->setDeviceVertices(id, to, vertices.size() / 3, stream);
  }

  // Writes nonsense over all that it gave.
  void spoil() {
    for (const auto& memory : memory_) {
      if (memory) checkCuda(cudaMemset(memory->data(), 0x7f, memory->bytes()), "cudaMemset");
    }
    checkCuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  }

 private:
  std::vector<std::unique_ptr<DeviceBuffer<float>>> memory_;
};

::testing::AssertionResult sameResult(const DetectionResult& expected,
                                      const DetectionResult& found) {
  const auto same = samePairs(expected.contacts, found.contacts);
  if (!same) return same;
  if (expected.counters.rejected != found.counters.rejected || found.left_out > 0 ||
      found.cut_off) {
    return ::testing::AssertionFailure()
           << found.counters.rejected << " rejected, and not " << expected.counters.rejected
           << "; left out " << found.left_out << (found.cut_off ? ", cut off" : "");
  }
  const auto as_near = sameNearest(expected.nearest, found.nearest);
  return as_near ? sameBits(expected.separations_m, found.separations_m) : as_near;
}

// All bodies on the device, and some of them; first cycles and later ones, with another pose.
TEST(DeviceVertices, RandomScenesAreAsFromTheHost) {
  const auto detector = makeIfThere();
  if (detector == nullptr) return;
  const auto on_cpu = makeCpuDetector();
  std::size_t contacts = 0, rejected = 0;
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    Scene scene = randomScene(seed);
    if (seed % 2 == 1) scene.setMargin(seed % scene.bodyCount(), 0.25F);
    Options options;
    if (seed % 3 == 0) options.adjacent = AdjacentPairs::kSkip;
    options.nearest = seed % 5 < 3;
    Scene mixed = scene;
    Mover mover;
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      if (seed % 4 < 2 || (seed >> 2 >> id) % 2 == 0) mover.toDevice(&mixed, id);
    }
    for (int cycle = 0; cycle < 2; ++cycle) {
      const DetectionResult& expected = on_cpu->detect(scene, options);
      ASSERT_TRUE(sameResult(expected, detector->detect(mixed, options)))
          << "seed " << seed << ", cycle " << cycle;
      contacts += expected.contacts.size();
      rejected += expected.counters.rejected;
      RigidTransform moved = scene.body(0).pose;
      moved.translation[0] += 0.5;
      scene.setPose(0, moved);
      mixed.setPose(0, moved);
    }
  }
  EXPECT_GT(contacts, 1000U);
  EXPECT_GT(rejected, 0U);
}

TEST(DeviceVertices, LargeScenesAreAsFromTheHost) {
  const auto detector = makeIfThere();
  if (detector == nullptr) return;
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    Scene scene = largeRandomScene(seed);
    const auto expected = makeCpuDetector()->detect(scene).contacts;
    Mover mover;
    mover.toDevice(&scene, 1);
    EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts)) << seed;
  }
}

// One long-lived detector; bodies go to the device and back from step to step, and what they left
// there is overwritten after each.
TEST(DeviceVertices, ASceneThatWalksIsAsFromTheHost) {
  const auto detector = makeIfThere();
  if (detector == nullptr) return;
  const auto on_cpu = makeCpuDetector();
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    SceneWalk walk(seed);
    Mover mover;
    std::mt19937 random(seed);
    for (int step = 0; step < 200; ++step) {
      const std::string what = walk.step();
      Options options = walk.options();
      options.predicates = Predicates::kExact;  // others have leave to differ
      options.nearest = step % 3 > 0;
      Scene mixed = walk.scene();
      std::string moved;
      for (BodyId id = 0; id < mixed.bodyCount(); ++id) {
        if (random() % 2 == 0) continue;
        mover.toDevice(&mixed, id, random() % 2 == 0 ? cudaStreamPerThread : nullptr);
        moved += " " + std::to_string(id);
      }
      const DetectionResult& expected = on_cpu->detect(walk.scene(), options);
      ASSERT_TRUE(sameResult(expected, detector->detect(mixed, options)))
          << "seed " << seed << ", step " << step << ": " << what << "; on the device" << moved;
      mover.spoil();
    }
  }
}

// Writes `count` floats after some 50 ms.
__global__ void writeLate(float* to, const float* from, std::size_t count) {
  constexpr long long kCycles = 100'000'000;
  const long long start = clock64();
  while (clock64() - start < kCycles) {
  }
  for (std::size_t i = threadIdx.x; i < count; i += blockDim.x) to[i] = from[i];
}

// Cold and warm cycles, on three kinds of streams.
TEST(DeviceVertices, KernelsThatStillWriteThemAreWaitedFor) {
  const auto detector = makeIfThere();
  if (detector == nullptr) return;
  constexpr int kSide = 40;
  const TriangleMesh frames[2] = {clothGrid(kSide, 1, 0, 0.1F), clothGrid(kSide, 1, 0.02F, -0.07F)};
  Scene scene = pairScene(frames[0], clothGrid(kSide, 1, 0.01F, 0));
  const std::size_t floats = frames[0].vertices.size();
  DeviceBuffer<float> written(floats, nullptr), sources[2];
  for (int i = 0; i < 2; ++i) {
    sources[i].grow(floats, nullptr);
    sources[i].upload(frames[i].vertices.data(), floats, nullptr);
  }
  checkCuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
  CudaStream own;
  for (const cudaStream_t stream : {own.get(), cudaStream_t{nullptr}, cudaStreamPerThread}) {
    detector->reset();
    for (int cycle = 0; cycle < 4; ++cycle) {
      const int frame = cycle % 2;
      scene.setVertices(0, frames[frame].vertices.data(), floats / 3);
      const auto expected = makeCpuDetector()->detect(scene).contacts;
      ASSERT_FALSE(expected.empty());
      checkCuda(cudaMemsetAsync(written.data(), 0x7f, written.bytes(), stream), "cudaMemsetAsync");
      writeLate<<<1, 128, 0, stream>>>(written.data(), sources[frame].data(), floats);
      checkCuda(cudaGetLastError(), "a launch");
      scene.setDeviceVertices(0, written.data(), floats / 3, stream);
      const DetectionResult& result = detector->detect(scene);
      EXPECT_EQ(cudaStreamQuery(stream), cudaSuccess) << "cycle " << cycle;
      EXPECT_TRUE(samePairs(expected, result.contacts)) << "cycle " << cycle;
    }
  }
}

TEST(DeviceVertices, ManagedMemoryDoes) {
  const auto detector = makeIfThere();
  if (detector == nullptr) return;
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, 0));
  const auto expected = makeCpuDetector()->detect(scene).contacts;
  const std::vector<float>& vertices = scene.body(1).mesh.vertices;
  float* managed = nullptr;
  ASSERT_EQ(cudaMallocManaged(&managed, vertices.size() * sizeof(float)), cudaSuccess);
  std::copy(vertices.begin(), vertices.end(), managed);
  scene.setDeviceVertices(1, managed, vertices.size() / 3);
  EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts));
  EXPECT_EQ(cudaFree(managed), cudaSuccess);
}

// The body is named, the detector stays warm enough to go on, and no fallback takes over.
TEST(DeviceVertices, WhatCannotBeReadIsRefused) {
  if (makeIfThere() == nullptr) return;
  int reported = 0;
  PoolSettings settings;
  settings.device = [] { return makeCudaDetector(); };
  settings.cpu = [] { return makeCpuDetector(); };
  settings.changed = [&reported](const BackendState&) { ++reported; };
  const auto detector = makeDetectorPool(settings);
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, 0));
  const auto expected = makeCpuDetector()->detect(scene).contacts;
  const std::vector<float> vertices = scene.body(1).mesh.vertices;
  const std::size_t count = vertices.size() / 3;
  const auto detect = [&] { detector->detect(scene); };
  PinnedBuffer<float> pinned(vertices.size());
  Mover mover;

  for (const float* on_host : {vertices.data(), static_cast<const float*>(pinned.data()),
                               reinterpret_cast<const float*>(std::uintptr_t{64})}) {
    scene.setDeviceVertices(1, on_host, count);
    EXPECT_EQ(refusal(detect),
              "b: its vertices are said to be on a device, but that is no pointer of CUDA's");
    scene.setPairEnabled(0, 1, false);
    EXPECT_EQ(refusal(detect), "") << "it takes no part";
    scene.setPairEnabled(0, 1, true);
    scene.setVertices(1, vertices.data(), count);
    EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts));
  }

  CudaStream capturing;
  mover.toDevice(&scene, 1);
  scene.setDeviceVertices(1, scene.body(1).device_vertices->xyz, count, capturing.get());
  ASSERT_EQ(cudaStreamBeginCapture(capturing.get(), cudaStreamCaptureModeRelaxed), cudaSuccess);
  EXPECT_EQ(refusal(detect),
            "b: the stream of its vertices is being captured, so nothing can wait for it");
  cudaGraph_t graph = nullptr;
  EXPECT_EQ(cudaStreamEndCapture(capturing.get(), &graph), cudaSuccess);
  cudaGraphDestroy(graph);
  EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts));
  EXPECT_EQ(detector->backend(), "cuda");
  EXPECT_EQ(reported, 0);
}

// Needs two devices.
TEST(DeviceVertices, ThoseOfAnotherDeviceAreRefused) {
  const auto detector = makeIfThere();
  int devices = 0;
  if (detector == nullptr || cudaGetDeviceCount(&devices) != cudaSuccess || devices < 2) return;
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.1F), clothGrid(20, 1, 0.01F, 0));
  const auto expected = makeCpuDetector()->detect(scene).contacts;
  const std::size_t count = scene.body(1).mesh.vertexCount();
  const auto detect = [&] { detector->detect(scene); };
  Mover here;
  here.toDevice(&scene, 1);
  const float* const readable = scene.body(1).device_vertices->xyz;

  ASSERT_EQ(cudaSetDevice(1), cudaSuccess);
  {
    CudaStream there;
    DeviceBuffer<float> memory(3 * count, there.get());
    scene.setDeviceVertices(1, memory.data(), count);
    EXPECT_EQ(refusal(detect), "b: its vertices are on CUDA device 1, and the detector is on 0");
    scene.setDeviceVertices(1, readable, count, there.get());
    EXPECT_EQ(refusal(detect), "b: the stream of its vertices is not one of the detector's device");
    ASSERT_EQ(cudaSetDevice(1), cudaSuccess);
  }
  ASSERT_EQ(cudaSetDevice(0), cudaSuccess);
  scene.setDeviceVertices(1, readable, count);
  EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts));
}

}  // namespace
}  // namespace deformable_contact_monitor
