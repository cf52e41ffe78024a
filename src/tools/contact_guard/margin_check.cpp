// Checks that the monitor's margins are large enough for the guard's slow_distance_m. The margin of
// a pair is the larger one of its two bodies, as in the monitor.
#include "tools/contact_guard/margin_check.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <vector>

#include "monitor/rules/parameter_reader.h"
#include "reader/contact_reader.h"

namespace deformable_contact_monitor {
namespace {

// The largest margin that the monitor accepts [m].
constexpr double kLargestM = 10;

// The margin of single bodies, and the common margin of all others [m].
struct Margins {
  double common_m = 0;
  std::map<std::string, double> own_m;

  double of(const std::string& body) const {
    const auto found = own_m.find(body);
    return found == own_m.end() ? common_m : found->second;
  }
};

// Reads the monitor's margins. Bad values are ignored, since the monitor does not start with them.
Margins readMargins(const XmlRpc::XmlRpcValue& monitor) {
  std::vector<std::string> problems;
  ParameterReader reader(monitor, "", &problems);
  Margins margins;
  margins.common_m = reader.number("margin_m", 0, 0, kLargestM);
  margins.own_m = reader.numbers("link_margin_m", 0, kLargestM);
  for (ParameterReader& object : reader.structs("objects")) {
    const std::string name = object.text("name", "");
    margins.own_m[name] = object.number("margin_m", margins.common_m, 0, kLargestM);
  }
  return margins;
}

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
  const Margins margins = readMargins(monitor);
  std::string first;
  std::size_t count = 0;
  for (const ContactState& state : states.states) {
    const double margin_m = std::max(margins.of(state.body_a), margins.of(state.body_b));
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
