// Which bodies have no transform, since when, and how much that matters.
#include "monitor/diagnostics/transform_watch.h"

#include <diagnostic_msgs/DiagnosticStatus.h>

#include <algorithm>
#include <iterator>
#include <utility>

namespace deformable_contact_monitor {

using diagnostic_msgs::DiagnosticStatus;

void TransformWatch::record(const TransformReport& report, SteadyTime now) {
  worst_wait_s_ = std::max(worst_wait_s_, report.waited_s);
  misses_ += report.misses.size();
  std::map<std::string, Missing> before;
  for (const std::string& body : report.asked) {
    if (auto entry = missing_.extract(body)) before.insert(std::move(entry));
  }
  for (const TransformReport::Miss& miss : report.misses) {
    const auto found = before.find(miss.body);
    const SteadyTime since = found == before.end() ? now : found->second.since;
    missing_[miss.body] = {since, now, miss.answer.problem};
  }
}

void TransformWatch::describe(diagnostic_updater::DiagnosticStatusWrapper& status, SteadyTime now) {
  constexpr double kMissingTooLongS = 5, kForgottenAfterS = 30;
  status.summary(DiagnosticStatus::OK, "all transforms in time");
  std::string missing;
  double longest_s = 0;
  for (auto entry = missing_.begin(); entry != missing_.end();) {
    const bool forgotten = toSeconds(now - entry->second.last_asked) > kForgottenAfterS;
    entry = forgotten ? missing_.erase(entry) : std::next(entry);
  }
  for (const auto& [body, how] : missing_) {
    const double since_s = toSeconds(now - how.since);
    longest_s = std::max(longest_s, since_s);
    missing += (missing.empty() ? "" : ", ") + body;
    status.add(body + " missing for [s]", since_s);
    status.add(body, how.problem);
  }
  if (!missing.empty()) {
    status.summary(longest_s > kMissingTooLongS ? DiagnosticStatus::ERROR : DiagnosticStatus::WARN,
                   "no transform for: " + missing);
  }
  status.add("misses", misses_);
  status.add("worst wait [s]", worst_wait_s_);
  worst_wait_s_ = 0;
}

}  // namespace deformable_contact_monitor
