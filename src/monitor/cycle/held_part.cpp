// Finds the part of an object that a robot holds. It runs once for each call of ~attach_object, so
// it compares all triangles that boxes do not keep apart, and needs no tree.
#include "monitor/cycle/held_part.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "core/common/posed_body.h"
#include "core/predicates/aabb.h"
#include "core/predicates/narrow_phase.h"
#include "core/predicates/triangle_intersection.h"
#include "monitor/cycle/rigid_place.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostPartsBesideHeld = 127;  // each of them may be split, and so may the rest

// Some triangles in the scene frame, and a box around them.
struct Block {
  std::vector<Triangle> triangles;
  Aabb box;
  float within_m;  // of these triangles
};

// Returns the finite triangles of a body in blocks of neighbors. `radius_m` counts from its
// surface.
std::vector<Block> blocksOf(const Body& body, float radius_m) {
  constexpr std::size_t kBlock = 32;
  const PosedBody posed(body);
  std::vector<Block> blocks;
  for (std::uint32_t t = 0; t < body.mesh.triangleCount(); ++t) {
    const Triangle triangle = posed.triangle(t);
    if (!isFinite(triangle)) continue;
    if (blocks.empty() || blocks.back().triangles.size() == kBlock)
      blocks.push_back({{}, {}, radius_m + body.radius_m});
    blocks.back().triangles.push_back(triangle);
    for (const Vec3f& corner : triangle.v) blocks.back().box.include(corner);
  }
  return blocks;
}

bool isWithin(const Triangle& a, const Triangle& b, float radius_m) {
  if (areApart(boxOf(a), boxOf(b), radius_m)) return false;
  PredicateState state{Predicates::kExact};
  return trianglesIntersect(a, b, state) || nearVerdict(a, b, radius_m).contact;
}

std::string metres(float length_m) {
  std::ostringstream text;
  text << length_m << " m";
  return text.str();
}

// Adds the body with its pose. Throws std::invalid_argument if the pose is not known.
BodyId addPosed(const std::string& name, TriangleMesh mesh, const FrameAtStamp& frame,
                const MonitorParameters& parameters, const TransformLookup& lookup, Scene* scene,
                const RigidTransform& frame_from_body = {}) {
  const BodyId id = scene->addBody(name, std::move(mesh));
  scene->setPose(id, frame_from_body);
  if (frame.frame == parameters.reference_frame) return id;
  const PoseAnswer answer = lookup.lookup({frame}).front();
  if (!answer.problem.empty()) throw std::invalid_argument(name + ": " + answer.problem);
  scene->setPose(id, compose(answer.pose, frame_from_body));
  return id;
}

FrameAtStamp frameOf(const IncomingMesh& mesh) {
  return {plainFrame(mesh.message->header.frame_id), mesh.stamp()};
}

// Returns the frame of a holding link or rigid object.
FrameAtStamp frameOf(const std::string& holder, const HoldQuestion& question,
                     const MonitorParameters& parameters) {
  const ros::Time stamp = question.mesh.stamp();
  const RigidParameters* const rigid = findRigid(parameters, holder);
  if (rigid != nullptr) return {placeOf(*rigid, question.attached, parameters).frame, stamp};
  return {parameters.frameOf(holder), stamp, holder};
}

// Returns "finger, palm".
std::string namesOf(const std::vector<std::string>& links) {
  std::string text;
  for (const std::string& link : links) text += (text.empty() ? "" : ", ") + link;
  return text;
}

}  // namespace

std::vector<std::uint32_t> trianglesWithin(const Scene& scene, BodyId body, float radius_m) {
  std::vector<Block> others;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (id == body) continue;
    std::vector<Block> blocks = blocksOf(scene.body(id), radius_m);
    std::move(blocks.begin(), blocks.end(), std::back_inserter(others));
  }
  Aabb all;
  float most_m = 0;
  for (const Block& block : others) {
    most_m = std::max(most_m, block.within_m);
    all.include(block.box.min);
    all.include(block.box.max);
  }
  const PosedBody posed(scene.body(body));
  std::vector<std::uint32_t> within;
  for (std::uint32_t t = 0; t < scene.body(body).mesh.triangleCount(); ++t) {
    const Triangle triangle = posed.triangle(t);
    if (!isFinite(triangle)) continue;
    const Aabb box = boxOf(triangle);
    if (others.empty() || areApart(box, all, most_m)) continue;
    const bool is_within = std::any_of(others.begin(), others.end(), [&](const Block& block) {
      return !areApart(box, block.box, block.within_m) &&
             std::any_of(block.triangles.begin(), block.triangles.end(),
                         [&](const Triangle& o) { return isWithin(triangle, o, block.within_m); });
    });
    if (is_within) within.push_back(t);
  }
  return within;
}

std::string holdProblem(const std::string& object, float radius_m,
                        const MonitorParameters& parameters) {
  if (!std::isfinite(radius_m) || radius_m < 0) {
    return "the radius is " + std::to_string(radius_m) + ", must be a finite number >= 0 [m]";
  }
  const std::string part = object + ":" + kHeldPart;
  const std::string beside_part = "for '" + object + "' beside the object '" + part + "'";
  std::string problem;
  const auto refuse = [&problem](const std::string& because) {
    problem += (problem.empty() ? "a radius is not supported " : ", and not ") + because;
  };
  if (parameters.detector.tolerance_m > 0) refuse("with tolerance_m above 0");
  if (parameters.containment) refuse("with containment: true");
  for (const ObjectParameters& other : parameters.objects) {
    if (other.name == object && other.type == MeshType::kPointCloud && other.faces == nullptr) {
      refuse("for a point_cloud without faces, whose triangles do not follow the object");
    }
    if (other.name == object && other.type == MeshType::kPoints) {
      refuse("for points, which may come in another order");
    }
    if (other.name == part) refuse(beside_part);
    if (other.name == object && other.parts.size() > kMostPartsBesideHeld) {
      refuse("for an object with " + std::to_string(other.parts.size()) +
             " parts, must be at most " + std::to_string(kMostPartsBesideHeld));
    }
  }
  if (findRigid(parameters, part) != nullptr) {
    refuse(beside_part);
  }
  return problem;
}

std::vector<FrameAtStamp> framesOfHold(const HoldQuestion& question,
                                       const MonitorParameters& parameters) {
  std::vector<FrameAtStamp> frames = {frameOf(question.mesh)};
  for (const std::string& link : question.links) {
    frames.push_back(frameOf(link, question, parameters));
  }
  frames.erase(std::remove_if(frames.begin(), frames.end(),
                              [&](const FrameAtStamp& one) {
                                return one.frame == parameters.reference_frame;
                              }),
               frames.end());
  return frames;
}

std::shared_ptr<const HeldPart> findHeldPart(const HoldQuestion& question,
                                             const RobotGeometry& robot,
                                             const MonitorParameters& parameters,
                                             const TransformLookup& lookup) {
  const IncomingMesh& mesh = question.mesh;
  Scene scene;
  const BodyId object =
      addPosed(question.object, {mesh.message->vertices, mesh.topology->triangles}, frameOf(mesh),
               parameters, lookup, &scene);
  for (const LinkGeometry& link : robot.links) {
    const bool is_asked =
        std::find(question.links.begin(), question.links.end(), link.link) != question.links.end();
    if (!is_asked) continue;
    if (!link.problem.empty()) throw std::invalid_argument(link.link + ": " + link.problem);
    addPosed(link.link, link.mesh, frameOf(link.link, question, parameters), parameters, lookup,
             &scene);
  }
  for (const std::string& holder : question.links) {
    const RigidParameters* const rigid = findRigid(parameters, holder);
    if (rigid == nullptr) continue;
    const BodyId id =
        addPosed(holder, *rigid->mesh, frameOf(holder, question, parameters), parameters, lookup,
                 &scene, placeOf(*rigid, question.attached, parameters).frame_from_body);
    scene.setRadius(id, rigid->radius_m);
  }
  if (scene.bodyCount() == 1) {
    throw std::invalid_argument(
        "none of these links has geometry that is looked at, so nothing is "
        "within a radius of them: " +
        namesOf(question.links));
  }
  float within_m = question.radius_m;
  for (const ObjectParameters& one : parameters.objects) {
    if (one.name == question.object) within_m += one.radius_m;
  }
  HeldPart held{question.radius_m, trianglesWithin(scene, object, within_m), mesh.topology,
                mesh.stamp()};
  if (held.triangles.empty()) {
    throw std::invalid_argument("no triangle of " + question.object + " lies within " +
                                metres(question.radius_m) + " of " + namesOf(question.links));
  }
  return std::make_shared<const HeldPart>(std::move(held));
}

}  // namespace deformable_contact_monitor
