// Which steps of swept motion end with a cycle: from where, of which pairs, on which ways.
#include "monitor/cycle/step_planner.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kSamplePeriodS = 0.005;
constexpr std::int64_t kMostParts = 200;

// But for the rounding of transforms that are interpolated [m]; float32 vertices have more.
bool isSame(const RigidTransform& a, const RigidTransform& b) {
  const auto is_close = [](double x, double y) { return std::abs(x - y) <= 1e-12; };
  return std::equal(std::begin(a.rotation), std::end(a.rotation), std::begin(b.rotation),
                    is_close) &&
         std::equal(std::begin(a.translation), std::end(a.translation), std::begin(b.translation),
                    is_close);
}

// Where a body's frame was between two cycles; empty: where it is now, all the time. Throws
// std::runtime_error where the transforms do not say.
BodyPath pathBetween(const UsedBody& from, const UsedBody& to, const std::string& frame,
                     const TransformLookup& lookup) {
  const std::int64_t length_ns = nanosecondsBetween(to.stamp, from.stamp);
  const std::int64_t parts = std::clamp<std::int64_t>(
      std::llround(std::ceil(1e-9 * static_cast<double>(length_ns) / kSamplePeriodS)), 1,
      kMostParts);
  std::vector<FrameAtStamp> frames;
  for (std::int64_t i = 1; i < parts; ++i) {
    ros::Time stamp = from.stamp;
    frames.push_back({frame, stamp.fromNSec(from.stamp.toNSec() + length_ns * i / parts)});
  }
  BodyPath path{{0, from.pose}};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const PoseAnswer answer = lookup.lookup({frames[i]}).front();
    if (!answer.problem.empty()) throw std::runtime_error(answer.problem);
    path.push_back({static_cast<double>(i + 1) / static_cast<double>(parts), answer.pose});
  }
  path.push_back({1, to.pose});
  const bool stands = std::all_of(path.begin(), path.end(), [&](const PoseSample& sample) {
    return isSame(sample.pose, to.pose);
  });
  return stands ? BodyPath() : path;
}

// What all steps of a cycle are made from.
struct Cycle {
  const MonitorParameters& parameters;
  const MonitorScene& scene;
  const TransformLookup& lookup;
  const UsedCycle& now;
};

// Why a body that is known now has no step from there; empty: it has one.
std::string bodyProblem(const std::optional<UsedBody>& from, const UsedBody& to) {
  if (!from) return "not known in the previous cycle";
  if (to.stamp < from->stamp) return "its stamps went back";
  if (to.mesh.topology != from->mesh.topology) return "other triangles than in the previous cycle";
  if (to.mesh.message == nullptr) return "";
  return plainFrame(to.mesh.message->header.frame_id) ==
                 plainFrame(from->mesh.message->header.frame_id)
             ? ""
             : "another frame than in the previous cycle";
}

StepBody stepBody(const Cycle& cycle, BodyId id, const UsedCycle& from_cycle) {
  StepBody body;
  body.takes_part = true;
  const UsedBody& to = *cycle.now.bodies[id];
  const std::optional<UsedBody>& from = from_cycle.bodies.at(id);
  body.skipped = bodyProblem(from, to);
  if (!body.skipped.empty()) return body;
  body.pose = from->pose;
  if (from->mesh.message != to.mesh.message) body.mesh = from->mesh.message;
  const std::string frame = to.mesh.message == nullptr
                                ? cycle.scene.bodies()[id].name
                                : plainFrame(to.mesh.message->header.frame_id);
  if (frame == cycle.parameters.reference_frame) return body;
  try {
    body.path = pathBetween(*from, to, frame, cycle.lookup);
  } catch (const std::exception& error) {
    body.skipped = std::string("between the cycles: ") + error.what();
  }
  return body;
}

void addBodies(const Cycle& cycle, const UsedCycle& from, SweepReport* step) {
  for (const MonitoredPair& pair : step->pairs) {
    for (const BodyId id : {pair.a, pair.b}) {
      StepBody& body = step->bodies[id];
      if (!body.takes_part) body = stepBody(cycle, id, from);
    }
  }
}

// Why there is no step from the previous cycle of one who triggers; empty: there is one.
std::string stepProblem(const Cycle& cycle, const EarlierStates& earlier, std::size_t who,
                        const std::vector<BodyId>& bodies) {
  const std::shared_ptr<const UsedCycle>& from = earlier.of(who);
  if (from == nullptr) return earlier.why(who);
  const double gap_s = secondsBetween(cycle.now.stamp, from->stamp);
  if (gap_s > cycle.parameters.max_mesh_age_s) {
    return "its previous cycle is " + std::to_string(gap_s) + " s older, more than max_mesh_age_s";
  }
  const bool is_object = who < cycle.parameters.objects.size();
  if (!is_object || !cycle.now.bodies[bodies.front()]) return "";  // if unknown, it says so itself
  return bodyProblem(from->bodies.at(bodies.front()), *cycle.now.bodies[bodies.front()]);
}

// Which bodies are those of one who triggers cycles.
std::vector<BodyId> bodiesOf(std::size_t who, const MonitorScene& scene) {
  const std::size_t first_object = scene.firstObject();
  const bool is_object = who < scene.bodies().size() - first_object;
  std::vector<BodyId> bodies;
  const std::size_t begin = is_object ? first_object + who : 0;
  const std::size_t end = is_object ? begin + 1 : first_object;
  for (std::size_t id = begin; id < end; ++id) bodies.push_back(static_cast<BodyId>(id));
  return bodies;
}

// Of the cycle's pairs, by number of that which they start from; 0: none.
using Steps = std::map<std::uint64_t, SweepReport>;

// Whose cycle's number the pair's step starts from: of two, the pair's own previous one.
std::uint64_t beginningOf(const MonitoredPair& pair, const MonitorScene& scene,
                          const std::map<std::size_t, std::uint64_t>& beginnings) {
  const BodyId first = scene.firstObject();
  const auto of = [&](BodyId id) {
    const auto found = beginnings.find(id < first ? scene.bodies().size() - first : id - first);
    return found == beginnings.end() ? 0 : found->second;
  };
  if (pair.b < first) return of(pair.b);  // two links
  return pair.a < first ? of(pair.b) : std::max(of(pair.a), of(pair.b));
}

}  // namespace

StepPlanner::StepPlanner(const MonitorParameters& parameters)
    : parameters_(parameters), earlier_(parameters.objects.size()) {}

void StepPlanner::plan(const CycleTrigger& trigger, const MonitorScene& scene,
                       const TransformLookup& lookup, CycleReport* report) {
  report->motion = parameters_.motion;
  if (parameters_.motion == Motion::kInstant) return;
  const auto used =
      std::make_shared<const UsedCycle>(usedCycle(report->header.stamp, report->cycle, scene));
  const Cycle cycle{parameters_, scene, lookup, *used};
  std::vector<std::size_t> who = trigger.objects;
  if (trigger.robot) who.push_back(parameters_.objects.size());

  Steps steps;
  std::map<std::size_t, std::uint64_t> beginnings;
  std::map<std::uint64_t, std::shared_ptr<const UsedCycle>> used_then;
  for (const std::size_t one : who) {
    const std::vector<BodyId> bodies = bodiesOf(one, scene);
    const std::string problem = stepProblem(cycle, earlier_, one, bodies);
    const std::uint64_t number = problem.empty() ? earlier_.of(one)->cycle : 0;
    beginnings[one] = number;
    used_then[number] = earlier_.of(one);
    SweepReport& step = steps[number];
    step.bodies.resize(scene.bodies().size());
    if (number > 0) step.from = earlier_.of(one)->stamp;
    step.triggered.insert(step.triggered.end(), bodies.begin(), bodies.end());
    for (const BodyId id : bodies) step.bodies[id].skipped = problem;
    earlier_.keep(one, used);
  }
  for (const MonitoredPair& pair : report->pairs) {
    if (!scene.scene().pairEnabled(pair.a, pair.b)) continue;
    steps[beginningOf(pair, scene, beginnings)].pairs.push_back(pair);
  }
  for (auto& [number, step] : steps) {
    std::sort(step.triggered.begin(), step.triggered.end());
    if (number > 0) addBodies(cycle, *used_then[number], &step);
    report->sweeps.push_back(std::move(step));
  }
}

}  // namespace deformable_contact_monitor
