// The scene of a cycle: its bodies, their poses and meshes, and the pairs that are computed.
#include "monitor/cycle/monitor_scene.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>

#include "monitor/time_difference.h"
#include "robot/nearest_name.h"

namespace deformable_contact_monitor {
namespace {

// Returns the stand-in for a robot that is not known.
RobotGeometry missingRobot(const std::string& why) {
  RobotGeometry robot;
  robot.links.push_back({"robot", "", TriangleMesh(), why});
  return robot;
}

}  // namespace

MonitorScene::MonitorScene(const MonitorParameters& parameters,
                           std::pmr::memory_resource& vertex_memory)
    : parameters_(parameters), vertex_memory_(vertex_memory) {
  rules_.allowed = parameters.allowed_contacts;
  for (const ObjectParameters& object : parameters.objects) choosers_.emplace_back(object);
  setRobot(parameters.pair_classes.needRobot() ? missingRobot("no robot received yet")
                                               : RobotGeometry());
}

// The new scene is built completely before it replaces the old one.
void MonitorScene::setRobot(const RobotGeometry& robot) {
  if (parameters_.pair_classes.needRobot() && robot.links.empty()) {
    return setRobot(missingRobot("the robot has no link with geometry"));
  }
  Scene scene;
  scene.useMemory(vertex_memory_);
  std::vector<BodyStatus> bodies;
  std::vector<std::string> problems;
  const auto addBody = [&](BodyStatus body, TriangleMesh mesh, double margin_m) {
    const BodyId id = scene.addBody(body.name, std::move(mesh));
    scene.setMargin(id, static_cast<float>(margin_m));
    bodies.push_back(std::move(body));
  };
  for (const LinkGeometry& link : robot.links) {
    addBody({link.link, BodyKind::kLink, ros::Time(), 0, ""}, link.mesh,
            linkMarginM(parameters_, link.link));
    problems.push_back(link.problem);
  }
  for (const RigidParameters& rigid : parameters_.rigids) {
    addBody({rigid.name, BodyKind::kRigid, ros::Time(), 0, ""}, *rigid.mesh, rigid.margin_m);
    scene.setRadius(static_cast<BodyId>(scene.bodyCount() - 1), rigid.radius_m);
    problems.emplace_back();
  }
  for (std::size_t i = 0; i < choosers_.size(); ++i) {
    BodyStatus body = bodyOf(parameters_.objects[i]);
    body.parts = choosers_[i].parts();
    addBody(std::move(body), TriangleMesh(), parameters_.objects[i].margin_m);
    scene.setRadius(static_cast<BodyId>(scene.bodyCount() - 1), parameters_.objects[i].radius_m);
  }
  scene_ = std::move(scene);
  bodies_ = std::move(bodies);
  posed_problems_ = std::move(problems);
  first_rigid_ = static_cast<BodyId>(robot.links.size());
  first_object_ = static_cast<BodyId>(posed_problems_.size());
  loaded_.assign(parameters_.objects.size(), IncomingMesh());
  parts_in_scene_.assign(parameters_.objects.size(), nullptr);
  rules_.links = LinkRules(robot.robots);
  applyMargin();
  listPairs();
}

// Lists all pairs of the enabled classes anew, after a rule or a body has changed.
void MonitorScene::listPairs() {
  pairs_ = monitoredPairs(bodies_, classes_.value_or(parameters_.pair_classes), rules_);
  part_pairs_ = monitoredPartPairs(bodies_, pairs_, rules_);
  allowed_parts_ = nullptr;
  if (part_pairs_.empty() && scene_.disabledParts().empty()) return;
  scene_.enableAllParts();
  std::vector<PartPair> allowed = allowedParts(bodies_, pairs_, rules_);
  if (allowed.empty()) return;
  for (const PartPair& pair : allowed) {
    scene_.setPartPairEnabled(pair.body_a, pair.part_a, pair.body_b, pair.part_b, false);
  }
  allowed_parts_ = std::make_shared<const std::vector<PartPair>>(std::move(allowed));
}

void MonitorScene::setAllowedContacts(const AllowedContacts& allowed) {
  rules_.allowed = allowed;
  listPairs();
}

void MonitorScene::setAttached(const AttachedObjects& attached) {
  rules_.attached = attached;
  rules_.ended_holds.clear();
  for (std::size_t i = 0; i < choosers_.size(); ++i) {
    const auto found = attached.find(parameters_.objects[i].name);
    choosers_[i].hold(found == attached.end() ? nullptr : found->second.part);
    bodies_[first_object_ + i].parts = choosers_[i].parts();
    showParts(i);
  }
  listPairs();
}

// Chooses the parts of objects in their newest meshes, ends each hold whose object has other
// triangles now, and lists the pairs anew where parts have changed. It runs before anything is
// looked up for the cycle's pairs, because a link that held all of an object may have none of them.
void MonitorScene::followParts(const ros::Time& t, const MeshChoice& choose) {
  bool has_changed = false;
  for (std::size_t i = 0; i < choosers_.size(); ++i) {
    PartChooser& chooser = choosers_[i];
    const std::shared_ptr<const HeldPart> held = chooser.held();
    std::string why_not;
    const bool has_parts = held != nullptr || !parameters_.objects[i].parts.empty();
    const IncomingMesh* const mesh = has_parts ? choose(i, &why_not) : nullptr;
    if (mesh == nullptr || mesh->topology == nullptr) continue;
    const std::shared_ptr<const BodyParts> before = chooser.parts();
    chooser.update(*mesh);
    // After the clock has jumped back, the stamp of the hold says nothing.
    const bool jumped =
        held != nullptr && secondsBetween(held->stamp, t) > parameters_.max_mesh_age_s;
    if (held != nullptr && !chooser.fitsHeld() && (jumped || mesh->stamp() > held->stamp)) {
      const auto ended = rules_.attached.find(parameters_.objects[i].name);
      rules_.ended_holds.insert(*ended);
      rules_.attached.erase(ended);
      chooser.hold(nullptr);
    }
    has_changed = has_changed || chooser.parts() != before;
    bodies_[first_object_ + i].parts = chooser.parts();
  }
  if (has_changed) listPairs();
}

void MonitorScene::setPairClasses(const PairClasses& classes) {
  // enablePairs() visits listed pairs only, so pairs that are no longer listed are disabled here.
  for (const MonitoredPair& pair : pairs_) scene_.setPairEnabled(pair.a, pair.b, false);
  classes_ = classes;
  listPairs();
}

void MonitorScene::setMargin(double margin_m) {
  margin_m_ = margin_m;
  applyMargin();
}

// A margin that is set for one link or object itself takes precedence.
void MonitorScene::applyMargin() {
  if (!margin_m_) return;
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    if (sharesMargin(id)) scene_.setMargin(id, static_cast<float>(*margin_m_));
  }
}

bool MonitorScene::sharesMargin(BodyId id) const {
  if (isLink(id)) return parameters_.link_margin_m.count(bodies_[id].name) == 0;
  return isPosed(id) ? rigid(id).shares_margin
                     : parameters_.objects[id - first_object_].shares_margin;
}

// Removes the traces of the previous cycle.
void MonitorScene::clearStatuses() {
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    BodyStatus& body = bodies_[id];
    body.stamp = ros::Time();
    body.topology_id = 0;
    body.unknown_because = isPosed(id) ? posed_problems_[id] : "";
    body.triggered = false;
    body.without_mesh = false;
  }
}

// Notes whose cycle it is; isOfCycle() goes by this.
void MonitorScene::markTriggered(const CycleTrigger& trigger) {
  for (const std::size_t object : trigger.objects) bodies_[first_object_ + object].triggered = true;
  for (BodyId id = 0; trigger.robot && isLink(id); ++id) bodies_[id].triggered = true;
}

void MonitorScene::markUnknown(const std::vector<std::string>& why) {
  clearStatuses();
  for (std::size_t i = 0; i < why.size(); ++i) {
    bodies_[first_object_ + i].unknown_because = why[i];
  }
}

CycleReport MonitorScene::makeReport(const ros::Time& stamp, std::uint64_t cycle) const {
  CycleReport report;
  report.header.stamp = stamp;
  report.header.frame_id = parameters_.reference_frame;
  report.cycle = cycle;
  report.bodies = bodies_;
  report.pairs = pairs_;
  report.part_pairs = part_pairs_;
  report.allowed_parts = allowed_parts_;
  report.attached = rules_.attached;
  return report;
}

// Of a pair, pair.a is the link or the rigid object, and pair.b the object.
std::vector<FrameAtStamp> MonitorScene::awaitedFrames(std::size_t object, const ros::Time& t,
                                                      const IncomingMesh& mesh) const {
  std::vector<FrameAtStamp> frames;
  if (mesh.topology == nullptr) return frames;
  const BodyId id = first_object_ + static_cast<BodyId>(object);
  const std::string& own = mesh.message->header.frame_id;
  if (plainFrame(own) != parameters_.reference_frame) {
    frames.push_back({plainFrame(own), mesh.stamp()});
  }
  for (const MonitoredPair& pair : pairs_) {
    if (pair.allowed || pair.b != id || !isPosed(pair.a) || !posed_problems_[pair.a].empty() ||
        placeOf(pair.a).frame == parameters_.reference_frame) {
      continue;
    }
    frames.push_back(frameAt(pair.a, t));
  }
  return frames;
}

FramePlace MonitorScene::placeOf(BodyId id) const {
  if (isLink(id)) return {parameters_.frameOf(bodies_[id].name)};
  return deformable_contact_monitor::placeOf(rigid(id), rules_.attached, parameters_);
}

FrameAtStamp MonitorScene::frameAt(BodyId id, const ros::Time& t) const {
  return {placeOf(id).frame, t, isLink(id) ? bodies_[id].name : ""};
}

std::vector<std::string> MonitorScene::framesOfRobotCycle() const {
  std::set<std::string> frames;
  for (const MonitoredPair& pair : pairs_) {
    if (pair.allowed || !isPosed(pair.b)) continue;
    for (const BodyId id : {pair.a, pair.b}) {
      if (posed_problems_[id].empty()) frames.insert(placeOf(id).frame);
    }
  }
  return {frames.begin(), frames.end()};
}

TransformReport MonitorScene::prepare(const ros::Time& t, const CycleTrigger& trigger,
                                      const MeshInputs& inputs, const TransformLookup& lookup) {
  const auto isNotLate = [&](const IncomingMesh& mesh) {
    const FrameAtStamp frame{plainFrame(mesh.message->header.frame_id), mesh.stamp()};
    return lookup.lookup({frame}).front().outcome != PoseAnswer::Outcome::kLate;
  };
  const auto newest = [&](std::size_t object, std::string* why_not) {
    const auto& own = trigger.objects;
    if (std::find(own.begin(), own.end(), object) != own.end()) {
      return inputs[object].newestAt(t, why_not);
    }
    // The newest mesh of a partner may still wait for its transform, and for a cycle of its own. If
    // its transform will never come, older meshes do not stand in for it.
    return inputs[object].newestAt(t, why_not, isNotLate);
  };
  return prepareChosen(t, trigger, newest, lookup);
}

void MonitorScene::prepareStates(const ros::Time& t, StatesAsked question, const MeshChoice& choose,
                                 const TransformLookup& lookup) {
  states_ = std::move(question);
  CycleTrigger all{{}, true};
  for (std::size_t i = 0; i < choosers_.size(); ++i) all.objects.push_back(i);
  prepareChosen(t, all, choose, lookup);
}

TransformReport MonitorScene::prepareChosen(const ros::Time& t, const CycleTrigger& trigger,
                                            const MeshChoice& choose,
                                            const TransformLookup& lookup) {
  clearStatuses();
  markTriggered(trigger);
  // Transforms arrive meanwhile, and a mesh that is chosen twice must be the same.
  std::vector<std::optional<std::pair<const IncomingMesh*, std::string>>> chosen(choosers_.size());
  const MeshChoice once = [&](std::size_t object, std::string* why_not) {
    auto& one = chosen[object];
    if (!one) {
      one.emplace();
      one->first = choose(object, &one->second);
    }
    *why_not = one->second;
    return one->first;
  };
  followParts(t, once);
  const std::vector<const IncomingMesh*> meshes = chooseMeshes(once);
  const std::vector<bool> needed = neededBodies();

  std::vector<Question> questions;
  for (BodyId id = 0; id < bodies_.size(); ++id) {
    if (!needed[id] || !isKnown(id)) continue;
    if (states_ && states_->moved[id]) continue;
    if (isPosed(id)) {
      questions.push_back({id, frameAt(id, t)});
    } else {
      const IncomingMesh& mesh = *meshes[id - first_object_];
      questions.push_back({id, {plainFrame(mesh.message->header.frame_id), mesh.stamp()}});
    }
  }
  TransformReport report;
  poseBodies(questions, lookup, &report);

  for (BodyId id = first_object_; id < bodies_.size(); ++id) {
    if (needed[id] && isKnown(id)) loadMesh(id - first_object_, *meshes[id - first_object_]);
  }
  enablePairs();
  return report;
}

// Enables the cycle's pairs whose bodies are known, and disables all others.
void MonitorScene::enablePairs() {
  for (const MonitoredPair& pair : pairs_) {
    const bool enabled = !pair.allowed && isAbout(pair) && isKnown(pair.a) && isKnown(pair.b);
    scene_.setPairEnabled(pair.a, pair.b, enabled);
  }
}

// Returns the meshes of the objects that the cycle's pairs need, by object; null for the others.
std::vector<const IncomingMesh*> MonitorScene::chooseMeshes(const MeshChoice& choose) {
  std::vector<bool> asked(bodies_.size(), false);
  for (BodyId id = 0; id < bodies_.size(); ++id) asked[id] = !states_ && bodies_[id].triggered;
  for (const MonitoredPair& pair : pairs_) {
    if (!pair.allowed && isAbout(pair)) asked[pair.a] = asked[pair.b] = true;
  }
  std::vector<const IncomingMesh*> meshes(choosers_.size(), nullptr);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    BodyStatus& body = bodies_[first_object_ + i];
    if (!asked[first_object_ + i]) continue;
    meshes[i] = choose(i, &body.unknown_because);
    body.without_mesh = meshes[i] == nullptr;
  }
  return meshes;
}

// Returns which bodies are to be posed: those of the cycle's pairs with two known bodies, and all
// objects that triggered the cycle, because rviz shows them.
std::vector<bool> MonitorScene::neededBodies() const {
  std::vector<bool> needed(bodies_.size(), false);
  for (BodyId id = first_object_; id < bodies_.size(); ++id) {
    needed[id] = !states_ && bodies_[id].triggered;
  }
  for (const MonitoredPair& pair : pairs_) {
    if (pair.allowed || !isAbout(pair)) continue;
    if (!isKnown(pair.a) || !isKnown(pair.b)) continue;
    needed[pair.a] = needed[pair.b] = true;
  }
  return needed;
}

// Looks up all poses at once, and marks the bodies without one as UNKNOWN.
void MonitorScene::poseBodies(const std::vector<Question>& questions, const TransformLookup& lookup,
                              TransformReport* report) {
  std::vector<FrameAtStamp> frames;
  std::vector<BodyId> asked;
  for (const Question& question : questions) {
    bodies_[question.body].stamp = question.frame.stamp;
    // A mesh that is in the reference frame already keeps its coordinates bit by bit.
    if (question.frame.frame == parameters_.reference_frame) {
      scene_.setPose(question.body, isPosed(question.body) ? placeOf(question.body).frame_from_body
                                                           : RigidTransform());
      continue;
    }
    frames.push_back(question.frame);
    asked.push_back(question.body);
  }
  std::vector<PoseAnswer> answers = lookup.lookup(frames);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    BodyStatus& body = bodies_[asked[i]];
    PoseAnswer& answer = answers[i];
    report->asked.push_back(body.name);
    try {
      if (answer.problem.empty() && isPosed(asked[i])) {
        answer.pose = compose(answer.pose, placeOf(asked[i]).frame_from_body);
      }
      if (answer.problem.empty()) scene_.setPose(asked[i], answer.pose);
    } catch (const std::invalid_argument& error) {
      answer.problem = error.what();
    }
    if (answer.problem.empty()) continue;
    body.unknown_because = answer.problem;
    body.stamp = ros::Time();
    report->misses.push_back({body.name, std::move(answer)});
  }
}

// Hands the scene only what is new: the detectors keep what they computed from the triangles until
// these change, and from the vertices until those do.
void MonitorScene::loadMesh(std::size_t object, const IncomingMesh& mesh) {
  const BodyId id = first_object_ + static_cast<BodyId>(object);
  bodies_[id].topology_id = mesh.topology->id;
  IncomingMesh& loaded = loaded_[object];
  const std::vector<float>& vertices = mesh.message->vertices;
  if (loaded.topology != mesh.topology) {
    scene_.setMesh(id, {vertices, mesh.topology->triangles});
  } else if (loaded.message != mesh.message) {
    scene_.setVertices(id, vertices.data(), mesh.topology->vertex_count);
  }
  if (loaded.topology != mesh.topology) parts_in_scene_[object] = nullptr;
  choosers_[object].update(mesh);
  bodies_[id].parts = choosers_[object].parts();
  loaded = mesh;
  showParts(object);
}

// Gives the scene the object's parts, if it has a mesh with the triangles that they were chosen in.
void MonitorScene::showParts(std::size_t object) {
  const PartChooser& chooser = choosers_[object];
  const std::vector<PartId>& pieces = chooser.ofTriangles();
  const std::shared_ptr<const Topology>& topology = loaded_[object].topology;
  if (topology == nullptr || parts_in_scene_[object] == chooser.parts()) return;
  if (!pieces.empty() && pieces.size() != topology->triangles.size() / 3) return;
  const BodyId id = first_object_ + static_cast<BodyId>(object);
  scene_.setParts(id, pieces);
  scene_.setPartMargins(id, chooser.marginsOfPieces());
  parts_in_scene_[object] = chooser.parts();
}

}  // namespace deformable_contact_monitor
