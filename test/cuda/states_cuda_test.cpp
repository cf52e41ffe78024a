// Checks of states on CUDA whose lists have no room at first, beside the CPU.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <random>
#include <vector>

#include "core/state_checker.h"
#include "cuda/cuda_state_checker.h"
#include "cuda/device/cuda_error.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

class StatesOnCuda : public testing::Test {
 protected:
  void SetUp() override {
    try {
      checker_ = makeCudaStateChecker();
    } catch (const CudaError& error) {
      ASSERT_FALSE(isCudaRequired()) << error.what();
    }
  }

  // Expects what the CPU decides of states in which body 1 is lifted by different heights.
  void expectAsOnCpu(const Scene& scene, const StateOptions& options, std::size_t count,
                     double step_m) {
    std::vector<RigidTransform> poses(count);
    for (std::size_t i = 0; i < count; ++i) {
      poses[i].translation[2] = 0.1 + step_m * static_cast<double>(i);
    }
    const StateBatch batch{{1}, count, poses.data()};
    const StateResults& expected = cpu_->check(scene, batch, options);
    const StateResults& found = checker_->check(scene, batch, options);
    ASSERT_EQ(expected.states.size(), found.states.size());
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(expected.states[i].decision, found.states[i].decision) << "state " << i;
      ASSERT_EQ(expected.states[i].nearest, found.states[i].nearest) << "state " << i;
    }
    EXPECT_EQ(expected.pairs, found.pairs);
  }

  std::unique_ptr<StateChecker> checker_;  // null: there is no device
  const std::unique_ptr<StateChecker> cpu_ = makeCpuStateChecker();
};

// Some 500 pairs of tiles in each state, of which a million have room. One vertex alone reaches
// through the other cloth, so that a state is wrong if its pair of tiles is lost.
TEST_F(StatesOnCuda, DecideMoreTilesThanAreListed) {
  if (checker_ == nullptr) return;
  const TriangleMesh cloth = clothGrid(30, 1, 0, 0.5F);
  TriangleMesh spiked = cloth;
  spiked.vertices[3 * (spiked.vertexCount() / 2) + 2] -= 0.3F;
  const Scene scene = pairScene(cloth, spiked);
  expectAsOnCpu(scene, {}, 6000, 5e-6);
}

// Returns a flat cloth whose triangles are in random order, so that the first one lies anywhere.
TriangleMesh shuffledCloth(std::uint32_t seed) {
  TriangleMesh cloth = clothGrid(40, 1, 0, 0);
  std::mt19937 random(seed);
  for (std::size_t i = cloth.triangleCount() - 1; i > 0; --i) {
    const auto triangle = cloth.triangles.begin() + 3 * static_cast<std::ptrdiff_t>(i);
    std::swap_ranges(triangle, triangle + 3,
                     cloth.triangles.begin() + 3 * static_cast<std::ptrdiff_t>(random() % i));
  }
  return cloth;
}

// Flat cloths above each other: all triangles are equally near.
TEST_F(StatesOnCuda, ChooseAmongMoreTrianglesThanHaveRoom) {
  if (checker_ == nullptr) return;
  Scene scene = pairScene(shuffledCloth(1), shuffledCloth(2));
  scene.setMargin(0, 1);
  StateOptions options;
  options.nearest = options.pairs = true;
  for (int repeat = 0; repeat < 2; ++repeat) expectAsOnCpu(scene, options, 24, 0.01);
}

}  // namespace
}  // namespace deformable_contact_monitor
