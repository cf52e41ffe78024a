// Point clouds as meshes.
#include <sensor_msgs/PointField.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <stdexcept>

#include "monitor/input/mesh_adapters.h"

namespace deformable_contact_monitor {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

// One coordinate of a point.
struct Place {
  std::size_t offset;  // [bytes] from the point's first
  bool is_double;
};

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

Place placeOf(const std::string& name, const PointCloud2& cloud) {
  const PointField* found = nullptr;
  for (const PointField& field : cloud.fields) {
    if (field.name != name) continue;
    if (found != nullptr) refuse("the cloud has two fields '" + name + "'");
    found = &field;
  }
  if (found == nullptr) refuse("the cloud has no field '" + name + "'");
  const bool is_double = found->datatype == PointField::FLOAT64;
  if (!is_double && found->datatype != PointField::FLOAT32) {
    refuse("field '" + name + "' has datatype " + std::to_string(found->datatype) +
           ", neither FLOAT32 (7) nor FLOAT64 (8)");
  }
  if (found->count > 1) {  // some publishers leave it 0
    refuse("field '" + name + "' has count " + std::to_string(found->count) + ", not 1");
  }
  const std::uint64_t end =
      std::uint64_t{found->offset} + (is_double ? sizeof(double) : sizeof(float));
  if (end > cloud.point_step) {
    refuse("field '" + name + "' ends at byte " + std::to_string(end) + ", but point_step is " +
           std::to_string(cloud.point_step));
  }
  return {found->offset, is_double};
}

// That all points lie within the data, and are as many as vertices.
void checkLayout(const PointCloud2& cloud, std::size_t vertex_count) {
  if (cloud.is_bigendian != 0) refuse("the cloud is big-endian");
  const std::uint64_t points = std::uint64_t{cloud.width} * cloud.height;
  if (points != vertex_count) {
    refuse("the cloud has " + std::to_string(cloud.width) + " x " + std::to_string(cloud.height) +
           " points, but its faces are of " + std::to_string(vertex_count) + " vertices");
  }
  const std::uint64_t row_bytes = std::uint64_t{cloud.point_step} * cloud.width;
  if (row_bytes > cloud.row_step) {
    refuse("row_step is " + std::to_string(cloud.row_step) + ", but a row has " +
           std::to_string(row_bytes) + " bytes");
  }
  const std::uint64_t bytes = std::uint64_t{cloud.row_step} * cloud.height;
  if (bytes != cloud.data.size()) {
    refuse("data has " + std::to_string(cloud.data.size()) + " bytes, but row_step x height is " +
           std::to_string(bytes));
  }
}

float coordinateAt(const std::uint8_t* point, const Place& place) {
  if (place.is_double) {
    double value = 0;
    std::memcpy(&value, point + place.offset, sizeof value);
    return static_cast<float>(value);
  }
  float value = 0;
  std::memcpy(&value, point + place.offset, sizeof value);
  return value;
}

}  // namespace

ReceivedMesh PointCloudAdapter::adapt(const Message& message, const ros::Time& /*received*/) {
  checkLayout(message, faces_->vertexCount());
  const Place places[] = {placeOf("x", message), placeOf("y", message), placeOf("z", message)};
  const auto mesh = boost::make_shared<DeformableMesh>();
  mesh->header = message.header;
  mesh->topology_id = 1;
  mesh->vertices.reserve(3 * faces_->vertexCount());
  for (std::size_t row = 0; row < message.height; ++row) {
    const std::uint8_t* point = message.data.data() + row * message.row_step;
    for (std::size_t i = 0; i < message.width; ++i, point += message.point_step) {
      for (const Place& place : places) mesh->vertices.push_back(coordinateAt(point, place));
    }
  }
  if (!has_sent_triangles_) mesh->triangles = faces_->triangles;
  has_sent_triangles_ = true;
  return {mesh};
}

}  // namespace deformable_contact_monitor
