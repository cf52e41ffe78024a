// What is lost where frames are looked at one by one, or only some of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/measure_trade/motion_steps.h"

namespace deformable_contact_monitor {

// Whose contacts and onsets are counted.
enum class MotionLevel {
  kBodies,     // of a pair of bodies: some pair of their triangles. Triangles are 0 there.
  kTriangles,  // of each pair of triangles
};

// When a pair that was not in contact is, in frames from 0: certainly not before `low`, certainly
// at some time in [low, high]. Of instant motion: both the frame where it is seen.
struct Onset {
  TrianglePair pair;
  std::size_t interval = 0;  // of the frames that were looked at, the one that it is in
  double low = 0, high = 0;
};

// One way to look: at one moment of some frames, or at the steps between them.
struct MotionWay {
  Motion motion = Motion::kInstant;
  bool kept_alone = false;  // each `every`-th frame and the last; else all
};

// Every way but the truth, which is swept motion at all frames.
const std::vector<MotionWay>& waysToLook();

// What a way finds of the true contacts. A contact is counted once in each stretch from a kept
// frame to the next in which it is there at some time.
struct LostContacts {
  std::uint64_t truth = 0, found = 0, common = 0;

  std::uint64_t lost() const { return truth - common; }
  // On the straight way between two kept frames, and not on the true one.
  std::uint64_t added() const { return found - common; }
};

LostContacts lostContacts(const MotionResults& found, const MotionWay& way, MotionLevel level);

// By swept motion at all frames, in the order of intervals, then of pairs. A pair that is there in
// the first frame, or was not looked at before, has no onset then.
std::vector<Onset> trueOnsets(const MotionResults& found, MotionLevel level);

struct FoundOnsets {
  std::vector<std::optional<Onset>> of_truth;  // by true onset: as the way sees it; nothing: lost
  std::uint64_t added = 0;                     // that are no true ones

  std::uint64_t lost() const;
};

// A true onset is found if the way has one of that pair in the interval that it is in. Of several
// true ones in one interval the first alone is.
FoundOnsets findOnsets(const MotionResults& found, const MotionWay& way, MotionLevel level,
                       const std::vector<Onset>& truth);

// By how much the found onsets' `low` is off [frames]; 0 where none was found.
struct TimeError {
  double mean = 0, worst = 0;
};

TimeError timeError(const std::vector<Onset>& truth, const FoundOnsets& found);

}  // namespace deformable_contact_monitor
