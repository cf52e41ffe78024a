// Reads the points of a sensor_msgs/PointCloud2.
#include "monitor/input/cloud_points.h"

#include <sensor_msgs/PointField.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {
namespace {

using sensor_msgs::PointCloud2;
using sensor_msgs::PointField;

[[noreturn]] void rejectCloud(const std::string& why) { throw std::invalid_argument(why); }

// Products of two 32-bit fields cannot wrap in 64 bits.
void checkSizes(const PointCloud2& cloud) {
  if (cloud.is_bigendian != 0) rejectCloud("the cloud is big-endian");
  const std::uint64_t row_bytes = std::uint64_t{cloud.point_step} * cloud.width;
  if (row_bytes > cloud.row_step) {
    rejectCloud("row_step is " + std::to_string(cloud.row_step) + ", but a row has " +
                std::to_string(row_bytes) + " bytes");
  }
  const std::uint64_t bytes = std::uint64_t{cloud.row_step} * cloud.height;
  if (bytes != cloud.data.size()) {
    rejectCloud("data has " + std::to_string(cloud.data.size()) +
                " bytes, but row_step x height is " + std::to_string(bytes));
  }
}

}  // namespace

CloudPoints::CloudPoints(const PointCloud2& cloud) : cloud_(cloud), places_{} {
  checkSizes(cloud);
  constexpr const char* kNames[] = {"x", "y", "z"};
  for (std::size_t axis = 0; axis < 3; ++axis) places_[axis] = placeOf(kNames[axis]);
}

void CloudPoints::appendTo(std::vector<float>* vertices) const {
  if (cloud_.width == 0) return;  // then any number of rows may be claimed
  vertices->reserve(vertices->size() + 3 * std::size_t{cloud_.width} * cloud_.height);
  for (std::size_t row = 0; row < cloud_.height; ++row) {
    const std::uint8_t* point = cloud_.data.data() + row * cloud_.row_step;
    for (std::size_t i = 0; i < cloud_.width; ++i, point += cloud_.point_step) {
      for (const Place& place : places_) vertices->push_back(coordinateAt(point, place));
    }
  }
}

// Finds a coordinate's field by its name.
CloudPoints::Place CloudPoints::placeOf(const char* name) const {
  const std::string shown = "'" + std::string(name) + "'";
  const PointField* found = nullptr;
  for (const PointField& field : cloud_.fields) {
    if (field.name != name) continue;
    if (found != nullptr) rejectCloud("the cloud has two fields " + shown);
    found = &field;
  }
  if (found == nullptr) rejectCloud("the cloud has no field " + shown);
  const bool is_double = found->datatype == PointField::FLOAT64;
  if (!is_double && found->datatype != PointField::FLOAT32) {
    rejectCloud("field " + shown + " has datatype " + std::to_string(found->datatype) +
                ", neither FLOAT32 (7) nor FLOAT64 (8)");
  }
  if (found->count > 1) {  // some publishers leave it 0
    rejectCloud("field " + shown + " has count " + std::to_string(found->count) + ", not 1");
  }
  const std::uint64_t end =
      std::uint64_t{found->offset} + (is_double ? sizeof(double) : sizeof(float));
  if (end > cloud_.point_step) {
    rejectCloud("field " + shown + " ends at byte " + std::to_string(end) + ", but point_step is " +
                std::to_string(cloud_.point_step));
  }
  return {found->offset, is_double};
}

// Reads a coordinate; it may lie at any address, so the bytes are copied.
float CloudPoints::coordinateAt(const std::uint8_t* point, const Place& place) {
  if (place.is_double) {
    double value = 0;
    std::memcpy(&value, point + place.offset, sizeof value);
    return static_cast<float>(value);
  }
  float value = 0;
  std::memcpy(&value, point + place.offset, sizeof value);
  return value;
}

}  // namespace deformable_contact_monitor
