// What instant and swept motion find in a sequence of frames, at all of them and at some.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_measurement.h"
#include "tools/measure_trade/trade_statistics.h"

namespace deformable_contact_monitor {

// From one frame to a later one, every vertex on a straight line.
struct MotionStep {
  std::size_t from = 0, to = 0;  // frames, from 0
  // Pairs of bodies that were looked at, ascending: enabled in both frames, their triangles the
  // same.
  std::vector<BodyPair> bodies;
  std::vector<TrianglePair> contacts;  // at some time of the step, sorted
  std::vector<FirstContact> first;     // of each contact
  double round_trip_ms = 0;
};

struct MotionResults {
  std::size_t every = 0;                           // the kept frames: each so-many-th, and the last
  std::vector<std::string> labels;                 // per frame
  std::vector<std::vector<TrianglePair>> instant;  // per frame, sorted
  std::vector<double> instant_ms;                  // per frame, round trips
  std::vector<MotionStep> steps;                   // from each frame to the next
  std::vector<MotionStep> kept_steps;              // from each kept frame to the next kept one
  std::uint64_t pairs_without_step = 0;            // enabled ones in some frame but the first
  std::uint64_t rejected = 0;                      // triangles that are not finite, over all frames
};

// Frames, from 0, that are kept, ascending; `frames` >= 1.
std::vector<std::size_t> keptFrames(std::size_t frames, std::size_t every);

using MakeDetector = std::function<std::unique_ptr<Detector>()>;

// `options`: motion and times are set here. Throws std::runtime_error if there are not more frames
// than `every`, or a cycle was cut off or left contacts out.
MotionResults findMotions(FrameSource* frames, std::size_t every, const Options& options,
                          const MakeDetector& make, const SayProgress& progress);

}  // namespace deformable_contact_monitor
