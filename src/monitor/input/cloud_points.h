// The points of a sensor_msgs/PointCloud2, whatever the layout of its bytes.
#pragma once

#include <sensor_msgs/PointCloud2.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace deformable_contact_monitor {

// Reads the fields x, y and z, which may be float32 or float64 and lie anywhere within a point.
class CloudPoints {
 public:
  // Checks that all points lie within the cloud's data; throws std::invalid_argument, with the
  // reason, if not. Sizes are multiplied in 64 bits. The cloud must outlive this.
  explicit CloudPoints(const sensor_msgs::PointCloud2& cloud);

  // Appends x y z of each point, row by row, as the nearest float32.
  void appendTo(std::vector<float>* vertices) const;

 private:
  // The place of one coordinate within a point.
  struct Place {
    std::size_t offset;  // [bytes] from the point's first byte
    bool is_double;
  };

  Place placeOf(const char* name) const;
  static float coordinateAt(const std::uint8_t* point, const Place& place);

  const sensor_msgs::PointCloud2& cloud_;
  Place places_[3];
};

}  // namespace deformable_contact_monitor
