// Decides which warnings about missing transforms are due, and says when a missing frame has come.
#pragma once

#include <tf2/buffer_core.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/steady_time.h"
#include "monitor/cycle/monitor_scene.h"

namespace deformable_contact_monitor {

// Transforms that are late or too old are said once a second. Frames that were never seen are said
// at once, and then ever less often, down to once in 5 s, as somebody has to start or configure
// something. One thread at a time. Reads no clock.
class TransformWarnings {
 public:
  struct Said {
    std::vector<std::string> warnings, news;  // news is that frames have come
  };

  // Takes how the lookup of a cycle's transforms went. Calls `surroundings` only for a warning
  // about frames that were never seen, to which it appends the text.
  Said look(const TransformReport& transforms, const std::function<std::string()>& surroundings,
            SteadyTime now);

 private:
  std::string whatCame(const TransformReport& transforms, SteadyTime now);

  std::map<std::string, SteadyTime> never_seen_;  // since when, by body
  SteadyTime late_due_, never_due_;
  SteadyTime::duration gap_{};  // between the last two warnings about frames that were never seen
};

// Returns a warning that lists the first few bodies that lack a transform, and why, one a line.
std::string describeMisses(const TransformReport& transforms);

// Returns "known frames: 'base', 'camera'", with the first few names in their order.
std::string describeKnownFrames(std::vector<std::string> frames);

// Returns what helps to find out why a frame was never seen: the known frames, and who publishes
// transforms, if that is known.
std::string describeSurroundings(const tf2::BufferCore& transforms,
                                 const std::function<std::string()>& publishers);

}  // namespace deformable_contact_monitor
