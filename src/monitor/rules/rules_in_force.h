// Margins and rules that hold, in words.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle_report.h"
#include "monitor/rules/contact_rules.h"

namespace deformable_contact_monitor {

struct RulesInForce {
  std::size_t pairs = 0;                                    // that are monitored
  std::array<std::size_t, 5> allowed_pairs{};               // of them: by RuleSource
  std::array<std::size_t, 5> rules{};                       // by RuleSource
  std::vector<std::string> attached;                        // "cloth by hand, finger"
  std::vector<std::pair<std::string, std::string>> bodies;  // name; margin and whom it may touch

  std::size_t allowedPairs() const;
};

// Of a body that may touch many others the first few are named. `bodies` and `scene` are of one
// numbering.
RulesInForce describeRules(const std::vector<BodyStatus>& bodies,
                           const std::vector<MonitoredPair>& pairs, const ContactRules& rules,
                           const Scene& scene);

}  // namespace deformable_contact_monitor
