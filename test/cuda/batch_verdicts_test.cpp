// The device's verdicts are the host's, pair by pair.
#include "batch_verdicts.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "cuda/device/cuda_error.h"
#include "pair_verdict.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// Every third pair shares vertices; small integers make touching, coplanar and degenerate ones
// common; a wide range of scales and offsets makes the filters fail.
std::vector<VerdictQuestion> hardPairs(std::size_t count) {
  std::mt19937 random(7);
  std::vector<VerdictQuestion> pairs(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int range = i % 2 == 0 ? 3 : 1000;
    const float scale = std::ldexp(1.0F, static_cast<int>(i % 5) * 40 - 80);
    const float offset = i % 7 == 0 ? 1048576.0F : 0;
    const auto coordinate = [&] {
      return (static_cast<float>(static_cast<int>(random() % (2 * range + 1)) - range) + offset) *
             scale;
    };
    VerdictQuestion& pair = pairs[i];
    for (Triangle* t : {&pair.a, &pair.b}) {
      for (Vec3f& v : t->v) v = {coordinate(), coordinate(), coordinate()};
    }
    pair.same_body = i % 3 == 0;
    if (pair.same_body) {
      for (std::size_t k = 0; k <= random() % 2; ++k) pair.b.v[k] = pair.a.v[(k + i) % 3];
    }
  }
  return pairs;
}

bool deviceIsThere() {
  try {
    batchVerdicts({}, AdjacentPairs::kSkip, Predicates::kExact, 0);
    return true;
  } catch (const CudaError&) {
    return false;
  }
}

constexpr std::size_t kSweepTriangles = 200000;

TEST(BatchVerdicts, AreTheHostsOrSayWhyNot) {
  const std::vector<VerdictQuestion> pairs = hardPairs(kSweepTriangles);
  if (!deviceIsThere()) {
    EXPECT_FALSE(isCudaRequired());
    EXPECT_THROW(batchVerdicts(pairs, AdjacentPairs::kSkip, Predicates::kExact, 0), CudaError);
    return;
  }
  for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
    for (const Predicates predicates : {Predicates::kExact, Predicates::kConservative}) {
      const auto verdicts = batchVerdicts(pairs, adjacent, predicates, 0);
      std::size_t contacts = 0, exact = 0, wrong = 0;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        PredicateState state;
        state.mode = predicates;
        const Verdict host =
            pairVerdict(pairs[i].a, pairs[i].b, pairs[i].same_body, adjacent, 0, state);
        wrong += host.contact != (verdicts[i].contact == 1) ||
                 (state.exact > 0) != (verdicts[i].exact == 1) ||
                 host.separation_m != verdicts[i].separation_m;
        contacts += host.contact;
        exact += state.exact > 0;
      }
      EXPECT_EQ(wrong, 0U) << "predicates " << toString(predicates);
      EXPECT_GT(contacts, pairs.size() / 10);
      if (predicates == Predicates::kExact) {
        EXPECT_GT(exact, pairs.size() / 40);
      }
    }
  }
}

// Pairs a little apart, at all scales, some with vertices at up to 3e38.
std::vector<VerdictQuestion> nearPairs(std::size_t count, float margin_m) {
  std::mt19937 random(9);
  const auto unit = [&] { return static_cast<float>(random() % 2000001) / 1e6F - 1; };
  const auto point = [&](float size) { return Vec3f{size * unit(), size * unit(), size * unit()}; };
  std::vector<VerdictQuestion> pairs(count);
  for (VerdictQuestion& pair : pairs) {
    const float size = std::min(margin_m, 1e30F) * static_cast<float>(random() % 50 + 1);
    const Vec3f off = point(3 * size);
    for (Vec3f& v : pair.a.v) v = point(size);
    for (Vec3f& v : pair.b.v) v = off + point(size);
    const auto kind = random() % 8;
    const float far =
        std::min(std::ldexp(std::max(size, 1.0F), static_cast<int>(random() % 26)), 1e38F);
    if (kind == 0) pair.a.v[random() % 3] = point(far);
    if (kind == 1) pair.b.v[0] = (pair.b.v[1] = point(far)) * -1;
    if (kind == 2) pair.b.v[0] = pair.a.v[0] = point(1e38F);
    if (kind == 3) pair.a.v[0] = pair.a.v[1];
    if (kind == 4) pair.a.v[2] = pair.a.v[0] + (pair.a.v[1] - pair.a.v[0]) * 0.5F;
  }
  return pairs;
}

TEST(BatchVerdicts, SeparationsAreTheHostsBitByBit) {
  if (!deviceIsThere()) return;
  for (const float margin_m : {1e-40F, 1e-30F, 1e-3F, 1.0F, 1e30F, 3e38F}) {
    const std::vector<VerdictQuestion> pairs = nearPairs(kSweepTriangles, margin_m);
    const auto verdicts =
        batchVerdicts(pairs, AdjacentPairs::kBeyondShared, Predicates::kExact, margin_m);
    std::size_t near = 0, wrong = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      PredicateState state;
      // Swaps the triangles of each pair.
      const Verdict host =
          pairVerdict(pairs[i].b, pairs[i].a, false, AdjacentPairs::kBeyondShared, margin_m, state);
      wrong += host.contact != (verdicts[i].contact == 1) ||
               std::memcmp(&host.separation_m, &verdicts[i].separation_m, sizeof(float)) != 0;
      near += host.separation_m > 0;
    }
    EXPECT_EQ(wrong, 0U) << margin_m;
    EXPECT_GT(near, pairs.size() / 100) << margin_m;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
