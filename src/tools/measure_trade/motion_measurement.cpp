// Finds the contacts of instant and swept motion, and counts what each way to check frames misses.
// Lists of pairs are kept sorted, so that sets are merged and compared in linear time.
#include "tools/measure_trade/motion_measurement.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// Returns true if the triangles are the same, so that each vertex has a path.
bool isSameMesh(const Body& a, const Body& b) {
  return a.topology_revision == b.topology_revision ||
         (a.mesh.vertices.size() == b.mesh.vertices.size() && a.mesh.triangles == b.mesh.triangles);
}

// Returns the later frame's scene, with the earlier poses and vertices as the interval's beginning.
// Pairs without an interval are disabled in it. `lost` are the bodies without a path.
Scene sceneOfStep(const Scene& from, const Scene& to, const std::set<BodyId>& lost,
                  std::vector<BodyPair>* bodies) {
  Scene scene = to;
  std::vector<bool> has_step;
  for (BodyId id = 0; id < to.bodyCount(); ++id) {
    const Body &before = from.body(id), &now = to.body(id);
    has_step.push_back(lost.count(id) == 0 && isSameMesh(before, now));
    if (!has_step.back()) continue;
    // A body whose vertices did not change moves rigidly, so only its pose is given.
    const bool is_rigid = before.vertices_revision == now.vertices_revision;
    scene.setEarlier(id, before.pose, is_rigid ? HostList<float>() : before.mesh.vertices);
  }
  for (const BodyPair& pair : to.enabledPairs()) {
    if (has_step[pair.first] && has_step[pair.second] &&
        from.pairEnabled(pair.first, pair.second)) {
      bodies->push_back(pair);
    } else {
      scene.setPairEnabled(pair.first, pair.second, false);
    }
  }
  return scene;
}

// Detects, and throws if the result may lack contacts.
const DetectionResult& wholeResult(Detector* detector, const Scene& scene, const Options& options,
                                   const std::string& label) {
  const DetectionResult& result = detector->detect(scene, options);
  if (result.cut_off || result.left_out > 0) {
    throw std::runtime_error(
        label + ": not all contacts were found: " +
        (result.cut_off ? result.cut_off_because : "no memory for their list"));
  }
  return result;
}

// Finds the contacts of the intervals between the frames that it is given, with its own detector.
class Stepper {
 public:
  Stepper(const MakeDetector& make, const Options& options) : options_(options), detector_(make()) {
    // Times of first contact are needed for onsets.
    options_.motion = Motion::kSwept;
    options_.first_times = true;
  }

  // Follows the bodies' paths. Call it for every frame, before take().
  void follow(const FrameSource& frames) {
    for (BodyId id = 0; id < frames.scene().bodyCount(); ++id) {
      if (!frames.hasPath(id)) lost_.insert(id);
    }
  }

  // Takes the next frame. Every frame but the first ends an interval.
  void take(std::size_t frame, const std::string& label, const Scene& scene) {
    if (taken_) {
      MotionStep step;
      step.from = frame_;
      step.to = frame;
      const Scene between = sceneOfStep(scene_, scene, lost_, &step.bodies);
      const DetectionResult& result = wholeResult(detector_.get(), between, options_, label);
      step.contacts = result.contacts;
      step.first = result.first_times;
      step.round_trip_ms = result.round_trip_ms;
      steps.push_back(std::move(step));
    }
    taken_ = true;
    lost_.clear();
    frame_ = frame;
    scene_ = scene;
  }

  std::vector<MotionStep> steps;

 private:
  Options options_;
  std::unique_ptr<Detector> detector_;
  bool taken_ = false;
  std::size_t frame_ = 0;
  std::set<BodyId> lost_;  // bodies whose path since that frame is not known
  Scene scene_;
};

using Pairs = std::vector<TrianglePair>;

// A pair and the time at which it touches first.
struct Timed {
  TrianglePair pair;
  FirstContact first;
};

// Returns the pair as it is counted at a level.
TrianglePair atLevel(const TrianglePair& pair, MotionLevel level) {
  return level == MotionLevel::kTriangles ? pair : TrianglePair(pair.body_a, 0, pair.body_b, 0);
}

// Maps pairs of triangles to the level. The result is sorted and has no duplicates.
Pairs atLevel(const Pairs& pairs, MotionLevel level) {
  Pairs mapped;
  mapped.reserve(pairs.size());
  for (const TrianglePair& pair : pairs) mapped.push_back(atLevel(pair, level));
  std::sort(mapped.begin(), mapped.end());
  mapped.erase(std::unique(mapped.begin(), mapped.end()), mapped.end());
  return mapped;
}

// Maps the contacts of an interval to the level. Each pair gets the earliest of its times.
std::vector<Timed> timedAtLevel(const MotionStep& step, MotionLevel level) {
  std::vector<Timed> timed;
  for (std::size_t i = 0; i < step.contacts.size(); ++i) {
    timed.push_back({atLevel(step.contacts[i], level), step.first[i]});
  }
  std::stable_sort(timed.begin(), timed.end(),
                   [](const Timed& a, const Timed& b) { return a.pair < b.pair; });
  std::vector<Timed> merged;
  for (const Timed& next : timed) {
    if (merged.empty() || !(merged.back().pair == next.pair)) {
      merged.push_back(next);
      continue;
    }
    FirstContact& first = merged.back().first;
    first.low = std::min(first.low, next.first.low);
    first.high = std::min(first.high, next.first.high);
  }
  return merged;
}

// Adds sorted pairs to a sorted list, without duplicates.
void add(const Pairs& more, Pairs* all) {
  Pairs merged;
  merged.reserve(all->size() + more.size());
  std::set_union(all->begin(), all->end(), more.begin(), more.end(), std::back_inserter(merged));
  all->swap(merged);
}

// Returns the pairs that a way finds between two kept frames, including both.
Pairs seenIn(const MotionResults& found, const MotionWay& way, std::size_t from, std::size_t to) {
  Pairs seen;
  // Only the two ends are frames of a way that checks the kept ones.
  for (std::size_t frame = from; frame <= to; frame += way.kept_alone ? to - from : 1) {
    add(found.instant[frame], &seen);
  }
  if (way.motion == Motion::kInstant) return seen;
  for (const MotionStep& step : way.kept_alone ? found.kept_steps : found.steps) {
    if (step.from >= from && step.to <= to) add(step.contacts, &seen);
  }
  return seen;
}

// The way that counts as the truth: swept motion at all frames.
constexpr MotionWay kTruth = {Motion::kSwept, false};

// Returns true if the pair's bodies were checked in the interval.
bool wasLookedAt(const MotionStep& step, const TrianglePair& pair) {
  return std::binary_search(step.bodies.begin(), step.bodies.end(),
                            BodyPair(pair.body_a, pair.body_b));
}

// Returns the onsets that a way finds: pairs that touch in an interval and not at its beginning.
std::vector<Onset> onsets(const MotionResults& found, const MotionWay& way, MotionLevel level) {
  const std::vector<MotionStep>& steps = way.kept_alone ? found.kept_steps : found.steps;
  std::vector<Onset> all;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const MotionStep& step = steps[i];
    const Pairs before = atLevel(found.instant[step.from], level);
    const auto is_new = [&](const TrianglePair& pair) {
      return wasLookedAt(step, pair) && !std::binary_search(before.begin(), before.end(), pair);
    };
    if (way.motion == Motion::kInstant) {
      const auto at = static_cast<double>(step.to);
      for (const TrianglePair& pair : atLevel(found.instant[step.to], level)) {
        if (is_new(pair)) all.push_back({pair, i, at, at});
      }
      continue;
    }
    const auto from = static_cast<double>(step.from), length = static_cast<double>(step.to) - from;
    for (const Timed& timed : timedAtLevel(step, level)) {
      if (!is_new(timed.pair)) continue;
      all.push_back(
          {timed.pair, i, from + length * timed.first.low, from + length * timed.first.high});
    }
  }
  return all;
}

}  // namespace

// The last frame is always kept, so that kept intervals cover the whole sequence.
std::vector<std::size_t> keptFrames(std::size_t frames, std::size_t every) {
  std::vector<std::size_t> kept;
  for (std::size_t frame = 0; frame < frames; frame += every) kept.push_back(frame);
  if (kept.back() + 1 != frames) kept.push_back(frames - 1);
  return kept;
}

// Runs all detections in one pass, so that only two frames are in memory.
MotionResults findMotions(FrameSource* frames, std::size_t every, const Options& options,
                          const MakeDetector& make, const SayProgress& progress) {
  MotionResults found;
  found.every = every;
  const std::unique_ptr<Detector> detector = make();
  Stepper all(make, options), kept(make, options);
  frames->rewind();
  while (frames->next()) {
    const std::size_t frame = found.labels.size();
    const std::string label = frames->label();
    const Scene& scene = frames->scene();
    progress("instant and swept contacts of " + label);
    const DetectionResult& result = wholeResult(detector.get(), scene, options, label);
    found.labels.push_back(label);
    found.instant.push_back(result.contacts);
    found.instant_ms.push_back(result.round_trip_ms);
    found.rejected += result.counters.rejected;
    for (Stepper* stepper : {&all, &kept}) stepper->follow(*frames);
    all.take(frame, label, scene);
    if (frame > 0) {
      found.pairs_without_step += scene.enabledPairs().size() - all.steps.back().bodies.size();
    }
    if (frame % every == 0) kept.take(frame, label, scene);
  }
  const std::size_t count = found.labels.size();
  if (count <= every) {
    throw std::runtime_error("there are " + std::to_string(count) + " frames, and --every " +
                             std::to_string(every) + " needs more than that many");
  }
  // The last frame is always kept.
  if ((count - 1) % every != 0) kept.take(count - 1, found.labels.back(), frames->scene());
  found.steps = std::move(all.steps);
  found.kept_steps = std::move(kept.steps);
  return found;
}

const std::vector<MotionWay>& waysToLook() {
  static const std::vector<MotionWay> kWays = {
      {Motion::kInstant, false}, {Motion::kInstant, true}, {Motion::kSwept, true}};
  return kWays;
}

// All ways are compared over the same intervals: those between kept frames.
PairCounts lostContacts(const MotionResults& found, const MotionWay& way, MotionLevel level) {
  PairCounts sum;
  for (const MotionStep& stretch : found.kept_steps) {
    const Pairs truth = atLevel(seenIn(found, kTruth, stretch.from, stretch.to), level);
    const Pairs seen = atLevel(seenIn(found, way, stretch.from, stretch.to), level);
    Pairs common;
    std::set_intersection(truth.begin(), truth.end(), seen.begin(), seen.end(),
                          std::back_inserter(common));
    sum.add({truth.size(), seen.size(), common.size()});
  }
  return sum;
}

std::vector<Onset> trueOnsets(const MotionResults& found, MotionLevel level) {
  return onsets(found, kTruth, level);
}

std::uint64_t FoundOnsets::lost() const {
  return static_cast<std::uint64_t>(std::count(of_truth.begin(), of_truth.end(), std::nullopt));
}

// Each onset of the way is used for one true onset at most; the rest was added.
FoundOnsets findOnsets(const MotionResults& found, const MotionWay& way, MotionLevel level,
                       const std::vector<Onset>& truth) {
  std::map<std::pair<std::size_t, TrianglePair>, Onset> seen;
  for (const Onset& onset : onsets(found, way, level)) {
    seen.emplace(std::make_pair(onset.interval, onset.pair), onset);
  }
  FoundOnsets answer;
  for (const Onset& onset : truth) {
    const std::size_t interval = way.kept_alone ? onset.interval / found.every : onset.interval;
    const auto at = seen.find({interval, onset.pair});
    if (at == seen.end()) {
      answer.of_truth.emplace_back();
      continue;
    }
    answer.of_truth.emplace_back(at->second);
    // One onset of the way counts for one true onset.
    seen.erase(at);
  }
  answer.added = seen.size();
  return answer;
}

// Compares only the lower bounds: before them, the pair certainly does not touch.
TimeError timeError(const std::vector<Onset>& truth, const FoundOnsets& found) {
  TimeError error;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!found.of_truth[i]) continue;
    const double off = std::abs(found.of_truth[i]->low - truth[i].low);
    error.mean += off;
    error.worst = std::max(error.worst, off);
    ++count;
  }
  if (count > 0) error.mean /= static_cast<double>(count);
  return error;
}

}  // namespace deformable_contact_monitor
