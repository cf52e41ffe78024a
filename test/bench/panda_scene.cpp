#include "panda_scene.h"

#include <urdf_parser/urdf_parser.h>

#include <fstream>
#include <sstream>
#include <string>

#include "core/mesh_files/mesh_file.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// parent_from_child = a b.
RigidTransform composed(const RigidTransform& a, const urdf::Pose& b) {
  RigidTransform out;
  const auto column = [&](int c) {
    const urdf::Vector3 turned =
        b.rotation * urdf::Vector3(c == 0 ? 1 : 0, c == 1 ? 1 : 0, c == 2 ? 1 : 0);
    for (int r = 0; r < 3; ++r) {
      out.rotation[3 * r + c] = a.rotation[3 * r] * turned.x + a.rotation[3 * r + 1] * turned.y +
                                a.rotation[3 * r + 2] * turned.z;
    }
  };
  for (int c = 0; c < 3; ++c) column(c);
  for (int r = 0; r < 3; ++r) {
    out.translation[r] = a.rotation[3 * r] * b.position.x + a.rotation[3 * r + 1] * b.position.y +
                         a.rotation[3 * r + 2] * b.position.z + a.translation[r];
  }
  return out;
}

void addLink(const urdf::LinkConstSharedPtr& link, const RigidTransform& pose, Scene* scene) {
  if (link->collision != nullptr && link->collision->geometry->type == urdf::Geometry::MESH) {
    const auto& mesh = static_cast<const urdf::Mesh&>(*link->collision->geometry);
    const std::string file = mesh.filename.substr(mesh.filename.rfind('/') + 1);
    const BodyId id = scene->addBody(
        link->name,
        readMeshFile(testDataFile("robots/panda_description/meshes/collision/" + file)));
    scene->setPose(id, composed(pose, link->collision->origin));
    scene->setPairEnabled(0, id, true);
  }
  for (const auto& child : link->child_links) {
    addLink(child, composed(pose, child->parent_joint->parent_to_joint_origin_transform), scene);
  }
}

}  // namespace

Scene pandaAndCloth() {
  std::ifstream file(testDataFile("robots/panda_description/urdf/panda.urdf"));
  std::stringstream text;
  text << file.rdbuf();
  const auto model = urdf::parseURDF(text.str());
  Scene scene;
  scene.addBody("cloth", clothGrid(87, 1.2F, 0.7F, 0.12F));
  addLink(model->getRoot(), RigidTransform(), &scene);
  RigidTransform pose;
  pose.translation[0] = pose.translation[1] = -0.6;
  scene.setPose(0, pose);
  return scene;
}

}  // namespace deformable_contact_monitor
