// Makes the load: links in a square array, and a deforming mesh through each of them.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <tf2_msgs/TFMessage.h>

#include <cstddef>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"

namespace deformable_contact_monitor {

constexpr char kLoadFrame[] = "base";

// Names of the n-th, as `run` writes them into URDF and parameters. Topics are "/" + objectName(n).
std::string linkName(std::size_t n);
std::string objectName(std::size_t n);

// Poses of the first `count` links, stamped with `stamp`: they go up and down as time goes by.
tf2_msgs::TFMessage linkTransforms(std::size_t count, const ros::Time& stamp);

// One object as messages, made once.
class LoadObject {
 public:
  // Its place is that of link number `n`; the mesh has a corner at the origin.
  LoadObject(std::size_t n, const TriangleMesh& mesh);

  // The next state of its motion, with triangles in the first `keyframe_period` messages, of which
  // some may be lost while connections are made, and in one of as many later on.
  const DeformableMesh& next(const ros::Time& stamp, std::size_t keyframe_period);

 private:
  std::vector<DeformableMesh> states_;
  std::vector<std::uint32_t> triangles_;
  std::size_t sent_ = 0;
};

}  // namespace deformable_contact_monitor
