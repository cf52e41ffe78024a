// Why pairs of bodies were UNKNOWN in an evaluation, counted.
#include "tools/evaluate_bag/unknown_reasons.h"

#include <algorithm>
#include <cctype>
#include <set>
#include <tuple>

namespace deformable_contact_monitor {
namespace {

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// Stamps and counts are others in each cycle; numbers that are part of a name stay.
std::string withoutNumbers(const std::string& text) {
  std::string kept;
  for (std::size_t i = 0; i < text.size();) {
    std::size_t end = i;
    if (i == 0 || text[i - 1] == ' ') {
      while (end < text.size() && (isDigit(text[end]) || text[end] == '.')) ++end;
    }
    const bool is_number = end > i && (end == text.size() || text[end] == ' ' || text[end] == ',');
    kept += is_number ? '#' : text[i];
    i = is_number ? end : i + 1;
  }
  return kept;
}

}  // namespace

void UnknownReasons::look(const CycleReport& cycle, const ContactStates& states) {
  std::set<std::string> seen;
  bool any_known = false;
  for (std::size_t i = 0; i < cycle.pairs.size(); ++i) {
    if (!isOfCycle(cycle.bodies, cycle.pairs[i])) continue;
    const ContactState& state = states.states.at(i);
    any_known |= state.state != ContactState::UNKNOWN;
    if (state.state != ContactState::UNKNOWN) continue;
    const std::string key = withoutNumbers(state.reason);
    if (!seen.insert(key).second) continue;
    UnknownReason& reason = reasons_[key];
    if (reason.cycles++ == 0) {
      reason.text = state.reason;
      reason.from = cycle.header.stamp;
    }
    reason.to = cycle.header.stamp;
  }
  evaluated_ += any_known;
}

std::vector<UnknownReason> UnknownReasons::all() const {
  std::vector<UnknownReason> all;
  for (const auto& [key, reason] : reasons_) all.push_back(reason);
  std::stable_sort(all.begin(), all.end(), [](const UnknownReason& a, const UnknownReason& b) {
    return std::tie(b.cycles, a.from) < std::tie(a.cycles, b.from);
  });
  return all;
}

}  // namespace deformable_contact_monitor
