// Finds the contacts of a cycle's steps.
#include "monitor/cycle/step_runner.h"

#include <ros/console.h>

#include <algorithm>
#include <exception>
#include <set>
#include <utility>
#include <vector>

#include "core/common/rejected_triangles.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {
namespace {

bool isLookedAt(const SweepReport& sweep, const MonitoredPair& pair) {
  return sweep.bodies[pair.a].skipped.empty() && sweep.bodies[pair.b].skipped.empty();
}

// Switches a cycle's pairs on again, however a step ends.
class PairsOfStep {
 public:
  explicit PairsOfStep(Scene* scene) : scene_(scene), of_cycle_(scene->enabledPairs()) {}
  PairsOfStep(const PairsOfStep&) = delete;
  PairsOfStep& operator=(const PairsOfStep&) = delete;
  ~PairsOfStep() {
    for (const auto& [a, b] : of_cycle_) scene_->setPairEnabled(a, b, true);
  }

  // Returns whether there are any.
  bool choose(const SweepReport& sweep) {
    // Not all off and some on: a detector would not know the pairs again.
    std::set<std::pair<BodyId, BodyId>> of_step;
    for (const MonitoredPair& pair : sweep.pairs) {
      if (isLookedAt(sweep, pair)) of_step.insert({pair.a, pair.b});
    }
    for (const auto& pair : of_cycle_) {
      scene_->setPairEnabled(pair.first, pair.second, of_step.count(pair) > 0);
    }
    return !of_step.empty();
  }

 private:
  Scene* const scene_;
  const std::vector<std::pair<BodyId, BodyId>> of_cycle_;
};

void setEarlier(const StepBody& body, BodyId id, Scene* scene) {
  scene->clearEarlier(id);
  if (!body.takes_part || !body.skipped.empty()) return;
  if (body.mesh == nullptr) {
    scene->setEarlier(id, body.pose);
  } else {
    scene->setEarlier(id, body.pose, body.mesh->vertices);
  }
}

void noteRejectedOfStep(const Scene& scene, SweepReport* sweep) {
  if (sweep->result->detection.counters.rejected == 0) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene, Motion::kSwept);
  for (BodyId id = 0; id < rejected.size(); ++id) sweep->bodies[id].rejected = rejected[id].count;
}

}  // namespace

void StepRunner::run(const Options& options, double tolerance_m, Scene* scene,
                     CycleReport* report) {
  if (report->sweeps.empty()) return;
  if (report->result != nullptr) {
    of_stamp_ = *report->result;
    report->result = &of_stamp_;
  }
  std::size_t i = 0;
  for (SweepReport& sweep : report->sweeps) {
    if (sweep.from.isZero()) continue;
    if (i == steps_.size()) {
      steps_.emplace_back(detector_);
      nothing_.emplace_back();
    }
    runStep(options, tolerance_m, scene, &sweep, i++);
  }
}

void StepRunner::runStep(const Options& options, double tolerance_m, Scene* scene,
                         SweepReport* sweep, std::size_t number) {
  const SteadyTime start = std::chrono::steady_clock::now();
  Options of_step = options;
  of_step.motion = Motion::kSwept;
  of_step.first_times = true;
  of_step.geometry = false;
  PairsOfStep pairs(scene);
  try {
    std::vector<BodyPath> paths;
    for (BodyId id = 0; id < scene->bodyCount(); ++id) {
      setEarlier(sweep->bodies[id], id, scene);
      paths.push_back(sweep->bodies[id].path);
    }
    if (pairs.choose(*sweep)) {
      sweep->result = &steps_[number].detect(*scene, paths, tolerance_m, of_step);
    } else {
      nothing_[number] = StepResult();
      nothing_[number].detection.begin(*scene, of_step, isGuaranteed(of_step));
      sweep->result = &nothing_[number];
    }
    noteRejectedOfStep(*scene, sweep);
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("the step's detection failed, its pairs are UNKNOWN: " << error.what());
    sweep->result = nullptr;
    sweep->problem = error.what();
  }
  sweep->compute_s = toSeconds(std::chrono::steady_clock::now() - start);
}

}  // namespace deformable_contact_monitor
