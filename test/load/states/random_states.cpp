// Runs detection loops on small random worlds in which everything goes wrong that can, and judges
// every message of states. Clocks are simulated, and the loop runs in one thread: what other
// threads do happens wherever the loop reads a clock or detects. So each seed is one history, the
// same each time.
#include <ros/console.h>

#include <chrono>
#include <cstdint>
#include <iostream>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>

#include "cuda/detector_choice.h"
#include "monitor/cycle/detection_loop.h"
#include "monitor/state/contact_state_tracker.h"
#include "state_judge.h"
#include "state_world.h"
#include "tools/common/command_line.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kBeatS = 0.01;  // as the node's thread that lets states grow too old

// Runs another detector. In between, other threads have their time, and it may fail.
class DisturbedDetector : public Detector {
 public:
  using Disturb = std::function<void(Options*)>;
  DisturbedDetector(std::unique_ptr<Detector> detector, Disturb disturb)
      : detector_(std::move(detector)), disturb_(std::move(disturb)) {}

  std::string backend() const override { return detector_->backend(); }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    Options own = options;
    disturb_(&own);
    return detector_->detect(scene, own);
  }
  void reset() override { detector_->reset(); }
  void swapResult(DetectionResult& other) override { detector_->swapResult(other); }
  std::pmr::memory_resource& vertexMemory() override { return detector_->vertexMemory(); }

 private:
  const std::unique_ptr<Detector> detector_;
  const Disturb disturb_;
};

// One world, its monitor and its judge.
class RandomRun {
 public:
  // `trouble`: how often something goes wrong, from 0 (never) to 1.
  RandomRun(std::uint64_t seed, double trouble);
  void run(double seconds);
  const StateJudge& judge() const { return judge_; }

 private:
  // Does what the node's publishers of states do.
  class Sink;

  MonitorParameters parameters();
  bool goesWrong(double share) { return trouble_ > 0 && dice_.chance(trouble_ * share); }
  void tick(double seconds);
  void beat();
  void disturbDetection(Options* options);
  void callService();
  void changeRules();
  void changeLive();
  void disturbSources();
  void checkPairs(const ContactStates& message);

  Dice dice_;
  const double trouble_;
  const MonitorParameters parameters_;
  StateWorld world_;
  StateJudge judge_;
  ContactStateTracker tracker_;
  LoopRequests requests_{AllowedContacts()};
  MeshInputs meshes_;
  TransformBuffer transforms_{[this] { return world_.now(); }};
  LiveParameters live_;
  bool is_enabled_ = true, in_cycle_ = false, in_tick_ = true;
  std::uint64_t requests_made_ = 0;
  std::set<std::pair<std::string, std::string>> allowed_;
  double beat_due_s_ = 0;
  std::unique_ptr<DetectionLoop> loop_;
};

class RandomRun::Sink : public CycleSink {
 public:
  explicit Sink(RandomRun& run) : run_(run) {}
  bool wantsGeometry() const override { return false; }
  void recordStart() override {
    run_.world_.noteClearedBuffer(&run_.transforms_);
    run_.judge_.beginCycle(run_.meshes_);
    run_.in_cycle_ = true;
  }
  SteadyTime sendCycle(const CycleReport& report, SteadyTime /*start*/,
                       SteadyTime /*mesh_arrival*/) override {
    if (run_.goesWrong(0.01)) throw std::bad_alloc();
    run_.tracker_.update(report);
    run_.judge_.judgeCycle(report, run_.tracker_.states(report.header.stamp, report.now));
    run_.in_cycle_ = false;
    return SteadyTime();
  }
  void sendHeartbeat(const CycleReport& report) override { listPairs(report); }
  void listPairs(const CycleReport& report) override {
    run_.tracker_.update(report);
    run_.judge_.judge(run_.tracker_.states(report.header.stamp, report.now), false);
  }
  void forgetStates(const std::string& body, const std::string& reason) override {
    const ros::Time now = run_.world_.now();
    run_.tracker_.forget(body, reason, now);
    if (reason != "no new mesh") run_.judge_.forget(body);
    run_.judge_.judge(run_.tracker_.states(now, now), false);
  }
  void recordReset(const std::string& /*reason*/) override { run_.world_.noteReset(); }
  void showUnknown(const CycleReport& /*report*/) override {}
  void sendRobot(const RobotGeometry& /*robot*/) override {}
  void recordTransforms(const TransformReport& /*transforms*/) override {}
  void recordDetectorError(const std::string& /*error*/) override {}
  void recordRules(const RulesInForce& /*rules*/) override {}
  void setMarkerRate(double /*rate_hz*/) override {}
  void recordEnabled(bool /*enabled*/) override {}

 private:
  RandomRun& run_;
};

MonitorParameters RandomRun::parameters() {
  MonitorParameters p = randomParameters(&dice_);
  if (trouble_ == 0) p.tf_timeout_s = 0.05;
  return p;
}

RandomRun::RandomRun(std::uint64_t seed, double trouble)
    : dice_(seed),
      trouble_(trouble),
      parameters_(parameters()),
      world_(seed + (1ULL << 32U), trouble, parameters_),
      judge_(world_, parameters_),
      tracker_(stateRules(parameters_)),
      meshes_(makeMeshInputs(parameters_)),
      live_(startValues(parameters_)) {
  auto detector =
      makeDetector(BackendChoice::kCpu, WithoutCuda::kRefuse, {}, nullptr,
                   tradesAccuracy(parameters_) ? std::make_shared<TilingCache>() : nullptr);
  loop_ = std::make_unique<DetectionLoop>(
      parameters_, LoopSources{requests_, meshes_, transforms_, [this] { return world_.robot(); }},
      LoopTime{[this] {
                 if (goesWrong(0.05)) tick(dice_.from(0, 0.001));
                 return world_.steady();
               },
               [this] { return world_.now(); }},
      std::make_unique<DisturbedDetector>(std::move(detector),
                                          [this](Options* options) { disturbDetection(options); }),
      std::make_unique<Sink>(*this));
  in_tick_ = false;
}

void RandomRun::run(double seconds) {
  while (world_.steadyS() < seconds && judge_.faults().empty()) {
    tick(dice_.from(0.0005, 0.004));
    if (goesWrong(0.003)) {  // a busy machine
      for (double busy_s = dice_.from(0, 0.4); busy_s > 0; busy_s -= 0.005) tick(0.005);
    }
    const std::uint64_t requests_before = requests_made_;
    judge_.beginStep(live_.margin_m);
    loop_->step();
    in_cycle_ = false;
    const ros::Time now = world_.now();
    if (requests_made_ == requests_before) checkPairs(tracker_.states(now, now));
  }
}

// Lets time go on for everything but the loop.
void RandomRun::tick(double seconds) {
  if (in_tick_) return;
  in_tick_ = true;
  world_.advance(seconds, in_cycle_, &meshes_, &transforms_);
  if (goesWrong(is_enabled_ ? 0.01 : 0.05)) callService();
  if (goesWrong(0.005)) disturbSources();
  if (world_.steadyS() >= beat_due_s_) beat();
  in_tick_ = false;
}

void RandomRun::beat() {
  beat_due_s_ = world_.steadyS() + kBeatS;
  const ros::Time now = world_.now();
  tracker_.expire(now, "no new mesh within max_mesh_age_s");
  judge_.judge(tracker_.states(now, now), true);
}

// A detection takes a while. Some last for long, run out of time, or fail.
void RandomRun::disturbDetection(Options* options) {
  if (trouble_ == 0) return;
  const double lasts_s = goesWrong(0.02) ? dice_.from(0, 0.9) : dice_.from(0, 0.01);
  for (double left_s = lasts_s; left_s > 0; left_s -= 0.005) tick(std::min(left_s, 0.005));
  if (goesWrong(0.02)) options->limits.deadline = SteadyTime() + std::chrono::seconds(1);
  if (goesWrong(0.01)) throw std::runtime_error("the device failed");
}

// Does what the node's services do.
void RandomRun::callService() {
  switch (dice_.below(6)) {
    case 0:
      is_enabled_ = !is_enabled_;
      if (const std::uint64_t epoch = requests_.setEnabled(is_enabled_); !is_enabled_) {
        tracker_.discard("disabled", world_.now(), epoch);
      }
      return judge_.answer(is_enabled_);
    case 1:
      tracker_.discard("reset", world_.now(), requests_.requestReset());
      return judge_.answer(is_enabled_);
    case 2:
    case 3:
      return changeRules();
    case 4:
      return changeLive();
    default:
      if (dice_.chance(0.3)) world_.changeRobot();
  }
}

void RandomRun::changeRules() {
  ++requests_made_;
  const auto& [a, b] = dice_.oneOf<std::pair<std::string, std::string>>(
      {{"link0", "link1"}, {"link1", "cloth"}, {"link1", "cable"}, {"cloth", "cable"}});
  const bool allows = allowed_.count({a, b}) == 0;
  if (allows) {
    allowed_.insert({a, b});
  } else {
    allowed_.erase({a, b});
  }
  if (b == "cable" && a == "link1") {
    requests_.attach(b, allows ? std::vector<std::string>{a} : std::vector<std::string>());
    return;
  }
  AllowedContact rule;
  rule.body_a = a;
  rule.body_b = b;
  rule.allowed = true;
  AllowedContactsChange change;
  (allows ? change.add : change.remove).push_back(rule);
  requests_.changeAllowedContacts(change);
}

void RandomRun::changeLive() {
  ++requests_made_;
  live_.margin_m = dice_.oneOf<double>({0, 0.02, 0.1});
  judge_.changeMargin(live_.margin_m);
  live_.robot_rate_hz = dice_.oneOf<double>({10, 30, 100});
  live_.max_rate_hz = dice_.oneOf<double>({0, 20, 100});
  if (dice_.chance(0.5)) live_.pair_classes.deformable_deformable ^= true;
  if (dice_.chance(0.3)) live_.pair_classes.robot_self ^= true;
  requests_.change(live_);
}

void RandomRun::disturbSources() {
  switch (dice_.below(4)) {
    case 0:
      return world_.jump(dice_.oneOf<double>({-0.05, 0.05, -0.3, 0.3, -2, 2, -100, 100}));
    case 1:
      return world_.setRate(dice_.oneOf<double>({0, 0.2, 1, 1, 1, 3}));
    default:
      world_.silence(dice_.below(world_.sourceCount()), dice_.from(0, 0.8));
  }
}

// Compares the list of pairs, and which of them are allowed, with what was asked for.
void RandomRun::checkPairs(const ContactStates& message) {
  bool is_complete = true;
  for (const ContactState& state : message.states) {
    const bool allowed = allowed_.count({state.body_a, state.body_b}) > 0;
    if (allowed != (state.state == ContactState::ALLOWED)) {
      judge_.addFault(state.body_a + "/" + state.body_b + " is in state " +
                      std::to_string(state.state) + (allowed ? ", but allowed" : ", not allowed"));
    }
    const bool has_link_a = state.body_a.substr(0, 4) == "link";
    const bool has_link_b = state.body_b.substr(0, 4) == "link";
    const PairClasses& classes = live_.pair_classes;
    const bool is_wanted = has_link_b   ? classes.robot_self
                           : has_link_a ? classes.robot_deformable
                                        : classes.deformable_deformable;
    if (!is_wanted && state.body_a != "robot") {
      judge_.addFault(state.body_a + "/" + state.body_b + " is listed, but not monitored");
    }
    is_complete = is_complete && state.state != ContactState::UNKNOWN;
  }
  if (message.complete != is_complete) judge_.addFault("`complete` is wrong");
}

struct Totals {
  std::size_t runs = 0, faults = 0, states = 0, known = 0, judged = 0, passed = 0, calm_states = 0,
              calm_known = 0;

  void add(std::uint64_t seed, bool is_calm, const StateJudge& judge) {
    ++runs;
    states += judge.stateCount();
    known += judge.knownCount();
    judged += judge.judgedCount();
    passed += judge.passedCount();
    calm_states += is_calm ? judge.stateCount() : 0;
    calm_known += is_calm ? judge.knownCount() : 0;
    if (judge.faults().empty()) return;
    ++faults;
    std::cout << "seed " << seed << ": " << judge.faults().front() << std::endl;
  }
};

int run(std::uint64_t first, std::uint64_t count, double minutes) {
  constexpr double kSeconds = 5;  // of simulated time
  const auto start = std::chrono::steady_clock::now();
  const auto isOver = [&](std::uint64_t done) {
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    return minutes > 0 ? passed.count() >= 60 * minutes : done >= count;
  };
  Totals totals;
  for (std::uint64_t seed = first; !isOver(seed - first); ++seed) {
    constexpr double kTroubles[] = {0, 1, 0.3, 0.1, 1, 0.3, 0.1, 0.03};
    const double trouble = kTroubles[seed % 8];
    RandomRun one(seed, trouble);
    one.run(kSeconds);
    totals.add(seed, trouble == 0, one.judge());
  }
  const auto share = [](std::size_t part, std::size_t all) {
    return all == 0 ? 1 : static_cast<double>(part) / static_cast<double>(all);
  };
  const double known = share(totals.known, totals.states);
  const double calm_known = share(totals.calm_known, totals.calm_states);
  std::cout << "seeds " << first << " to " << first + totals.runs - 1 << ": " << totals.states
            << " states, " << totals.judged << " judged by brute force, " << totals.passed
            << " of them PASSED; known " << 100 * known << " %, where nothing goes wrong "
            << 100 * calm_known << " %; " << totals.faults << " seeds with a fault" << std::endl;
  return totals.faults == 0 && known > 0.2 && calm_known > 0.8 ? 0 : 1;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  using namespace deformable_contact_monitor;
  return runTool("random_states", [argc, argv] {
    CommandLine line("random_states",
                     "Judges the states of random worlds, with simulated clocks, by brute force");
    std::uint64_t seed = 1, seeds = 100;
    double minutes = 0;
    bool verbose = false;
    line.add("--seed", &seed, "the first seed");
    line.add("--seeds", &seeds, "how many");
    line.add("--minutes", &minutes, "for how long instead; 0: --seeds decides");
    line.addFlag("--verbose", &verbose, "print what the monitor logs");
    if (!line.parse(argc, argv)) return 0;
    if (!verbose &&
        ros::console::set_logger_level(ROSCONSOLE_DEFAULT_NAME, ros::console::levels::Fatal)) {
      ros::console::notifyLoggerLevelsChanged();
    }
    return run(seed, seeds, minutes);
  });
}
