// Checks the bytes and the size of messages that carry a mesh, before roscpp reads them.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <geometry_msgs/PoseArray.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "monitor/input/optional_messages.h"

namespace deformable_contact_monitor {

// Returns why `size` bytes are not exactly one serialized M of at most `max_bytes`; empty: they
// are. Allocates nothing for what the message claims to hold. M is one of the types that
// byteCount() takes. Any thread.
template <typename M>
std::string validateMeshBytes(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes);

// Returns why a mesh of that many bytes is too large; empty: it is not.
std::string meshSizeProblem(std::uint64_t bytes, std::size_t max_bytes);

// Returns the bytes of a message's arrays and strings. They count against the limit where a message
// comes from the same process, and so was never serialized.
std::uint64_t byteCount(const DeformableMesh& message);
std::uint64_t byteCount(const shape_msgs::Mesh& message);
std::uint64_t byteCount(const visualization_msgs::Marker& message);
std::uint64_t byteCount(const visualization_msgs::MarkerArray& message);
std::uint64_t byteCount(const sensor_msgs::PointCloud2& message);
std::uint64_t byteCount(const geometry_msgs::PoseArray& message);
#ifdef DCM_HAS_NAV_MSGS
std::uint64_t byteCount(const nav_msgs::Path& message);
#endif
#ifdef DCM_HAS_PCL_MSGS
std::uint64_t byteCount(const pcl_msgs::PolygonMesh& message);
#endif

// Returns the stamp of the header that the bytes begin with; zero if they are too few.
ros::Time stampIn(const std::uint8_t* bytes, std::size_t size);

}  // namespace deformable_contact_monitor
