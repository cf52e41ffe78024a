// Tests that detectors which were made before a process was forked detect or throw there, and end,
// although their threads and devices are not there.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/backend_error.h"
#include "core/common/forks.h"
#include "core/common/guarded_detector.h"
#include "core/common/parallel.h"
#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "core/tiling_cache.h"
#include "in_child.h"
#include "pair_sets.h"
#include "scenes.h"

#ifdef __SANITIZE_ADDRESS__
// A forked process leaves memory as it is, on purpose.
extern "C" int __lsan_is_turned_off() {  // NOLINT(bugprone-reserved-identifier)
  return deformable_contact_monitor::forkCount() > 0 ? 1 : 0;
}
#endif
#ifdef __SANITIZE_THREAD__
extern "C" const char* __tsan_default_options() {  // NOLINT(bugprone-reserved-identifier)
  return "die_after_fork=0";
}
#endif

namespace deformable_contact_monitor {
namespace {

// Two cloths that touch in many places.
Scene touchingScene(int n = 60) {
  return pairScene(clothGrid(n, 1, 0, 0.1F), clothGrid(n, 1, 0.02F, -0.1F));
}

// The pool of a program, which has a thread that makes tilings.
std::unique_ptr<Detector> poolWithTilings() {
  PoolSettings settings;
  settings.cpu = [] { return makeCpuDetector(); };
  settings.tilings = std::make_shared<TilingCache>();
  return makeDetectorPool(std::move(settings));
}

Options withTolerance() {
  Options options;
  options.tolerance_m = 0.005F;
  options.threads = 4;
  return options;
}

// Runs until tilings decide, at most for `cycles`. Returns whether they do.
bool isBounded(Detector& detector, const Scene& scene, int cycles) {
  for (int i = 0; i < cycles; ++i) {
    if (!detector.detect(scene, withTolerance()).distances.empty()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST(ForkedProcess, EndsAPoolThatHasAThread) {
  const Scene scene = touchingScene();
  std::unique_ptr<Detector> pool = poolWithTilings();
  ASSERT_TRUE(isBounded(*pool, scene, 1000));
  EXPECT_EQ(0, inChild([&] {
              pool = nullptr;
              return true;
            }));
}

TEST(ForkedProcess, GoesOnWithAPoolThatHasAThread) {
  const Scene scene = touchingScene();
  const std::unique_ptr<Detector> pool = poolWithTilings();
  ASSERT_TRUE(isBounded(*pool, scene, 1000));
  EXPECT_EQ(0, inChild([&] { return isBounded(*pool, scene, 1000); }));
  const Scene other = touchingScene(50);  // no tiling of it is there yet
  EXPECT_EQ(0, inChild([&] { return isBounded(*pool, other, 1000); }));
  EXPECT_TRUE(isBounded(*pool, scene, 1));
}

// The fork may come at any time of the thread's work.
TEST(ForkedProcess, EndsTilingsThatAreBeingMade) {
  for (int n = 10; n < 400; n += 30) {
    const Scene scene = touchingScene(n);
    auto tilings = std::make_unique<TilingCache>();
    for (std::uint32_t i = 0; i < TilingCache::kSettledAfter; ++i) tilings->of(scene.body(0));
    EXPECT_EQ(0, inChild([&] {
                tilings->of(scene.body(0));
                tilings = nullptr;
                return true;
              }));
    tilings->wait();
    EXPECT_NE(nullptr, tilings->of(scene.body(0)));
  }
}

TEST(ForkedProcess, FindsTheSameContacts) {
  const Scene scene = touchingScene();
  Options options;
  options.threads = 4;
  std::unique_ptr<Detector> detector = makeCpuDetector();
  const std::vector<TrianglePair> expected = detector->detect(scene, options).contacts;
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(0, inChild([&] {
              for (const int threads : {4, 0, 1}) {
                options.threads = threads;
                if (!samePairs(expected, detector->detect(scene, options).contacts)) return false;
                if (!samePairs(expected, makeCpuDetector()->detect(scene, options).contacts)) {
                  return false;
                }
              }
              detector = nullptr;
              // The child's own children are no worse off.
              return inChild([&] {
                       return samePairs(expected,
                                        makeCpuDetector()->detect(scene, options).contacts);
                     }) == 0;
            }));
}

TEST(ForkedProcess, EndsAtItsExit) {
  static std::unique_ptr<Detector> detector;  // destroyed at exit
  detector = poolWithTilings();
  const Scene scene = touchingScene();
  ASSERT_TRUE(isBounded(*detector, scene, 1000));
  EXPECT_EQ(0, inChild([&] {
              detector->detect(scene, withTolerance());
              std::exit(0);
              return true;
            }));
}

TEST(ForkedProcess, UsesThreadsOnlyWhereNoAncestorHas) {
  ProcessMark unset, set;
  set.set();
  EXPECT_FALSE(set.isInherited());
  EXPECT_EQ(0, inChild([&] {
              if (unset.isInherited() || !set.isInherited()) return false;
              unset.set();
              set.clear();
              return !unset.isInherited() && !set.isInherited();
            }));
  ASSERT_TRUE(mayUseThreads());
  EXPECT_EQ(0, inChild([] { return !mayUseThreads() && threadCount() == 1; }));
  EXPECT_TRUE(mayUseThreads());
}

// Waits in detect() until it is told to go on, and must not be destroyed or used in a child.
class BlockingDetector : public Detector {
 public:
  explicit BlockingDetector(std::shared_future<void> goes_on) : goes_on_(std::move(goes_on)) {}
  ~BlockingDetector() override {
    if (getpid() != process_) _exit(1);
  }
  std::string backend() const override { return "blocking"; }
  void reset() override { require(); }
  void swapResult(DetectionResult& /*result*/) override { require(); }
  std::pmr::memory_resource& vertexMemory() override {
    require();
    return Detector::vertexMemory();
  }
  const DetectionResult& detect(const Scene& /*scene*/, const Options& /*options*/) override {
    require();
    is_inside_ = true;
    goes_on_.wait();
    return result_;
  }
  void waitUntilInside() const {
    while (!is_inside_) std::this_thread::yield();
  }

 private:
  void require() const {
    if (getpid() != process_) _exit(1);
  }

  const pid_t process_ = getpid();
  std::shared_future<void> goes_on_;
  std::atomic<bool> is_inside_{false};
  DetectionResult result_;
};

// Returns whether detect() throws an error of that fault that mentions `what`.
bool refuses(Detector& detector, const std::string& what) {
  try {
    detector.detect(touchingScene(2), Options());
  } catch (const BackendError& error) {
    return error.fault() == BackendFault::kUnavailable &&
           std::string(error.what()).find(what) != std::string::npos;
  }
  return false;
}

TEST(ForkedProcess, RefusesADetectorThatTheForkInterrupted) {
  for (const AfterFork after_fork : {AfterFork::kWorks, AfterFork::kIsUnavailable}) {
    std::promise<void> goes_on;
    auto blocking = std::make_unique<BlockingDetector>(goes_on.get_future().share());
    BlockingDetector& inner = *blocking;
    std::unique_ptr<Detector> detector = guardAgainstForks(std::move(blocking), after_fork);
    const Scene scene = touchingScene(2);
    std::thread other([&] { detector->detect(scene); });
    inner.waitUntilInside();
    EXPECT_EQ(0, inChild([&] {
                const bool refused = refuses(*detector, "this process was forked") ||
                                     refuses(*detector, "a process that was forked");
                detector->reset();
                detector->vertexMemory();
                const bool has_name = detector->backend() == "blocking";
                detector = nullptr;
                return refused && has_name;
              }));
    goes_on.set_value();
    other.join();
    detector->detect(scene);
    detector->reset();
  }
}

// The sanitizers' own locks do not survive a fork beside a thread that takes memory.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// A real one, wherever in detect() it is.
TEST(ForkedProcess, WorksWhateverAnotherThreadDetects) {
  const Scene scene = touchingScene(100), small = touchingScene(10);
  const std::vector<TrianglePair> expected = makeCpuDetector()->detect(small, Options()).contacts;
  std::unique_ptr<Detector> pool = poolWithTilings();
  std::atomic<bool> ends{false};
  std::thread other([&] {
    while (!ends) pool->detect(scene, withTolerance());
  });
  for (int i = 0; i < 10; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(i));
    EXPECT_EQ(0, inChild([&] {
                try {
                  pool->detect(small, Options());
                } catch (const BackendError&) {
                }
                pool = nullptr;
                return samePairs(expected, makeCpuDetector()->detect(small, Options()).contacts) &&
                       isBounded(*poolWithTilings(), small, 1000);
              }));
  }
  ends = true;
  other.join();
}

#endif

TEST(ForkedProcess, RefusesADeviceAndLeavesItAlone) {
  std::promise<void> goes_on;
  goes_on.set_value();
  const std::shared_future<void> at_once = goes_on.get_future().share();
  const auto device = [&] {
    return guardAgainstForks(std::make_unique<BlockingDetector>(at_once),
                             AfterFork::kIsUnavailable);
  };
  std::unique_ptr<Detector> alone = device();
  PoolSettings settings;
  settings.device = device;
  settings.cpu = [] { return makeCpuDetector(); };
  settings.retry = RetryTimes{};
  std::vector<BackendState> states;
  settings.changed = [&](const BackendState& state) { states.push_back(state); };
  std::unique_ptr<Detector> pool = makeDetectorPool(settings);
  const Scene scene = touchingScene(10);
  alone->detect(scene);
  pool->detect(scene);
  ASSERT_EQ("blocking", pool->backend());
  const std::vector<TrianglePair> expected = makeCpuDetector()->detect(scene, Options()).contacts;
  EXPECT_EQ(0, inChild([&] {
              const bool refused = refuses(*alone, "'spawn'");
              alone = nullptr;
              pool->vertexMemory();
              const bool found = samePairs(expected, pool->detect(scene, Options()).contacts);
              const bool told = states.size() == 1 && !states[0].tried_again &&
                                states[0].fault == BackendFault::kUnavailable;
              const bool on_cpu = pool->backend() == "cpu";
              pool = nullptr;
              return refused && found && told && on_cpu;
            }));
  EXPECT_TRUE(states.empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
