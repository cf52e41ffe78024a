// A detection loop whose clocks, detector and sink are under the test's control.
#pragma once

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle/detection_loop.h"

namespace deformable_contact_monitor {

struct FakeDetector : Detector {
  struct Script {
    std::string failure;  // detect() throws it; empty: it finds nothing
    bool out_of_time = false;
    std::vector<BodyDistance> distances;  // what it knows then all the same
    std::string step_failure;             // as failure, in swept motion
    bool step_out_of_time = false;
    std::chrono::steady_clock::time_point deadline;  // of the last detection
    Options options;                                 // of it
    std::vector<float> margins_m;                    // of its bodies
    int resets = 0;
  };

  explicit FakeDetector(Script* script) : script(script) {}
  std::string backend() const override { return "fake"; }
  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    script->deadline = options.limits.deadline;
    script->options = options;
    script->margins_m.clear();
    for (const Body& body : scene.bodies()) script->margins_m.push_back(body.margin_m);
    result.begin(scene, options, true);
    const bool is_step = options.motion == Motion::kSwept;
    if (is_step ? script->step_out_of_time : script->out_of_time) result.cutOff("no time");
    result.distances = script->distances;
    const std::string& failure = is_step ? script->step_failure : script->failure;
    if (!failure.empty()) throw std::runtime_error(failure);
    return result;
  }
  void reset() override { ++script->resets; }
  void swapResult(DetectionResult& other) override { result.swap(other); }

  Script* const script;
  DetectionResult result;
};

// Logs a line for each call, except for reports of no error. The line of a report has its stamp,
// then each body, with a star if it triggered the cycle, the stamp of its data, and why it is
// UNKNOWN.
struct FakeSink : CycleSink {
  struct Log {
    std::vector<std::string> lines;
    std::vector<MonitoredPair> pairs;  // of the latest report
    RulesInForce rules;
    std::function<void(const CycleReport&)> at_result;  // called with each cycle
    std::function<void(const CycleReport&)> at_list;    // called with each cycle
    std::function<void()> at_heartbeat;                 // called once
    bool wants_geometry = false;                        // what the loop is told
    std::string shown;                                  // UNKNOWN objects that were shown last
    bool has_scene = false;                             // with the scene
    SteadyTime published;                               // when states are out: what it is told
    SteadyTime arrival;                                 // of the latest cycle's mesh
    std::vector<InsidePart> inside;                     // of the latest cycle that looked for them
    int looks_within = 0;                               // such cycles
    std::vector<SweepReport> sweeps;                    // of the latest cycle
    std::vector<std::pair<BodyId, BodyId>> enabled;     // pairs of its scene, behind its steps
  };

  FakeSink(Log* log, std::function<void()>* at_start) : log(log), at_start(at_start) {}
  void add(const std::string& line) { log->lines.push_back(line); }
  void addReport(const std::string& what, const CycleReport& report) {
    std::ostringstream line;
    line << what << " " << report.header.stamp.toSec() << ":";
    for (const BodyStatus& body : report.bodies) {
      line << " " << (body.triggered ? "*" : "") << body.name;
      if (!body.stamp.isZero()) line << "@" << body.stamp.toSec();
      if (!body.unknown_because.empty()) line << "(" << body.unknown_because << ")";
    }
    add(line.str());
    log->pairs = report.pairs;
  }
  bool wantsGeometry() const override { return log->wants_geometry; }
  void recordStart() override {
    if (*at_start) std::exchange(*at_start, nullptr)();
  }
  SteadyTime sendCycle(const CycleReport& report, SteadyTime /*start*/,
                       SteadyTime arrival) override {
    addReport(report.result != nullptr ? "cycle" : "no result", report);
    log->sweeps = report.sweeps;
    if (report.scene != nullptr) log->enabled = report.scene->enabledPairs();
    if (report.containment != nullptr) {
      log->inside = report.containment->parts;
      ++log->looks_within;
    }
    if (log->at_result) log->at_result(report);
    log->arrival = arrival;
    return log->published;
  }
  void sendHeartbeat(const CycleReport& report) override {
    addReport("heartbeat", report);
    if (log->at_heartbeat) std::exchange(log->at_heartbeat, nullptr)();
  }
  void listPairs(const CycleReport& report) override {
    log->pairs = report.pairs;
    if (log->at_list) log->at_list(report);
  }
  void showUnknown(const CycleReport& report) override {
    log->shown.clear();
    for (const BodyStatus& body : report.bodies) {
      if (body.triggered) log->shown += body.name + "(" + body.unknown_because + ")";
    }
    log->has_scene = report.scene != nullptr;
  }
  void forgetStates(const std::string& body, const std::string& reason) override {
    add("forget " + (body.empty() ? "all" : body) + ": " + reason);
  }
  void sendRobot(const RobotGeometry& robot) override {
    add("robot of " + std::to_string(robot.links.size()));
  }
  void recordTransforms(const TransformReport& transforms) override {
    for (const TransformReport::Miss& miss : transforms.misses) add("miss of " + miss.body);
  }
  void recordDetectorError(const std::string& error) override {
    if (!error.empty()) add("error: " + error);
  }
  void recordRules(const RulesInForce& rules) override { log->rules = rules; }
  void setMarkerRate(double rate_hz) override {
    add("markers at " + std::to_string(static_cast<int>(rate_hz)));
  }
  void recordReset(const std::string& reason) override { add("reset: " + reason); }
  void recordEnabled(bool enabled) override { add(enabled ? "enabled" : "disabled"); }

  Log* const log;
  std::function<void()>* const at_start;
};

// Adds a transform from "base": a rotation about z by `angle` [rad].
inline geometry_msgs::TransformStamped transformAt(const std::string& frame, double stamp_s,
                                                   double angle = 0) {
  geometry_msgs::TransformStamped t;
  t.header.frame_id = "base";
  t.header.stamp = ros::Time(stamp_s);
  t.child_frame_id = frame;
  t.transform.rotation.z = std::sin(angle / 2);
  t.transform.rotation.w = std::cos(angle / 2);
  return t;
}

inline void addTransform(TransformBuffer* buffer, const std::string& frame, double stamp_s,
                         double angle = 0) {
  buffer->add(transformAt(frame, stamp_s, angle), "test", false, SteadyTime::max());
}

// Has two objects, 0 "cloth" and 1 "cable", in the reference frame "base". Only pairs of objects
// are monitored, without a limit of the rate. Clocks stand still until the test moves them.
class LoopTest : public ::testing::Test {
 protected:
  using Lines = std::vector<std::string>;

  LoopTest() {
    parameters_.reference_frame = "base";
    parameters_.objects = {{"cloth", "", 0, true}, {"cable", "", 0, true}};
    parameters_.pair_classes = {false, true, false, false};
    parameters_.max_rate_hz = 0;
    parameters_.tf_timeout_s = 0;
  }

  // Stores a mesh of one triangle at height `z` [m], which arrived `waited_s` [s] ago.
  void give(std::size_t object, double stamp_s, const std::string& frame = "base", float z = 0,
            std::uint32_t topology_id = 3, double waited_s = 0) {
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = ros::Time(stamp_s);
    message->header.frame_id = frame;
    message->topology_id = topology_id;
    message->vertices = {0, 0, z, 1, 0, z, 0, 1, z};
    message->triangles = {0, 1, 2};
    const auto now = std::chrono::steady_clock::now();
    meshes()[object].store({message, "", false, now - fromSeconds(waited_s)});
  }

  // Returns the inputs, made with the parameters as they are at the first call.
  MeshInputs& meshes() {
    if (meshes_.empty()) meshes_ = makeMeshInputs(parameters_);
    return meshes_;
  }

  // Makes the next step that of a new loop, with the parameters as they are then.
  void restart() { loop_.reset(); }

  // Makes one step and returns what was logged in it. The first call makes the loop, with the
  // parameters as they are then.
  Lines step() {
    if (!loop_) {
      loop_ = std::make_unique<DetectionLoop>(
          parameters_,
          LoopSources{requests_, meshes(), transforms_, [this] { return newestRobot(); }},
          LoopTime{[this] { return steady_time_; }, [this] { return ros_time_; }, is_simulated_},
          make_detector_(), std::make_unique<FakeSink>(&said_, &at_cycle_));
    }
    wake_time_ = loop_->step();
    return std::exchange(said_.lines, {});
  }

  // Makes a step so many milliseconds later by both clocks.
  Lines stepAfter(int steady_ms, int ros_ms) {
    ros_time_.fromNSec(ros_time_.toNSec() + ros_ms * 1000000ULL);
    return stepAfter(steady_ms);
  }

  // Makes a step so many milliseconds later.
  Lines stepAfter(int ms) {
    steady_time_ += std::chrono::milliseconds(ms);
    return step();
  }

  // Returns how long the loop wants to sleep after the last step [ms].
  double sleepMs() const {
    return std::chrono::duration<double, std::milli>(wake_time_ - steady_time_).count();
  }

  MonitorParameters parameters_;
  LoopRequests requests_{AllowedContacts()};
  TransformBuffer transforms_{[this] { return ros_time_; }};
  std::function<std::shared_ptr<const RobotGeometry>()> robot_source_;
  FakeDetector::Script detector_;
  std::function<std::unique_ptr<Detector>()> make_detector_ = [this] {
    return std::make_unique<FakeDetector>(&detector_);
  };
  FakeSink::Log said_;
  SteadyTime steady_time_{std::chrono::hours(7)};
  ros::Time ros_time_{50};
  bool is_simulated_ = false;
  // It is called once, when the loop begins a cycle.
  std::function<void()> at_cycle_;

 private:
  std::shared_ptr<const RobotGeometry> newestRobot() const {
    return robot_source_ ? robot_source_() : nullptr;
  }

  MeshInputs meshes_;
  std::unique_ptr<DetectionLoop> loop_;
  SteadyTime wake_time_;
};

}  // namespace deformable_contact_monitor
