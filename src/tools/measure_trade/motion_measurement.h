// Measures what is lost where frames are checked one by one, or only some of them: finds the
// contacts of instant and of swept motion, and counts the contacts and onsets that each way misses.
//
// The truth is swept motion at all frames. Detections run once for each frame and interval;
// counting uses their results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_measurement.h"
#include "tools/measure_trade/trade_statistics.h"

namespace deformable_contact_monitor {

// The time interval from one frame to a later one, in which every vertex moves on a straight line.
struct MotionStep {
  std::size_t from = 0, to = 0;  // frames, counted from 0
  // Pairs of bodies that were checked, ascending. They are enabled in both frames, their triangles
  // do not change, and their paths are known (FrameSource::hasPath).
  std::vector<BodyPair> bodies;
  std::vector<TrianglePair> contacts;  // pairs that touch at some time, sorted
  std::vector<FirstContact> first;     // when each of them touches first
  double round_trip_ms = 0;
};

// The contacts that each kind of motion finds.
struct MotionResults {
  std::size_t every = 0;                           // every n-th frame and the last are kept
  std::vector<std::string> labels;                 // per frame
  std::vector<std::vector<TrianglePair>> instant;  // per frame, sorted
  std::vector<double> instant_ms;                  // per frame, round trips
  std::vector<MotionStep> steps;                   // from each frame to the next
  std::vector<MotionStep> kept_steps;              // from each kept frame to the next kept one
  std::uint64_t pairs_without_step = 0;  // enabled pairs without an interval, over all frames
  std::uint64_t rejected = 0;            // invalid triangles, over all frames
};

// Returns the frames that are kept, counted from 0, ascending. `frames` must be at least 1.
std::vector<std::size_t> keptFrames(std::size_t frames, std::size_t every);

// Makes a new detector. Each kind of interval gets its own, so that each starts warm.
using MakeDetector = std::function<std::unique_ptr<Detector>()>;

// Runs instant and swept detection on all frames and on the kept ones. Sets motion and first_times
// of the options itself. Throws std::runtime_error if there are not more frames than `every`, or if
// a detection did not find everything.
MotionResults findMotions(FrameSource* frames, std::size_t every, const Options& options,
                          const MakeDetector& make, const SayProgress& progress);

// Says whose contacts and onsets are counted.
enum class MotionLevel {
  kBodies,     // pairs of bodies; the triangles of a pair are 0 then
  kTriangles,  // pairs of triangles
};

// The beginning of a contact: the pair touches at some time in [low, high] and not before `low`.
// Times are in frames, counted from 0. In instant motion, both are the frame that shows the
// contact.
struct Onset {
  TrianglePair pair;
  std::size_t interval = 0;  // index of the interval between checked frames
  double low = 0, high = 0;
};

// One way to check the frames: each at its stamp, or the intervals between them.
struct MotionWay {
  Motion motion = Motion::kInstant;
  bool kept_alone = false;  // only the kept frames; otherwise all
};

// Returns all ways but the truth, which is swept motion at all frames.
const std::vector<MotionWay>& waysToLook();

// Compares the contacts that a way finds with the true ones, at a level. A contact counts once in
// each interval between kept frames in which it exists at some time. Contacts are added on the
// straight path between two kept frames, where the true path has none.
PairCounts lostContacts(const MotionResults& found, const MotionWay& way, MotionLevel level);

// Returns the onsets by swept motion at all frames, in the order of intervals, then of pairs. A
// contact that exists in the first frame, or was not checked before, has no onset.
std::vector<Onset> trueOnsets(const MotionResults& found, MotionLevel level);

// Holds the true onsets that a way finds, and how many onsets it adds.
struct FoundOnsets {
  std::vector<std::optional<Onset>> of_truth;  // for each true onset, what the way finds of it
  std::uint64_t added = 0;                     // onsets that do not exist

  // Returns the number of true onsets that the way misses.
  std::uint64_t lost() const;
};

// A true onset is found if the way has an onset of that pair in the same interval. If an interval
// has several true onsets of a pair, only the first can be found.
FoundOnsets findOnsets(const MotionResults& found, const MotionWay& way, MotionLevel level,
                       const std::vector<Onset>& truth);

// The error of the found onsets' `low` [frames]; 0 if none was found.
struct TimeError {
  double mean = 0, worst = 0;
};

// Compares the times of the onsets that were found.
TimeError timeError(const std::vector<Onset>& truth, const FoundOnsets& found);

}  // namespace deformable_contact_monitor
