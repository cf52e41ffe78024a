// Which steps of swept motion end with a cycle: from where, of which pairs, on which ways.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "monitor/cycle/earlier_states.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// One for each sequence of cycles. One thread at a time.
class StepPlanner {
 public:
  // The parameters must outlive this.
  explicit StepPlanner(const MonitorParameters& parameters);

  // After MonitorScene::prepare() with that trigger, and with its report: appends the cycle's steps
  // to report->sweeps, without results, one for each cycle that was the previous one of some that
  // triggered this; those that have none to start from share one report without `from`. The next
  // steps of those that triggered it start from here. Sets report->motion. Does nothing where the
  // parameters ask for instant motion.
  // A body that turns has a path, by what the lookup has of its frame between the two stamps, asked
  // for every 5 ms, but at most at 200 times.
  void plan(const CycleTrigger& trigger, const MonitorScene& scene, const TransformLookup& lookup,
            CycleReport* report);

  // The next step of this object (its index), or of all, starts from nothing.
  void forget(std::size_t object, const std::string& why) { earlier_.forget(object, why); }
  void forgetAll(const std::string& why) { earlier_.forgetAll(why); }

 private:
  const MonitorParameters& parameters_;
  EarlierStates earlier_;
};

}  // namespace deformable_contact_monitor
