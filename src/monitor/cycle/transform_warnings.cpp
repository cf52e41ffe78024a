// Decides which warnings about missing transforms are due, and says when a missing frame has come.
#include "monitor/cycle/transform_warnings.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <utility>

namespace deformable_contact_monitor {
namespace {

constexpr std::chrono::seconds kLeast(1), kMost(5);  // between two warnings

// Returns the first few names in quotes, and how many more there are.
std::string listed(const std::vector<std::string>& names, std::size_t most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) {
    text += (i == 0 ? "'" : ", '") + names[i] + "'";
  }
  if (names.size() > most) text += " and " + std::to_string(names.size() - most) + " more";
  return text;
}

}  // namespace

std::string describeMisses(const TransformReport& transforms) {
  constexpr std::size_t kShown = 5;
  const std::vector<TransformReport::Miss>& misses = transforms.misses;
  std::string text = "UNKNOWN for want of a transform:";
  for (std::size_t i = 0; i < std::min(kShown, misses.size()); ++i) {
    text += "\n  " + misses[i].body + ": " + misses[i].answer.problem;
  }
  if (misses.size() > kShown) {
    text += "\n  and " + std::to_string(misses.size() - kShown) + " more";
  }
  return text;
}

std::string describeKnownFrames(std::vector<std::string> frames) {
  constexpr std::size_t kShown = 10;
  if (frames.empty()) return "no frame is known";
  std::sort(frames.begin(), frames.end());
  return "known frames: " + listed(frames, kShown);
}

std::string describeSurroundings(const tf2::BufferCore& transforms,
                                 const std::function<std::string()>& publishers) {
  std::vector<std::string> frames;
  transforms._getFrameStrings(frames);
  std::string text = describeKnownFrames(std::move(frames));
  if (publishers) text += "; " + publishers();
  return text;
}

TransformWarnings::Said TransformWarnings::look(const TransformReport& transforms,
                                                const std::function<std::string()>& surroundings,
                                                SteadyTime now) {
  Said said;
  const std::string came = whatCame(transforms, now);
  if (!came.empty()) said.news.push_back(came);
  TransformReport late, never;
  bool any_new = false;
  for (const TransformReport::Miss& miss : transforms.misses) {
    const bool is_never = miss.answer.outcome == PoseAnswer::Outcome::kNever;
    (is_never ? never : late).misses.push_back(miss);
    if (is_never) any_new = never_seen_.emplace(miss.body, now).second || any_new;
  }
  if (!late.misses.empty() && now >= late_due_) {
    late_due_ = now + kLeast;
    said.warnings.push_back(describeMisses(late));
  }
  // A body that is new to the list is said soon, whatever was said of others before.
  if (any_new) {
    never_due_ = std::min(never_due_, never_due_ - gap_ + kLeast);
    gap_ = {};
  }
  if (!never.misses.empty() && now >= never_due_) {
    gap_ = std::clamp<SteadyTime::duration>(2 * gap_, kLeast, kMost);
    never_due_ = now + gap_;
    said.warnings.push_back(describeMisses(never) + "\n  " + surroundings());
  }
  return said;
}

// Returns which bodies are connected for the first time, and forgets that they were missing; empty:
// none. A transform that is late is one that has been seen.
std::string TransformWarnings::whatCame(const TransformReport& transforms, SteadyTime now) {
  constexpr std::size_t kShown = 5;
  const auto is_missing = [&transforms](const std::string& body) {
    return std::any_of(transforms.misses.begin(), transforms.misses.end(),
                       [&body](const TransformReport::Miss& miss) {
                         return miss.body == body &&
                                miss.answer.outcome == PoseAnswer::Outcome::kNever;
                       });
  };
  if (never_seen_.empty()) return "";
  std::vector<std::string> bodies;
  SteadyTime since = now;
  for (const std::string& body : transforms.asked) {
    const auto found = never_seen_.find(body);
    if (found == never_seen_.end() || is_missing(body)) continue;
    bodies.push_back(body);
    since = std::min(since, found->second);
    never_seen_.erase(found);
  }
  if (bodies.empty()) return "";
  char after[64];
  std::snprintf(after, sizeof after, ", after %.1f s", toSeconds(now - since));
  return "the transforms that were never seen are there now: of " + listed(bodies, kShown) + after;
}

}  // namespace deformable_contact_monitor
