// Well-formed messages of meshes, of more or less sense, as bytes.
#pragma once

#include <ros/time.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <vector>

#include "byte_source.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The triangles between a cloud's points.
PointTriangles fuzzedFaces();

// A message of what an object of that type subscribes to.
std::vector<std::uint8_t> messageBytes(MeshType type, ByteSource* source, const ros::Time& stamp);

// The bytes of `message`, which is of what an object of that type subscribes to.
std::vector<std::uint8_t> bytesOf(MeshType type, const boost::shared_ptr<const void>& message);

}  // namespace deformable_contact_monitor
