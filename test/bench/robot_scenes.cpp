#include "robot_scenes.h"

#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/mesh_file.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// parent_from_child = a b.
RigidTransform composed(const RigidTransform& a, const RigidTransform& b) {
  RigidTransform out;
  for (int r = 0; r < 3; ++r) {
    out.translation[r] = a.translation[r];
    for (int k = 0; k < 3; ++k) out.translation[r] += a.rotation[3 * r + k] * b.translation[k];
    for (int c = 0; c < 3; ++c) {
      out.rotation[3 * r + c] = 0;
      for (int k = 0; k < 3; ++k) {
        out.rotation[3 * r + c] += a.rotation[3 * r + k] * b.rotation[3 * k + c];
      }
    }
  }
  return out;
}

RigidTransform toTransform(const urdf::Pose& pose) {
  RigidTransform out;
  for (int c = 0; c < 3; ++c) {
    const urdf::Vector3 column =
        pose.rotation * urdf::Vector3(c == 0 ? 1 : 0, c == 1 ? 1 : 0, c == 2 ? 1 : 0);
    out.rotation[c] = column.x;
    out.rotation[3 + c] = column.y;
    out.rotation[6 + c] = column.z;
  }
  out.translation[0] = pose.position.x;
  out.translation[1] = pose.position.y;
  out.translation[2] = pose.position.z;
  return out;
}

// package://moveit_resources_panda_description/meshes/...: robots/panda_description/meshes/...
std::string dataOf(const std::string& url) {
  const std::string package = "package://", of_moveit = package + "moveit_resources_";
  return "robots/" + url.substr((url.find(of_moveit) == 0 ? of_moveit : package).size());
}

// Returns a position within a joint's limits.
using JointPosition = std::function<double(const urdf::Joint&)>;

double atZero(const urdf::Joint& /*joint*/) { return 0; }

// Returns what a joint at a position adds to the place of its origin. Joints are revolute,
// continuous, prismatic or fixed.
RigidTransform motionOf(const urdf::Joint& joint, double position) {
  urdf::Pose motion;
  const urdf::Vector3& axis = joint.axis;
  if (joint.type == urdf::Joint::PRISMATIC) {
    motion.position = {axis.x * position, axis.y * position, axis.z * position};
  } else if (joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS) {
    const double s = std::sin(position / 2);
    motion.rotation = {axis.x * s, axis.y * s, axis.z * s, std::cos(position / 2)};
  }
  return toTransform(motion);
}

// Calls visit(link, pose of its collision mesh) for each link with one, parents first.
void visitMeshes(const urdf::LinkConstSharedPtr& link, const RigidTransform& pose,
                 const JointPosition& position,
                 const std::function<void(const urdf::Link&, const RigidTransform&)>& visit) {
  if (link->collision != nullptr && link->collision->geometry->type == urdf::Geometry::MESH) {
    visit(*link, composed(pose, toTransform(link->collision->origin)));
  }
  for (const auto& child : link->child_links) {
    const urdf::Joint& joint = *child->parent_joint;
    const RigidTransform origin =
        composed(pose, toTransform(joint.parent_to_joint_origin_transform));
    visitMeshes(child, composed(origin, motionOf(joint, position(joint))), position, visit);
  }
}

urdf::ModelInterfaceSharedPtr readRobot(const std::string& urdf_file) {
  std::ifstream file(testDataFile(urdf_file));
  std::stringstream text;
  text << file.rdbuf();
  return urdf::parseURDF(text.str());
}

// After body 0. Only meshes of the collision shapes are used.
void addRobot(const std::string& urdf_file, Scene* scene) {
  visitMeshes(readRobot(urdf_file)->getRoot(), RigidTransform(), atZero,
              [scene](const urdf::Link& link, const RigidTransform& pose) {
                const auto& mesh = static_cast<const urdf::Mesh&>(*link.collision->geometry);
                const BodyId id =
                    scene->addBody(link.name, readMeshFile(testDataFile(dataOf(mesh.filename))));
                scene->setPose(id, pose);
                scene->setPairEnabled(0, id, true);
              });
}

constexpr const char* kPanda = "robots/panda_description/urdf/panda.urdf";

}  // namespace

Scene pandaAndCloth(int squares) {
  Scene scene;
  scene.addBody("cloth", clothGrid(squares, 1.2F, 0.7F, 0.12F));
  addRobot(kPanda, &scene);
  RigidTransform pose;
  pose.translation[0] = pose.translation[1] = -0.6;
  scene.setPose(0, pose);
  return scene;
}

PandaStates pandaStates(std::size_t count, std::uint32_t seed) {
  const urdf::ModelInterfaceSharedPtr robot = readRobot(kPanda);
  std::mt19937 random(seed);
  const auto anywhere = [&random](const urdf::Joint& joint) {
    if (joint.limits == nullptr) return 0.0;
    const double part = random() * 0x1p-32;
    return joint.limits->lower + part * (joint.limits->upper - joint.limits->lower);
  };
  PandaStates states;
  for (std::size_t i = 0; i < count; ++i) {
    BodyId id = 0;
    visitMeshes(robot->getRoot(), RigidTransform(), anywhere,
                [&](const urdf::Link& /*link*/, const RigidTransform& pose) {
                  ++id;
                  if (i == 0) states.moved.push_back(id);
                  states.poses.push_back(pose);
                });
  }
  return states;
}

Scene movingPandaAndCloth() {
  Scene scene = pandaAndCloth();
  const double s = std::sin(-0.02), c = std::cos(-0.02);
  for (BodyId id = 1; id < scene.bodyCount(); ++id) {
    RigidTransform about_z;
    about_z.rotation[0] = about_z.rotation[4] = c;
    about_z.rotation[1] = -s;
    about_z.rotation[3] = s;
    scene.setEarlier(id, composed(about_z, scene.body(id).pose));
  }
  std::vector<float> vertices = scene.body(0).mesh.vertices;
  for (std::size_t i = 0; i < vertices.size(); i += 3) {
    vertices[i + 2] += 0.003F + 0.001F * std::sin(40 * (vertices[i] + vertices[i + 1]));
  }
  scene.setEarlier(0, scene.body(0).pose, vertices);
  return scene;
}

Scene pr2AndBlanket(float height_m) {
  Scene scene;
  scene.addBody("blanket", clothGrid(150, 1.4F, height_m, 0.06F));
  addRobot("bags/pr2.urdf", &scene);
  RigidTransform pose;
  pose.translation[0] = 0.2;
  pose.translation[1] = -0.7;
  scene.setPose(0, pose);
  return scene;
}

}  // namespace deformable_contact_monitor
