// Long-lived detectors, one of each kind, on a scene that changes at random: after every step all
// of them find what brute force finds, or where that would take too long, what the CPU finds.
#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "detector_suite.h"
#include "scene_walk.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kMostPairsByBruteForce = 300000;

struct Walker {
  std::string name;
  std::unique_ptr<Detector> detector;
  bool has_little_memory;
  std::shared_ptr<TilingCache> tilings = nullptr;  // waited for after each step
};

std::vector<Walker> walkers() {
  constexpr std::uint64_t kLittleBytes = 1 << 20;
  std::vector<Walker> all;
  for (const Backend& backend : productBackends()) {
    all.push_back({backend.name, backend.make(), false});
  }
  CpuSettings little;
  little.memory_limit_bytes = kLittleBytes;
  all.push_back({"cpu with little memory", makeCpuDetector(little), true});
  const bool has_cuda = all.size() > 2;
  CpuSettings tiled;
  tiled.tilings = std::make_shared<TilingCache>();
  all.push_back({"cpu with tilings", makeCpuDetector(tiled), false, tiled.tilings});
  if (has_cuda) {
    CudaSettings settings;
    settings.memory_limit_bytes = kLittleBytes;
    all.push_back({"cuda with little memory", makeCudaDetector(settings), true});
  }
  return all;
}

std::uint64_t pairsOf(const Scene& scene) {
  std::uint64_t pairs = 0;
  for (const auto& [a, b] : scene.enabledPairs()) {
    pairs += scene.body(a).mesh.triangleCount() * scene.body(b).mesh.triangleCount();
  }
  return pairs;
}

// Checks that all listed pairs are right, and that the others are counted unless the result is cut
// off.
::testing::AssertionResult isPartOf(const DetectionResult& all, const DetectionResult& part) {
  const ::testing::AssertionResult ordered = isOrdered(part.contacts);
  if (!ordered) return ordered;
  std::vector<float> separations_m;
  std::size_t i = 0;
  for (const TrianglePair& pair : part.contacts) {
    while (i < all.contacts.size() && all.contacts[i] < pair) ++i;
    if (i == all.contacts.size() || !(all.contacts[i] == pair)) {
      return ::testing::AssertionFailure() << pair << " is no contact";
    }
    if (!all.separations_m.empty()) separations_m.push_back(all.separations_m[i]);
  }
  if (!part.cut_off && part.contacts.size() + part.left_out != all.contacts.size()) {
    return ::testing::AssertionFailure() << part.contacts.size() << " listed and " << part.left_out
                                         << " left out, of " << all.contacts.size();
  }
  return sameBits(separations_m, part.separations_m);
}

// Checks conservative predicates: pairs that are no contacts are counted as undecided.
::testing::AssertionResult holdsAll(const DetectionResult& exact, const DetectionResult& found) {
  const ::testing::AssertionResult ordered = isOrdered(found.contacts);
  if (!ordered || found.left_out > 0 || found.cut_off) return ordered;
  if (!std::includes(found.contacts.begin(), found.contacts.end(), exact.contacts.begin(),
                     exact.contacts.end())) {
    return ::testing::AssertionFailure() << "some contact is missing";
  }
  if (found.contacts.size() - exact.contacts.size() > found.counters.undecided) {
    return ::testing::AssertionFailure()
           << found.contacts.size() << " pairs, of them " << found.counters.undecided
           << " undecided; there are " << exact.contacts.size() << " contacts";
  }
  return ::testing::AssertionSuccess();
}

::testing::AssertionResult isWhole(const DetectionResult& expected, const DetectionResult& found) {
  const ::testing::AssertionResult same = samePairs(expected.contacts, found.contacts);
  if (!same) return same;
  if (found.left_out != 0 || found.cut_off) {
    return ::testing::AssertionFailure() << "left out " << found.left_out;
  }
  if (found.counters.rejected != expected.counters.rejected || found.counters.undecided > 0) {
    return ::testing::AssertionFailure()
           << found.counters.rejected << " rejected, and not " << expected.counters.rejected << "; "
           << found.counters.undecided << " undecided";
  }
  return sameBits(expected.separations_m, found.separations_m);
}

// Checks the nearest pairs. They are exact whatever the predicates, and whatever was left out.
::testing::AssertionResult hasNearest(const DetectionResult& expected,
                                      const DetectionResult& found) {
  if (found.cut_off || found.nearest == expected.nearest) return ::testing::AssertionSuccess();
  auto failure = ::testing::AssertionFailure() << "nearest:";
  for (const NearestPair& pair : found.nearest) {
    failure << " " << pair.pair << " at " << pair.distance_m;
  }
  failure << ", and not";
  for (const NearestPair& pair : expected.nearest) {
    failure << " " << pair.pair << " at " << pair.distance_m;
  }
  return failure;
}

// How often the walk came to what is worth testing.
struct Visits {
  std::uint32_t contacts = 0, near = 0, rejected = 0, left_out = 0, brute_force = 0;
  std::uint32_t apart = 0;  // bodies, with a nearest pair
};

std::ostream& operator<<(std::ostream& out, const Visits& visits) {
  return out << "steps with contacts " << visits.contacts << ", near pairs " << visits.near
             << ", rejected triangles " << visits.rejected << ", nearest pairs apart "
             << visits.apart << ", contacts left out " << visits.left_out << ", brute force "
             << visits.brute_force;
}

class RandomWalk : public testing::Test {
 protected:
  // The contacts, whatever the predicates.
  DetectionResult expectedResult() {
    Options exact = walk_.options();
    exact.predicates = Predicates::kExact;
    const bool is_small = pairsOf(walk_.scene()) <= kMostPairsByBruteForce;
    visits_.brute_force += is_small ? 1 : 0;
    return (is_small ? *brute_force_ : *cpu_).detect(walk_.scene(), exact);
  }

  void note(const DetectionResult& expected) {
    const std::vector<float>& separations_m = expected.separations_m;
    visits_.contacts += expected.contacts.empty() ? 0 : 1;
    visits_.near += std::any_of(separations_m.begin(), separations_m.end(),
                                [](float separation_m) { return separation_m > 0; });
    visits_.rejected += expected.counters.rejected > 0 ? 1 : 0;
    visits_.apart += std::any_of(expected.nearest.begin(), expected.nearest.end(),
                                 [](const NearestPair& pair) { return pair.distance_m > 0; });
  }

  // A walk that comes to all that is worth testing.
  const std::uint32_t seed_ = numberFromEnvironment("DCM_WALK_SEED", 2);
  SceneWalk walk_{seed_};
  const std::unique_ptr<Detector> brute_force_ = makeBruteForceDetector(), cpu_ = makeCpuDetector();
  Visits visits_;
};

TEST_F(RandomWalk, EveryDetectorKeepsUpWithBruteForce) {
  const std::uint32_t steps = numberFromEnvironment("DCM_WALK_STEPS", 150);
  std::vector<Walker> all = walkers();
  for (std::uint32_t i = 0; i < steps && !HasFailure(); ++i) {
    const std::string change = walk_.step();
    const DetectionResult expected = expectedResult();
    const bool is_exact = walk_.options().predicates == Predicates::kExact;
    for (Walker& walker : all) {
      const DetectionResult& found = walker.detector->detect(walk_.scene(), walk_.options());
      const auto right = !is_exact                  ? holdsAll(expected, found)
                         : walker.has_little_memory ? isPartOf(expected, found)
                                                    : isWhole(expected, found);
      EXPECT_TRUE(right) << walker.name << ", seed " << seed_ << ", step " << i << ": " << change;
      EXPECT_TRUE(hasNearest(expected, found))
          << walker.name << ", seed " << seed_ << ", step " << i << ": " << change;
      if (walker.tilings) walker.tilings->wait();
      visits_.left_out += found.left_out > 0 ? 1 : 0;
    }
    note(expected);
  }
  std::cout << "seed " << seed_ << ": " << visits_ << std::endl;
  EXPECT_GT(visits_.contacts, steps / 4);
  EXPECT_GT(visits_.near, steps / 20);
  EXPECT_GT(visits_.apart, steps / 20);
  EXPECT_GT(visits_.rejected, steps / 20);
  EXPECT_GT(visits_.brute_force, steps / 4);
}

}  // namespace
}  // namespace deformable_contact_monitor
