// Whether the bytes of a message are one, looked at before memory is taken for what they claim.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <sensor_msgs/PointCloud2.h>
#include <shape_msgs/Mesh.h>
#include <visualization_msgs/Marker.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace deformable_contact_monitor {

// Why `size` bytes are not one whole M of at most `max_bytes`; empty: they are. M is one of the
// types that byteCount() takes.
//
// roscpp reserves what an array claims to hold before it looks whether that was sent: 5 KB cost it
// 16 GB.
template <typename M>
std::string whyNoMesh(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes);

std::string whyTooLarge(std::uint64_t bytes, std::size_t max_bytes);

// What counts of a message against the limit: its arrays.
std::uint64_t byteCount(const DeformableMesh& message);
std::uint64_t byteCount(const shape_msgs::Mesh& message);
std::uint64_t byteCount(const visualization_msgs::Marker& message);
std::uint64_t byteCount(const sensor_msgs::PointCloud2& message);

// The stamp of a header that the bytes begin with; zero if they do not hold one.
ros::Time stampIn(const std::uint8_t* bytes, std::size_t size);

}  // namespace deformable_contact_monitor
