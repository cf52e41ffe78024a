// Checks that the monitor's margins are large enough for the guard's slow_distance_m. The margin of
// a pair is the larger one of its two bodies, as in the monitor.
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

}  // namespace

// Compares in float32, because the monitor keeps margins as float32.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters) {
  const MonitorMargins margins = marginsOf(monitor);
  std::string first;
  std::size_t count = 0;
  for (const ContactState& state : states.states) {
    const double margin_m = margins.of(state);
    if (state.state == ContactState::ALLOWED || !counts(state, parameters.links) ||
        static_cast<float>(margin_m) >= static_cast<float>(parameters.slow_distance_m)) {
      continue;
    }
    if (++count > 1) continue;
    std::ostringstream text;
    text << state.body_a << " and " << state.body_b << " (" << margin_m << " m)";
    first = text.str();
  }
  if (count == 0) return "";
  std::ostringstream text;
  text << "the monitor's margin_m of " << count << " pair(s), such as " << first
       << ", is below slow_distance_m (" << parameters.slow_distance_m
       << " m): nothing slows the robot beyond that margin";
  return text.str();
}

}  // namespace deformable_contact_monitor
