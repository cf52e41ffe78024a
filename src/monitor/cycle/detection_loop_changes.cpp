// What the detection loop does when it is asked to: rules and parameters that change, resets.
#include "monitor/cycle/detection_loop.h"
#include "monitor/rules/rules_in_force.h"

namespace deformable_contact_monitor {

void DetectionLoop::lookAtRequests() {
  const Requests requests = sources_.requests.take();
  if (requests.reset) reset("reset");
  if (requests.live) applyLive(*requests.live);
  if (requests.allowed_contacts) {
    scene_.setAllowedContacts(*requests.allowed_contacts);
    names_checked_ = false;
    noteRules();
  }
  if (requests.attached) {
    scene_.setAttached(*requests.attached);
    noteRules();
  }
  lookAtRobot();
  applyEnabled(requests.enabled);
}

// They, or the pairs that they are of, changed.
void DetectionLoop::noteRules() {
  list_due_ = SteadyTime();
  sink_->recordRules(
      describeRules(scene_.bodies(), scene_.pairs(), scene_.rules(), scene_.scene()));
}

void DetectionLoop::applyLive(const LiveParameters& live) {
  live_ = live;
  setOptions(live, &options_);
  scene_.setMargin(live.margin_m);
  scene_.setPairClasses(live.pair_classes);
  turns_.setRates(maxRatesHz(live, inputs_.size()));
  if (!live.pair_classes.robot_self) turns_.drop(inputs_.size());
  robots_look_ = SteadyTime();
  sink_->setMarkerRate(live.marker_rate_hz);
  noteRules();
}

}  // namespace deformable_contact_monitor
