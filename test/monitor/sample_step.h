// A small report with a step that ends with it.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sample_report.h"

namespace deformable_contact_monitor {

// The bodies of the sample do not touch at its stamp. The hand and the cloth had two contacts in
// the time interval of 0.1 s before it, the first one after a quarter of the interval.
struct SampleStep : SampleReport {
  SampleStep() {
    result.contacts.clear();
    step.detection.contacts = {{0, 0, 2, 0}, {0, 1, 2, 1}};
    step.detection.first_times = {{0.5F, 0.75F}, {0.25F, 0.5F}};
    step.detection.guaranteed = true;
    step.detection.round_trip_ms = 3.5;
    report.motion = Motion::kSwept;
    SweepReport sweep;
    sweep.from = report.header.stamp - ros::Duration(0.1);
    sweep.triggered = {2};
    sweep.pairs = {{0, 2, false}, {1, 2, false}};
    sweep.bodies.resize(3);
    for (StepBody& body : sweep.bodies) body.takes_part = true;
    sweep.result = owned_step;
    sweep.compute_s = 0.005;
    report.sweeps.push_back(std::move(sweep));
  }

  SweepReport& sweep() { return report.sweeps[0]; }
  // There is none, because of the cloth.
  void lackStep(const std::string& why) {
    sweep().from = ros::Time();
    sweep().result = nullptr;
    for (StepBody& body : sweep().bodies) body.takes_part = false;
    sweep().bodies[2].skipped = why;
  }

  const std::shared_ptr<StepResult> owned_step = std::make_shared<StepResult>();
  StepResult& step = *owned_step;  // the report's, to be changed by tests
};

}  // namespace deformable_contact_monitor
