// Cuts the interval into sub-steps, and merges their results. Contacts of all parts are sorted, so
// each new list is merged with the old one in a single pass. Times are rounded outwards, so that
// they still enclose the true time.
#include "core/substeps.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/ccd/body_motion.h"
#include "core/ccd/pad_times.h"
#include "core/ccd/sub_step_scene.h"
#include "core/common/part_table.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

// Collects the results of several detections. Each of them covered a part of the time interval, or
// other pairs of bodies.
class MergedSteps {
 public:
  MergedSteps(const Scene& step, const Options& options) { sums_.begin(step, options, true); }

  // Adds the result of a detection with swept motion in [from, to], parts [0, 1] of the interval.
  void add(const DetectionResult& part, double from, double to);

  // Adds only the nearest pairs of a detection at the present moment.
  void addNearest(const DetectionResult& part);

  bool isCutOff() const { return sums_.cut_off; }

  // Moves all into a result: each contact once, with the earliest of its times, rounded outwards,
  // and the sums of counters and stage times. `first_times` and `pads` tell which of the lists
  // beside the contacts are wanted.
  void moveTo(DetectionResult* result, bool first_times, bool pads);

 private:
  struct Contact {
    TrianglePair pair;
    FirstContact first;
    bool within_pad;
  };

  void addContacts(const DetectionResult& part, double from, double to);
  static Contact merged(const Contact& earlier, const Contact& later);

  std::vector<Contact> contacts_, new_, both_;  // sorted
  DetectionResult sums_;  // no two nearest pairs are of the same bodies or parts
};

// Bounds the relative error of the double arithmetic below.
constexpr double kSlack = 0x1p-50;

float roundedDown(double x) {
  const double least = x * (1 - kSlack);
  const float near = toFloat(least);
  return near > least ? std::nextafter(near, 0.0F) : near;
}

float roundedUp(double x) {
  const double most = x * (1 + kSlack);
  const float near = toFloat(most);
  return std::min(near < most ? std::nextafter(near, 2.0F) : near, 1.0F);
}

// Converts times within a sub-step into times within the whole interval.
FirstContact inInterval(const FirstContact& first, double from, double to) {
  if (from == 0 && to == 1) return first;
  return {roundedDown(from + (to - from) * first.low), roundedUp(from + (to - from) * first.high)};
}

// Adds up the work of the sub-steps. Rejected triangles and clusters are the same ones in each
// sub-step, so their largest count is taken.
void addCounters(const Counters& part, Counters& sum) {
  sum.rejected = std::max(sum.rejected, part.rejected);
  sum.posed += part.posed;
  sum.culled += part.culled;
  sum.clusters = std::max(sum.clusters, part.clusters);
  sum.addWork(part);
}

// Adds up the times of stages with the same name.
void addTimes(const DetectionResult& part, DetectionResult& sum) {
  for (const auto& [stage, ms] : part.stages_ms) {
    const auto known = std::find_if(sum.stages_ms.begin(), sum.stages_ms.end(),
                                    [&stage = stage](const auto& s) { return s.first == stage; });
    if (known == sum.stages_ms.end()) {
      sum.stages_ms.emplace_back(stage, ms);
    } else {
      known->second += ms;
    }
  }
  sum.detect_ms += part.detect_ms;
  sum.memory_bytes = std::max(sum.memory_bytes, part.memory_bytes);
  sum.memory_is_whole = part.memory_is_whole;
  sum.detector_bytes = std::max(sum.detector_bytes, part.detector_bytes);
}

void MergedSteps::add(const DetectionResult& part, double from, double to) {
  addContacts(part, from, to);
  addNearest(part);
  sums_.guaranteed = sums_.guaranteed && part.guaranteed;
  sums_.left_out += part.left_out;
  sums_.started_cold = sums_.started_cold || part.started_cold;
  addCounters(part.counters, sums_.counters);
  addTimes(part, sums_);
}

void MergedSteps::addNearest(const DetectionResult& part) {
  sums_.nearest.insert(sums_.nearest.end(), part.nearest.begin(), part.nearest.end());
  sums_.nearest_parts.insert(sums_.nearest_parts.end(), part.nearest_parts.begin(),
                             part.nearest_parts.end());
  if (part.cut_off) sums_.cutOff(part.cut_off_because);
}

void MergedSteps::addContacts(const DetectionResult& part, double from, double to) {
  new_.clear();
  for (std::size_t i = 0; i < part.contacts.size(); ++i) {
    FirstContact first{0, 1};
    if (!part.first_times.empty()) first = part.first_times[i];
    const bool within_pad = !part.within_pad.empty() && part.within_pad[i] != 0;
    first = inInterval(first, from, to);
    // It is not known when triangles within their pads touch, or whether they do, so 1 is the only
    // upper bound.
    if (within_pad) first.high = 1;
    new_.push_back({part.contacts[i], first, within_pad});
  }
  both_.clear();
  auto old = contacts_.cbegin();
  for (const Contact& contact : new_) {
    for (; old != contacts_.cend() && old->pair < contact.pair; ++old) both_.push_back(*old);
    if (old != contacts_.cend() && old->pair == contact.pair) {
      both_.push_back(merged(*old++, contact));
    } else {
      both_.push_back(contact);
    }
  }
  both_.insert(both_.end(), old, contacts_.cend());
  contacts_.swap(both_);
}

// A contact within the pads may come before one on the straight lines, and its upper bound is 1.
MergedSteps::Contact MergedSteps::merged(const Contact& earlier, const Contact& later) {
  return {earlier.pair,
          {std::min(earlier.first.low, later.first.low),
           std::min(earlier.first.high, later.first.high)},
          earlier.within_pad && later.within_pad};
}

void MergedSteps::moveTo(DetectionResult* result, bool first_times, bool pads) {
  for (const Contact& contact : contacts_) {
    sums_.contacts.push_back(contact.pair);
    if (first_times) sums_.first_times.push_back(contact.first);
    if (pads) sums_.within_pad.push_back(contact.within_pad ? 1 : 0);
  }
  std::sort(sums_.nearest.begin(), sums_.nearest.end());
  std::sort(sums_.nearest_parts.begin(), sums_.nearest_parts.end());
  sums_.swap(*result);
}

void validate(const Scene& scene, const std::vector<BodyPath>& paths, double tolerance_m) {
  if (paths.size() != scene.bodyCount()) {
    throw std::invalid_argument(std::to_string(paths.size()) + " paths for " +
                                std::to_string(scene.bodyCount()) + " bodies");
  }
  if (!std::isfinite(tolerance_m) || tolerance_m < 0) {
    throw std::invalid_argument("tolerance " + std::to_string(tolerance_m) +
                                " m is not a finite number >= 0");
  }
  for (BodyId id = 0; id < paths.size(); ++id) validate(paths[id], scene.body(id).name);
}

// Returns the motions of the bodies that rotate, one per body of the scene; the others are empty.
std::vector<std::optional<BodyMotion>> rotatingMotions(const Scene& scene,
                                                       const std::vector<BodyPath>& paths) {
  std::vector<std::optional<BodyMotion>> motions(scene.bodyCount());
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    if (paths[id].empty() || !scene.takesPart(id)) continue;
    if (body.device_vertices) {
      throw std::invalid_argument(body.name +
                                  ": its vertices are on a device, where its path "
                                  "cannot be looked at");
    }
    const BodyMotion motion(body, paths[id]);
    if (motion.rotates()) motions[id] = motion;
  }
  return motions;
}

// Counts the rejected triangles of all bodies that take part, in either state, if some sub-step
// rejected any. The result has the largest number of a sub-step before.
void countRejected(const Scene& step, DetectionResult* result) {
  if (result->counters.rejected == 0) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(step, Motion::kSwept);
  std::uint64_t count = 0;
  for (const RejectedTriangles& of_body : rejected) count += of_body.count;
  result->counters.rejected = std::max(result->counters.rejected, count);
  listRejectedParts(rejected, *result);
}

// Returns the options of a detection at the present moment for the sake of its nearest pairs.
Options atPresent(Options options) {
  options.motion = Motion::kInstant;
  options.first_times = false;
  options.near_pairs = false;
  return options;
}

// Returns whether the scene's poses already are the ends of the paths.
bool hasEndsOf(const Scene& scene, const std::vector<BodyPath>& paths) {
  for (BodyId id = 0; id < paths.size(); ++id) {
    if (paths[id].empty()) continue;
    const Body& body = scene.body(id);
    if (!body.earlier || !(body.earlier->pose == paths[id].front().pose) ||
        !(body.pose == paths[id].back().pose)) {
      return false;
    }
  }
  return true;
}

// Sets the scene's poses to the ends of the paths.
void setEnds(const std::vector<BodyPath>& paths, Scene* scene) {
  for (BodyId id = 0; id < paths.size(); ++id) {
    if (paths[id].empty()) continue;
    const std::optional<EarlierState>& earlier = scene->body(id).earlier;
    HostList<float> vertices = earlier ? earlier->vertices : HostList<float>();
    scene->setEarlier(id, paths[id].front().pose, std::move(vertices));
    scene->setPose(id, paths[id].back().pose);
  }
}

// Leaves only pairs whose bodies move straight. A body that rotates moves straight in its own
// frame, so it stays enabled with itself, with identity poses. Returns whether any pair is left.
bool keepStraightPairs(const std::vector<std::optional<BodyMotion>>& motions, Scene* scene) {
  bool any = false;
  for (const auto& [a, b] : scene->enabledPairs()) {
    const bool rotates = a != b && (motions[a] || motions[b]);
    if (rotates) scene->setPairEnabled(a, b, false);
    any = any || !rotates;
  }
  for (BodyId id = 0; id < scene->bodyCount(); ++id) {
    if (!motions[id]) continue;
    scene->setPose(id, RigidTransform());
    scene->setEarlier(id, RigidTransform(), scene->body(id).earlier->vertices);
  }
  return any;
}

}  // namespace

const StepResult& SubStepDetector::detect(const Scene& scene, const std::vector<BodyPath>& paths,
                                          double tolerance_m, const Options& options) {
  const Stopwatch watch;
  validate(scene, paths, tolerance_m);
  Options swept = options;
  swept.motion = Motion::kSwept;
  result_.sub_steps = 1;
  result_.pad_m = 0;
  result_.outlying.clear();
  const bool own_ends = hasEndsOf(scene, paths);
  if (!own_ends) {
    step_ = scene;
    setEnds(paths, &step_);
  }
  const Scene& step = own_ends ? scene : step_;
  std::vector<std::optional<BodyMotion>> motions(scene.bodyCount());
  if (tolerance_m > 0) motions = rotatingMotions(step, paths);
  if (std::none_of(motions.begin(), motions.end(), [](const auto& m) { return m.has_value(); })) {
    detector_.detect(step, swept);
    detector_.swapResult(result_.detection);
    includePads(step, swept, &result_.detection);
  } else {
    detectRotating(step, motions, tolerance_m, swept);
  }
  result_.detection.round_trip_ms = watch.elapsedMs();
  return result_;
}

void SubStepDetector::swapResult(StepResult& result) {
  result_.detection.swap(result.detection);
  std::swap(result_.sub_steps, result.sub_steps);
  std::swap(result_.pad_m, result.pad_m);
  std::swap(result_.outlying, result.outlying);
}

void SubStepDetector::detectRotating(const Scene& step,
                                     const std::vector<std::optional<BodyMotion>>& motions,
                                     double tolerance_m, const Options& options) {
  MergedSteps merged(step, options);
  straight_ = step;
  const auto add = [&](const Scene& scene, double from, double to, bool nearest) {
    Options part_options = options;
    part_options.nearest = nearest;
    detector_.detect(scene, part_options);
    detector_.swapResult(part_);
    includePads(scene, options, &part_);
    merged.add(part_, from, to);
  };
  if (keepStraightPairs(motions, &straight_)) add(straight_, 0, 1, options.nearest);
  SubStepScene sub_steps(step, motions, tolerance_m, &rotating_);
  const std::vector<double> cuts = sub_steps.cuts(kMostSubSteps);
  for (std::size_t i = 0; i + 1 < cuts.size() && !merged.isCutOff(); ++i) {
    sub_steps.moveTo(cuts[i], cuts[i + 1]);
    result_.pad_m = std::max(result_.pad_m, sub_steps.largestPad());
    // The last sub-step ends in the present state. Only outlying triangles are missing there.
    const bool is_last = i + 2 == cuts.size();
    const bool nearest = options.nearest && is_last && sub_steps.outlying().empty();
    add(rotating_, cuts[i], cuts[i + 1], nearest);
  }
  result_.sub_steps = static_cast<int>(cuts.size()) - 1;
  result_.outlying = sub_steps.outlying();
  if (options.nearest && !result_.outlying.empty() && !merged.isCutOff()) {
    const SubStepScene present(step, motions, tolerance_m, &rotating_);
    detector_.detect(rotating_, atPresent(options));
    detector_.swapResult(part_);
    merged.addNearest(part_);
  }
  merged.moveTo(&result_.detection, options.first_times, step.anyPad() || result_.pad_m > 0);
  countRejected(step, &result_.detection);
}

}  // namespace deformable_contact_monitor
