#include "core/substeps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/ccd/body_motion.h"
#include "core/ccd/merged_steps.h"
#include "core/ccd/pad_times.h"
#include "core/ccd/sub_step_scene.h"
#include "core/common/scene_queries.h"
#include "core/common/stopwatch.h"

namespace deformable_contact_monitor {
namespace {

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

// Counts the rejected triangles of all bodies that take part, in either state.
std::uint64_t countRejected(const Scene& step) {
  std::uint64_t count = 0;
  for (const RejectedTriangles& of_body : rejectedTriangles(step, Motion::kSwept)) {
    count += of_body.count;
  }
  return count;
}

// Returns whether the scene's poses already are the ends of the paths.
bool hasEndsOf(const Scene& scene, const std::vector<BodyPath>& paths) {
  for (BodyId id = 0; id < paths.size(); ++id) {
    if (paths[id].empty()) continue;
    const Body& body = scene.body(id);
    if (!body.earlier || !samePose(body.earlier->pose, paths[id].front().pose) ||
        !samePose(body.pose, paths[id].back().pose)) {
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
  MergedSteps merged;
  bool guaranteed = true;
  straight_ = step;
  const auto add = [&](const Scene& scene, double from, double to) {
    detector_.detect(scene, options);
    detector_.swapResult(part_);
    includePads(scene, options, &part_);
    guaranteed = guaranteed && part_.guaranteed;
    merged.add(part_, from, to);
  };
  if (keepStraightPairs(motions, &straight_)) add(straight_, 0, 1);
  SubStepScene sub_steps(step, motions, tolerance_m, &rotating_);
  const std::vector<double> cuts = sub_steps.cuts(kMostSubSteps);
  for (std::size_t i = 0; i + 1 < cuts.size() && !merged.isCutOff(); ++i) {
    sub_steps.moveTo(cuts[i], cuts[i + 1]);
    result_.pad_m = std::max(result_.pad_m, sub_steps.largestPad());
    add(rotating_, cuts[i], cuts[i + 1]);
  }
  result_.sub_steps = static_cast<int>(cuts.size()) - 1;
  result_.outlying = sub_steps.outlying();
  result_.detection.begin(step, options, guaranteed);
  merged.write(options.first_times, step.anyPad() || result_.pad_m > 0, &result_.detection);
  std::uint64_t& rejected = result_.detection.counters.rejected;  // the largest number of a part
  if (rejected > 0) rejected = std::max(rejected, countRejected(step));
}

}  // namespace deformable_contact_monitor
