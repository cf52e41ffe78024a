// Decides which warnings about input are due. Every object has its own timer, so a warning about
// one object neither delays nor repeats that about another.
#include "node/input_warnings.h"

#include <sstream>

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kPeriod(5);  // between warnings, and until a mesh is missing

// Returns who publishes what on the topic, so that a wrong name or type shows.
std::string describePublishers(const InputStatus& input) {
  const std::string& wanted = input.wanted_type;
  std::string text = " on " + input.topic + ", on which ";
  if (!input.type) return text + (input.publishers == 0 ? "nobody publishes" : "no type is known");
  if (*input.type != wanted) return text + *input.type + " is published, and not " + wanted;
  if (input.publishers == 0) return text + "no publisher of " + wanted + " is connected";
  return text + std::to_string(input.publishers) + " publisher(s) of " + wanted + " are connected";
}

bool isPublished(const InputStatus& input) {
  return input.type.has_value() || input.publishers > 0;
}

}  // namespace

std::vector<std::string> missingInputs(const std::vector<InputStatus>& inputs) {
  std::vector<std::string> missing;
  for (const InputStatus& input : inputs) {
    if (input.received > 0 || (!input.required && !isPublished(input))) continue;
    missing.push_back("a mesh of '" + input.object + "'" + describePublishers(input));
  }
  return missing;
}

std::vector<std::string> InputWarnings::look(const std::vector<InputStatus>& inputs,
                                             const ClockStatus& clock, SteadyTime now) {
  std::vector<std::string> warnings;
  // Without a clock no mesh can be used, so warnings about missing meshes would only distract.
  const bool is_silent = isClockSilent(clock, now);
  const std::string clock_text = now < clock_due_ ? "" : describe(clock, is_silent, now);
  if (!clock_text.empty()) {
    clock_due_ = now + kPeriod;
    warnings.push_back(clock_text);
  }
  for (const InputStatus& input : inputs) {
    Watch& watch = watches_.emplace(input.object, Watch{0, start_, start_}).first->second;
    if (input.received != watch.received) watch.changed = now;
    watch.received = input.received;
    if (now < watch.due) continue;
    if (is_silent && now - watch.changed >= kPeriod) continue;
    const std::string text = describe(input, watch, now);
    if (text.empty()) continue;
    watch.due = now + kPeriod;
    warnings.push_back(text);
  }
  return warnings;
}

// Wall time always advances, so only simulated time is watched. The clock counts as moved whenever
// its value differs from the last one, also when it jumps back.
bool InputWarnings::isClockSilent(const ClockStatus& clock, SteadyTime now) {
  if (!clock.is_simulated || clock.ros_time != ros_time_) clock_moved_ = now;
  ros_time_ = clock.ros_time;
  return now - clock_moved_ >= kPeriod;
}

std::string InputWarnings::describe(const ClockStatus& clock, bool is_silent,
                                    SteadyTime now) const {
  if (!clock.is_simulated && clock.is_sim_time_set) {
    return "this node was started before /use_sim_time was set, so it runs by the wall clock and "
           "not by /clock; restart it";
  }
  if (!is_silent) return "";
  std::ostringstream text;
  text << "use_sim_time is set, but /clock is silent for " << toSeconds(now - clock_moved_)
       << " s (" << (clock.ros_time.isZero() ? "it never came" : "it stands still")
       << "); contacts cannot be computed without it. Start its publisher, or set use_sim_time "
          "to false";
  return text.str();
}

// Returns the worst problem of the object's input; empty if there is none.
std::string InputWarnings::describe(const InputStatus& input, const Watch& watch,
                                    SteadyTime now) const {
  std::ostringstream text;
  text << "object '" << input.object << "': ";
  if (now - watch.changed >= kPeriod) {
    if (!input.required && !isPublished(input)) return "";
    text << "no mesh for " << toSeconds(now - watch.changed) << " s" << describePublishers(input);
  } else if (!input.refusal.empty()) {
    text << "mesh refused: " << input.refusal << "; it came" << describePublishers(input);
    if (!input.rivals.empty()) text << "; " << input.rivals;
  } else if (!input.rivals.empty()) {
    text << input.rivals << " (" << input.topic << ")";
  } else if (!input.anomaly.empty()) {
    text << input.anomaly;
  } else {
    return "";
  }
  return text.str();
}

}  // namespace deformable_contact_monitor
