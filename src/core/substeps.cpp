#include "core/substeps.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/ccd/body_motion.h"
#include "core/ccd/merged_steps.h"
#include "core/ccd/turning_scene.h"
#include "core/common/rejected_triangles.h"
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

// Of the bodies that turn.
std::vector<std::optional<BodyMotion>> turningMotions(const Scene& scene,
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
    if (motion.bends()) motions[id] = motion;
  }
  return motions;
}

// Of bodies that take part, in one of the two states.
std::uint64_t countRejected(const Scene& step) {
  std::uint64_t count = 0;
  for (const RejectedTriangles& of_body : rejectedTriangles(step, Motion::kSwept)) {
    count += of_body.count;
  }
  return count;
}

// Whether the scene's own poses are the paths' ends.
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

void setEnds(const std::vector<BodyPath>& paths, Scene* scene) {
  for (BodyId id = 0; id < paths.size(); ++id) {
    if (paths[id].empty()) continue;
    const std::optional<EarlierState>& earlier = scene->body(id).earlier;
    HostList<float> vertices = earlier ? earlier->vertices : HostList<float>();
    scene->setEarlier(id, paths[id].front().pose, std::move(vertices));
    scene->setPose(id, paths[id].back().pose);
  }
}

// Leaves the pairs that move straight: a body that turns with itself alone, in its own frame.
// Returns whether there are any.
bool keepStraightPairs(const std::vector<std::optional<BodyMotion>>& motions, Scene* scene) {
  bool any = false;
  for (const auto& [a, b] : scene->enabledPairs()) {
    const bool turns = a != b && (motions[a] || motions[b]);
    if (turns) scene->setPairEnabled(a, b, false);
    any = any || !turns;
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
  if (tolerance_m > 0) motions = turningMotions(step, paths);
  if (std::none_of(motions.begin(), motions.end(), [](const auto& m) { return m.has_value(); })) {
    result_.detection = detector_.detect(step, swept);
  } else {
    detectTurning(step, motions, tolerance_m, swept);
  }
  result_.detection.round_trip_ms = watch.elapsedMs();
  return result_;
}

void SubStepDetector::detectTurning(const Scene& step,
                                    const std::vector<std::optional<BodyMotion>>& motions,
                                    double tolerance_m, const Options& options) {
  MergedSteps merged;
  bool guaranteed = true;
  straight_ = step;
  if (keepStraightPairs(motions, &straight_)) {
    const DetectionResult& part = detector_.detect(straight_, options);
    guaranteed = part.guaranteed;
    merged.add(part, 0, 1);
  }
  TurningScene turning(step, motions, tolerance_m, &turning_);
  const std::vector<double> cuts = turning.cuts(kMostSubSteps);
  for (std::size_t i = 0; i + 1 < cuts.size() && !merged.isCutOff(); ++i) {
    turning.moveTo(cuts[i], cuts[i + 1]);
    result_.pad_m = std::max(result_.pad_m, turning.largestPad());
    const DetectionResult& part = detector_.detect(turning_, options);
    guaranteed = guaranteed && part.guaranteed;
    merged.add(part, cuts[i], cuts[i + 1]);
  }
  result_.sub_steps = static_cast<int>(cuts.size()) - 1;
  result_.outlying = turning.outlying();
  result_.detection.begin(step, options, guaranteed);
  merged.write(options.first_times, step.anyPad() || result_.pad_m > 0, &result_.detection);
  std::uint64_t& rejected = result_.detection.counters.rejected;  // of some part, at most
  if (rejected > 0) rejected = std::max(rejected, countRejected(step));
}

}  // namespace deformable_contact_monitor
