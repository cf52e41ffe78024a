// An adapter that converts pcl_msgs/PolygonMesh to DeformableMesh, if pcl_msgs is there.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "monitor/input/incoming_mesh.h"
#include "monitor/input/optional_messages.h"

#ifdef DCM_HAS_PCL_MSGS

namespace deformable_contact_monitor {

// Works as mesh_adapters.h says. The points of the cloud are the vertices, and a polygon (p0, p1,
// p2, ...) becomes the triangles (p0, p1, p2), (p0, p2, p3), ... Stamp and frame are those of the
// message's own header, not of its cloud.
class PolygonMeshAdapter {
 public:
  using Message = pcl_msgs::PolygonMesh;

  IncomingMesh adapt(const Message& message, const ros::Time& received);

 private:
  std::vector<std::uint32_t> triangles_;  // of the last mesh
  std::size_t coordinate_count_ = 0;      // of the last mesh
  std::uint32_t topology_id_ = 0;
};

}  // namespace deformable_contact_monitor

#endif
