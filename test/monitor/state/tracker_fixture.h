// Provides what tests of the states of pairs of bodies have in common: rules, and a tracker's
// states and events as text.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "monitor/state/contact_state_tracker.h"
#include "sample_report.h"

namespace deformable_contact_monitor {

inline StateRules rules(int on, int off, double tolerated_rejects = 0) {
  return {on, off, 0.5, tolerated_rejects};
}

// All states after the report.
inline ContactStates take(ContactStateTracker* tracker, const CycleReport& report) {
  tracker->update(report);
  return tracker->states(report.header.stamp, report.now);
}

// Pairs of a SampleReport.
constexpr std::size_t kBaseHand = 0, kHandCloth = 1, kBaseCloth = 2;

// "BEGIN arm/hand cloth 3" or "END arm/hand cloth 0 reset".
inline std::vector<std::string> texts(const std::vector<ContactEvent>& events) {
  std::vector<std::string> lines;
  for (const ContactEvent& e : events) {
    lines.push_back(std::string(e.type == ContactEvent::BEGIN ? "BEGIN " : "END ") + e.body_a +
                    " " + e.body_b + " " + std::to_string(e.pair_count) +
                    (e.reason.empty() ? "" : " " + e.reason));
  }
  return lines;
}

inline std::string statesOf(const ContactStates& states) {
  const std::string letters = "-nCa?";
  std::string text;
  for (const ContactState& state : states.states) text += letters.at(state.state);
  return text;
}

}  // namespace deformable_contact_monitor
