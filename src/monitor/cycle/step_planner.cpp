// Plans the time intervals of continuous collision detection that end with a cycle.
//
// An interval starts at the previous cycle of whoever triggered this one, so that the intervals of
// an object follow each other without gaps. The other body of a pair starts where that previous
// cycle saw it, even if newer meshes of it came in between. Of a pair of two objects, the interval
// starts at whichever cycle of either came last. So the pair's intervals follow each other without
// gaps as well, although the cycles of both take turns.
#include "monitor/cycle/step_planner.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kSamplePeriodS = 0.005;
constexpr std::int64_t kMostParts = 200;

// Compares poses up to the rounding of interpolated transforms [m], which is far below that of
// float32 vertices.
bool isSame(const RigidTransform& a, const RigidTransform& b) {
  const auto is_close = [](double x, double y) { return std::abs(x - y) <= 1e-12; };
  return std::equal(std::begin(a.rotation), std::end(a.rotation), std::begin(b.rotation),
                    is_close) &&
         std::equal(std::begin(a.translation), std::end(a.translation), std::begin(b.translation),
                    is_close);
}

// Returns the bodies of one who triggers cycles: an object, or all links for the robot. Rigid
// objects trigger none.
std::vector<BodyId> bodiesOf(std::size_t who, const MonitorScene& scene) {
  const std::size_t first_object = scene.firstObject();
  const bool is_object = who < scene.bodies().size() - first_object;
  const std::size_t begin = is_object ? first_object + who : 0;
  const std::size_t end = is_object ? begin + 1 : scene.firstRigid();
  std::vector<BodyId> bodies;
  for (std::size_t id = begin; id < end; ++id) bodies.push_back(static_cast<BodyId>(id));
  return bodies;
}

// Takes over what the prepared scene uses of each body.
UsedCycle usedCycle(const CycleReport& report, const MonitorScene& scene) {
  UsedCycle used{report.header.stamp, report.cycle, {}};
  used.bodies.resize(scene.bodies().size());
  for (BodyId id = 0; id < used.bodies.size(); ++id) {
    const BodyStatus& body = scene.bodies()[id];
    if (body.stamp.isZero() || !body.unknown_because.empty()) continue;
    const IncomingMesh* const mesh = scene.loadedMesh(id);
    used.bodies[id] =
        UsedBody{body.stamp, scene.scene().body(id).pose, mesh ? *mesh : IncomingMesh(),
                 mesh ? FramePlace() : scene.placeOf(id)};
  }
  return used;
}

// Returns where a body is.
FramePlace placeIn(const UsedBody& body) {
  if (body.mesh.message == nullptr) return body.place;
  return {plainFrame(body.mesh.message->header.frame_id)};
}

// Returns why a body that is known now has no interval from an earlier cycle; empty if it has one.
std::string bodyProblem(const UsedCycle& from_cycle, const UsedCycle& now, BodyId id) {
  const std::optional<UsedBody>& from = from_cycle.bodies.at(id);
  const UsedBody& to = *now.bodies[id];
  if (!from) return "not known in the previous cycle";
  if (to.stamp < from->stamp) return "its stamps went back";
  if (to.mesh.topology != from->mesh.topology) return "other triangles than in the previous cycle";
  if (placeIn(to) == placeIn(*from)) return "";
  return "another frame than in the previous cycle";
}

// Returns how the body's frame moved between two cycles; empty if it stood still. Throws
// std::runtime_error if transforms are missing.
BodyPath pathBetween(const UsedBody& from, const UsedBody& to, const TransformLookup& lookup) {
  const FramePlace place = placeIn(to);
  const std::int64_t length_ns = nanosecondsBetween(to.stamp, from.stamp);
  const std::int64_t parts = std::clamp<std::int64_t>(
      std::llround(std::ceil(static_cast<double>(length_ns) / 1e9 / kSamplePeriodS)), 1,
      kMostParts);
  BodyPath path{{0, from.pose}};
  for (std::int64_t i = 1; i < parts; ++i) {
    ros::Time stamp;
    stamp.fromNSec(from.stamp.toNSec() + length_ns * i / parts);
    const PoseAnswer answer = lookup.lookup({{place.frame, stamp}}).front();
    if (!answer.problem.empty()) throw std::runtime_error(answer.problem);
    path.push_back({static_cast<double>(i) / static_cast<double>(parts),
                    compose(answer.pose, place.frame_from_body)});
  }
  path.push_back({1, to.pose});
  const bool stands_still = std::all_of(path.begin(), path.end(), [&to](const PoseSample& sample) {
    return isSame(sample.pose, to.pose);
  });
  return stands_still ? BodyPath() : path;
}

// Returns where the body was and how it came here. If transforms between the cycles are missing, it
// is skipped.
StepBody stepBody(const UsedCycle& from_cycle, const UsedCycle& now, BodyId id,
                  const std::string& reference_frame, const TransformLookup& lookup) {
  StepBody body;
  body.takes_part = true;
  body.skipped = bodyProblem(from_cycle, now, id);
  if (!body.skipped.empty()) return body;
  const UsedBody& from = *from_cycle.bodies[id];
  const UsedBody& to = *now.bodies[id];
  body.pose = from.pose;
  if (from.mesh.message != to.mesh.message) body.mesh = from.mesh.message;
  if (placeIn(to).frame == reference_frame) return body;
  try {
    body.path = pathBetween(from, to, lookup);
  } catch (const std::exception& error) {
    body.skipped = std::string("between the cycles: ") + error.what();
  }
  return body;
}

}  // namespace

StepPlanner::StepPlanner(const MonitorParameters& parameters)
    : parameters_(parameters), previous_(parameters.objects.size() + 1) {}

void StepPlanner::forget(std::size_t object, const std::string& why) {
  previous_[object] = {nullptr, why};
}

void StepPlanner::forgetAll(const std::string& why) {
  for (Previous& previous : previous_) previous = {nullptr, why};
}

std::vector<SweepReport> StepPlanner::plan(const CycleTrigger& trigger, const MonitorScene& scene,
                                           const TransformLookup& lookup,
                                           const CycleReport& report) {
  if (parameters_.motion == Motion::kInstant) return {};
  const auto used = std::make_shared<const UsedCycle>(usedCycle(report, scene));
  std::vector<std::size_t> triggers = trigger.objects;
  if (trigger.robot) triggers.push_back(parameters_.objects.size());

  // Both are indexed by the number of the cycle that an interval starts from.
  std::map<std::uint64_t, SweepReport> intervals;
  std::map<std::uint64_t, std::shared_ptr<const UsedCycle>> starts;
  const auto intervalFrom = [&](const std::shared_ptr<const UsedCycle>& from) -> SweepReport& {
    const std::uint64_t number = from == nullptr ? 0 : from->cycle;
    starts[number] = from;
    SweepReport& interval = intervals[number];
    interval.bodies.resize(scene.bodies().size());
    if (number > 0) interval.from = from->stamp;
    return interval;
  };
  Beginnings beginnings;
  for (const std::size_t who : triggers) {
    const std::vector<BodyId> bodies = bodiesOf(who, scene);
    const std::string problem = problemOf(who, *used, bodies.empty() ? 0 : bodies.front());
    const std::shared_ptr<const UsedCycle> from = problem.empty() ? previous_[who].used : nullptr;
    beginnings[who] = from;
    SweepReport& interval = intervalFrom(from);
    interval.triggered.insert(interval.triggered.end(), bodies.begin(), bodies.end());
    for (const BodyId id : bodies) interval.bodies[id].skipped = problem;
  }
  planned_ = used;
  planned_triggers_ = std::move(triggers);
  for (const MonitoredPair& pair : report.pairs) {
    if (!scene.scene().pairEnabled(pair.a, pair.b)) continue;
    intervalFrom(startOf(pair, scene, beginnings)).pairs.push_back(pair);
  }

  std::vector<SweepReport> planned;
  for (auto& [number, interval] : intervals) {
    std::sort(interval.triggered.begin(), interval.triggered.end());
    for (const MonitoredPair& pair : interval.pairs) {
      for (const BodyId id : {pair.a, pair.b}) {
        StepBody& body = interval.bodies[id];
        if (number == 0 || body.takes_part) continue;
        body = stepBody(*starts[number], *used, id, parameters_.reference_frame, lookup);
      }
    }
    planned.push_back(std::move(interval));
  }
  return planned;
}

void StepPlanner::commit() {
  for (const std::size_t who : planned_triggers_) previous_[who] = {planned_, ""};
  planned_triggers_.clear();
}

// Returns the cycle that the pair's interval starts from; null if there is none.
std::shared_ptr<const UsedCycle> StepPlanner::startOf(const MonitoredPair& pair,
                                                      const MonitorScene& scene,
                                                      const Beginnings& beginnings) const {
  const BodyId first = scene.firstObject();
  const auto isTrigger = [&](BodyId id) { return id >= first && beginnings.count(id - first) > 0; };
  if (pair.b < first) {  // no deformable object
    const auto of_robot = beginnings.find(parameters_.objects.size());
    return of_robot == beginnings.end() ? nullptr : of_robot->second;
  }
  std::shared_ptr<const UsedCycle> start;
  for (const BodyId id : {pair.a, pair.b}) {
    if (!isTrigger(id)) continue;
    const std::shared_ptr<const UsedCycle>& from = beginnings.at(id - first);
    if (from != nullptr && (start == nullptr || from->cycle > start->cycle)) start = from;
  }
  if (start == nullptr) return nullptr;
  for (const BodyId id : {pair.a, pair.b}) {
    if (id < first || isTrigger(id)) continue;
    const std::shared_ptr<const UsedCycle>& partners = previous_[id - first].used;
    const bool is_later = partners != nullptr && partners->cycle > start->cycle &&
                          partners->stamp >= start->stamp && partners->stamp <= planned_->stamp;
    if (is_later && partners->bodies.at(pair.a) && partners->bodies.at(pair.b)) start = partners;
  }
  return start;
}

// Returns why there is no interval from the previous cycle of whoever triggered this one; empty if
// there is one.
std::string StepPlanner::problemOf(std::size_t who, const UsedCycle& now, BodyId first_body) const {
  const Previous& previous = previous_[who];
  if (previous.used == nullptr) return previous.why;
  const double gap_s = secondsBetween(now.stamp, previous.used->stamp);
  if (gap_s > parameters_.max_mesh_age_s) {
    return "its previous cycle is " + std::to_string(gap_s) + " s older, more than max_mesh_age_s";
  }
  // An object that is not known now is reported as such elsewhere.
  const bool is_object = who < parameters_.objects.size();
  if (!is_object || !now.bodies[first_body]) return "";
  return bodyProblem(*previous.used, now, first_body);
}

}  // namespace deformable_contact_monitor
