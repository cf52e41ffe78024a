// Checks that the monitor's margins are large enough for the guard's distances. The margin of a
// pair is the larger one of its two bodies, as in the monitor.
#include "tools/contact_guard/margin_check.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "reader/contact_reader.h"
#include "reader/monitor_margins.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether the guard regards the pair, as Guard::counts() does.
bool counts(const ContactState& state, const std::vector<std::string>& links) {
  return links.empty() || std::any_of(links.begin(), links.end(), [&state](const auto& link) {
           return ContactReader::concerns(state, link);
         });
}

// A distance up to which the guard must see pairs, where it comes from, and what happens otherwise.
struct Reach {
  double distance_m;
  std::string name, without;
};

// Returns the greatest distance that the guard needs.
Reach reachOf(const GuardParameters& p) {
  Reach reach{p.slow_distance_m, "slow_distance_m", "nothing slows the robot beyond that margin"};
  if (p.warn_distance_m > reach.distance_m) {
    reach = {p.warn_distance_m, "warn_distance_m", "nothing warns beyond that margin"};
  }
  const double way_m = p.fastest_closing_mps * p.time_to_contact_s;
  if (p.time_to_contact_s > 0 && p.stop_distance_m + way_m > reach.distance_m) {
    reach = {p.stop_distance_m + way_m,
             "the way in time_to_contact_s at fastest_closing_mps, with stop_distance_m",
             "a pair that comes as fast slows the robot too late"};
  }
  return reach;
}

}  // namespace

// Compares in float32, because the monitor keeps margins as float32.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters) {
  const MonitorMargins margins = marginsOf(monitor);
  const Reach reach = reachOf(parameters);
  std::string first;
  std::size_t count = 0;
  for (const ContactState& state : states.states) {
    const double margin_m = margins.of(state);
    if (state.state == ContactState::ALLOWED || !counts(state, parameters.links) ||
        static_cast<float>(margin_m) >= static_cast<float>(reach.distance_m)) {
      continue;
    }
    if (++count > 1) continue;
    std::ostringstream text;
    text << state.body_a << " and " << state.body_b << " (" << margin_m << " m)";
    first = text.str();
  }
  if (count == 0) return "";
  std::ostringstream text;
  text << "the monitor's margin_m of " << count << " pair(s), such as " << first << ", is below "
       << reach.name << " (" << reach.distance_m << " m): " << reach.without;
  return text.str();
}

}  // namespace deformable_contact_monitor
