// Runs the detector for one cycle. The detector reuses its result in the next call, so each result
// is exchanged for an old one that nobody reads any more: the report owns what it has, without a
// copy of the contacts.
#include "monitor/cycle/cycle_detection.h"

#include <ros/console.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <set>
#include <utility>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/scene_queries.h"
#include "core/steady_time.h"

namespace deformable_contact_monitor {
namespace {

// Returns the kept result, or a new one if a report still holds it.
template <class Result>
Result& unshared(std::shared_ptr<Result>* kept) {
  if (*kept == nullptr || kept->use_count() > 1) *kept = std::make_shared<Result>();
  return **kept;
}

bool anyPairEnabled(const Scene& scene, const CycleReport& report) {
  return std::any_of(report.pairs.begin(), report.pairs.end(), [&scene](const MonitoredPair& pair) {
    return scene.pairEnabled(pair.a, pair.b);
  });
}

// Enables the pairs of one time interval, and those of the cycle again when it goes out of scope.
class IntervalPairs {
 public:
  explicit IntervalPairs(Scene* scene) : scene_(scene), of_cycle_(scene->enabledPairs()) {}
  IntervalPairs(const IntervalPairs&) = delete;
  IntervalPairs& operator=(const IntervalPairs&) = delete;
  ~IntervalPairs() {
    for (const auto& [a, b] : of_cycle_) scene_->setPairEnabled(a, b, true);
  }

  // Returns whether the interval has any pair without a skipped body.
  bool enable(const SweepReport& sweep) {
    std::set<std::pair<BodyId, BodyId>> of_interval;
    for (const MonitoredPair& pair : sweep.pairs) {
      if (!sweep.bodies[pair.a].skipped.empty() || !sweep.bodies[pair.b].skipped.empty()) continue;
      of_interval.insert({pair.a, pair.b});
    }
    // Each pair is set once. Disabling all and enabling some would look like a change of the set of
    // pairs, after which a detector starts cold.
    for (const auto& pair : of_cycle_) {
      scene_->setPairEnabled(pair.first, pair.second, of_interval.count(pair) > 0);
    }
    return !of_interval.empty();
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

void noteRejectedOfInterval(const Scene& scene, SweepReport* sweep) {
  if (sweep->result->detection.counters.rejected == 0) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(scene, Motion::kSwept);
  for (BodyId id = 0; id < rejected.size(); ++id) {
    StepBody& body = sweep->bodies[id];
    body.rejected = rejected[id].count;
    body.rejected_by_part.assign(rejected[id].by_part.begin(), rejected[id].by_part.end());
  }
}

}  // namespace

CycleDetection::CycleDetection(Detector& detector, const DetectionSettings& settings)
    : detector_(detector), settings_(settings) {}

void CycleDetection::run(const Limits& limits, bool needs_geometry, Scene* scene,
                         CycleReport* report) {
  Options options = report->options;
  options.limits = limits;
  options.geometry = options.geometry || needs_geometry;
  options.nearest = true;  // states tell how far apart two bodies are, and where
  options.nearest_by_part = std::any_of(report->part_pairs.begin(), report->part_pairs.end(),
                                        [](const MonitoredPair& pair) { return !pair.allowed; });
  report->result = nullptr;
  report->containment = nullptr;
  try {
    detectAtStamp(options, *scene, report);
    noteRejected(report);
    if (settings_.containment) findInside(limits, report);
    std::size_t used = 0;
    for (SweepReport& sweep : report->sweeps) {
      if (sweep.from.isZero()) continue;
      if (used == intervals_.size()) intervals_.emplace_back(detector_);
      runInterval(options, scene, &intervals_[used++], &sweep);
    }
  } catch (...) {
    report->result = nullptr;
    throw;
  }
}

void CycleDetection::detectAtStamp(const Options& options, const Scene& scene,
                                   CycleReport* report) {
  DetectionResult& result = unshared(&result_);
  if (settings_.keep_warm_start && !anyPairEnabled(scene, *report)) {
    result.begin(scene, options, isGuaranteed(options));
  } else {
    detector_.detect(scene, options);
    detector_.swapResult(result);
    report->backend = detector_.backend();  // it may have fallen back to the CPU
  }
  report->scene = &scene;
  report->result = result_;
}

// Finds parts within other bodies, unless contacts are missing: a part that touches the surface is
// not inside, and then it is not known which parts touch. If the result has distances, parts of
// pairs that are not certain to be apart are listed as well; PairStates decides about these.
void CycleDetection::findInside(const Limits& limits, CycleReport* report) {
  const DetectionResult& result = *report->result;
  const bool knows_apart = !result.cut_off || !result.distances.empty();
  if (!knows_apart || result.left_out > 0) return;
  const CycleLimit limit(limits);
  report->containment =
      std::make_shared<const Containment>(containment_.find(*report->scene, result, limit));
}

void CycleDetection::runInterval(const Options& options, Scene* scene, Interval* interval,
                                 SweepReport* sweep) {
  const SteadyTime start = std::chrono::steady_clock::now();
  Options swept = options;
  swept.motion = Motion::kSwept;
  swept.first_times = true;
  swept.nearest = swept.nearest_by_part = false;  // distances are those of the stamp
  swept.geometry = false;
  IntervalPairs pairs(scene);
  sweep->result = nullptr;
  sweep->problem.clear();
  try {
    std::vector<BodyPath> paths;
    for (BodyId id = 0; id < scene->bodyCount(); ++id) {
      setEarlier(sweep->bodies[id], id, scene);
      paths.push_back(sweep->bodies[id].path);
    }
    StepResult& result = unshared(&interval->result);
    if (pairs.enable(*sweep)) {
      interval->detector.detect(*scene, paths, settings_.swept_tolerance_m, swept);
      interval->detector.swapResult(result);
    } else {
      result = StepResult();
      result.detection.begin(*scene, swept, isGuaranteed(swept));
    }
    sweep->result = interval->result;
    noteRejectedOfInterval(*scene, sweep);
  } catch (const std::exception& error) {
    ROS_ERROR_STREAM("the step's detection failed, its pairs are UNKNOWN: "
                     << error.what() << "; see config/docs/console.md#detection-fails");
    sweep->result = nullptr;
    sweep->problem = error.what();
  }
  sweep->compute_s = toSeconds(std::chrono::steady_clock::now() - start);
}

}  // namespace deformable_contact_monitor
