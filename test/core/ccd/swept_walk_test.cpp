// Long-lived detectors on a scene that changes at random, from each state to the next: after every
// step they find what brute force finds, in the step or at its end. $DCM_WALK_STEPS and
// $DCM_WALK_SEED say how many steps, and which.
#include <gtest/gtest.h>

#include <iostream>
#include <random>
#include <string>

#include "scene_walk.h"
#include "swept_expected.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint64_t kMostPairs = 40000;

std::uint64_t pairsOf(const Scene& scene) {
  std::uint64_t pairs = 0;
  for (const auto& [a, b] : scene.enabledPairs()) {
    pairs += scene.body(a).mesh.triangleCount() * scene.body(b).mesh.triangleCount();
  }
  return pairs;
}

// Makes the time interval from one state of the walk to the next. Bodies whose triangles changed
// have no earlier state, and neither has one body in eight; some have a motion bound.
Scene stepOf(const Scene& before, const Scene& after, std::mt19937* random) {
  constexpr float kPads[] = {0, 0, 0, 0, 1e-3F, 0.1F, 1e-40F, 1e30F};
  Scene step = after;
  for (BodyId id = 0; id < after.bodyCount(); ++id) {
    step.setPad(id, kPads[(*random)() % 8]);
    if (id >= before.bodyCount() || (*random)() % 8 == 0) continue;
    const Body& body = before.body(id);
    if (body.topology_revision != after.body(id).topology_revision) continue;
    const bool is_link = body.vertices_revision == after.body(id).vertices_revision;
    step.setEarlier(id, body.pose, is_link ? HostList<float>() : body.mesh.vertices);
  }
  return step;
}

// How often the walk came to what is worth testing.
struct Visits {
  std::uint32_t looked_at = 0, contacts = 0, passed = 0, within_pad = 0, rejected = 0;
};

class SweptWalk : public SweptFixture {
 protected:
  void compare(const Scene& scene, const Options& options, const std::string& what) {
    const DetectionResult& expected = brute_force_->detect(scene, options);
    const DetectionResult& found = detector_->detect(scene, options);
    // Pairs that are added by motion bounds may differ a little between backends, because filters
    // decide them.
    ASSERT_TRUE(samePairs(straight(expected), straight(found))) << what;
    ASSERT_EQ(expected.counters.rejected, found.counters.rejected) << what;
    ASSERT_EQ(expected.without_step, found.without_step) << what;
    ASSERT_EQ(found.first_times.size(), options.first_times ? found.contacts.size() : 0) << what;
    ++visits_.looked_at;
    visits_.contacts += expected.contacts.empty() ? 0 : 1;
    visits_.within_pad += straight(expected).size() < expected.contacts.size() ? 1 : 0;
    visits_.rejected += expected.counters.rejected > 0 ? 1 : 0;
    for (const FirstContact& time : found.first_times) {
      if (time.low == 0) continue;
      ++visits_.passed;
      break;
    }
  }

  static std::vector<TrianglePair> straight(const DetectionResult& result) {
    std::vector<TrianglePair> pairs;
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      if (result.within_pad.empty() || result.within_pad[i] == 0) {
        pairs.push_back(result.contacts[i]);
      }
    }
    return pairs;
  }

  const std::unique_ptr<Detector> brute_force_ = makeBruteForceDetector();
  Visits visits_;
};

TEST_P(SweptWalk, KeepsUpWithBruteForce) {
  const std::uint32_t steps = numberFromEnvironment("DCM_WALK_STEPS", 150);
  const std::uint32_t seed = numberFromEnvironment("DCM_WALK_SEED", 2);
  std::mt19937 random(seed);
  SceneWalk walk(seed);
  for (std::uint32_t i = 0; i < steps && !HasFatalFailure(); ++i) {
    const Scene before = walk.scene();
    const std::string what =
        "seed " + std::to_string(seed) + ", step " + std::to_string(i) + ": " + walk.step();
    if (pairsOf(walk.scene()) > kMostPairs) continue;
    Options options = walk.options();
    options.predicates = Predicates::kExact;
    if (random() % 6 == 0) compare(walk.scene(), options, what + ", instant");
    options.motion = Motion::kSwept;
    options.first_times = random() % 2 == 0;
    compare(stepOf(before, walk.scene(), &random), options, what);
  }
  std::cout << "seed " << seed << ": steps looked at " << visits_.looked_at << ", with contacts "
            << visits_.contacts << ", after the start " << visits_.passed << ", within pads "
            << visits_.within_pad << ", rejected triangles " << visits_.rejected << "\n";
  EXPECT_GT(visits_.looked_at, steps / 4);
  EXPECT_GT(visits_.contacts, steps / 4);
  EXPECT_GT(visits_.passed, steps / 100);
  EXPECT_GT(visits_.within_pad, steps / 20);
  EXPECT_GT(visits_.rejected, steps / 20);
}

INSTANTIATE_TEST_SUITE_P(, SweptWalk, ::testing::ValuesIn(sweptProductBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
