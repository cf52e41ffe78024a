// What the detection loop says, on topics and in the diagnostics.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "monitor/cycle/cycle_sink.h"
#include "monitor/diagnostics/open_bodies.h"
#include "monitor/diagnostics/size_check.h"
#include "node/cycle_publisher.h"
#include "node/node_diagnostics.h"

namespace deformable_contact_monitor {

class MonitorSink : public CycleSink {
 public:
  // The diagnostics must outlive this.
  MonitorSink(std::unique_ptr<CyclePublisher> publisher, NodeDiagnostics& diagnostics)
      : publisher_(std::move(publisher)), diagnostics_(diagnostics) {}

  bool wantsGeometry() const override { return publisher_->wantsGeometry(); }
  void recordStart() override;
  SteadyTime sendCycle(CycleReport* report, SteadyTime start, SteadyTime mesh_arrival) override;
  void sendHeartbeat(CycleReport* report) override;
  void listPairs(CycleReport* report) override { publisher_->publishStates(report); }
  void forgetStates(const std::string& body, const std::string& reason) override {
    publisher_->forgetStates(body, reason);
  }
  void sendRobot(const RobotGeometry& robot) override { publisher_->publishRobot(robot); }

  void recordMesh(std::size_t object, const MeshCounters& counters) override {
    diagnostics_.recordMesh(object, counters);
  }
  void recordTransforms(const TransformReport& transforms) override {
    diagnostics_.recordTransforms(transforms);
  }
  void recordContainment(const CycleReport& report) override;
  void recordDetectorError(const std::string& error) override {
    diagnostics_.recordDetectorError(error);
  }
  void recordRules(const RulesInForce& rules) override { diagnostics_.recordRules(rules); }
  void setMarkerRate(double rate_hz) override { publisher_->setMarkerRate(rate_hz); }
  void recordReset(const std::string& reason) override {
    publisher_->forgetPatches();
    diagnostics_.recordReset(reason);
  }
  void recordEnabled(bool enabled) override { diagnostics_.recordEnabled(enabled); }

 private:
  const std::unique_ptr<CyclePublisher> publisher_;
  NodeDiagnostics& diagnostics_;
  SizeCheck size_check_;
  OpenBodies open_bodies_;
};

}  // namespace deformable_contact_monitor
