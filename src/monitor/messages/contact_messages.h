// Converts what the monitor computes to messages, and link meshes back. All functions are pure.
//
// A cycle becomes one ContactArray, one SweptContacts per time interval (motion: swept) and one
// ContactPatches. The first two keep the first pairs of the sorted list, as many as fit into
// `most_bytes`, and at most `max_contacts` if that is not 0; if pairs are missing, `truncated` is
// set. pair_count stays exact. Counts with 32 bits stop at their largest value.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/ContactPatches.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <deformable_contact_monitor/SweptContacts.h>
#include <geometry_msgs/Point32.h>
#include <ros/time.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/analysis/contact_patches.h"
#include "monitor/cycle_report.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Bounds the size of one message [bytes]. roscpp stores lengths in 32 bits, and its subscribers
// take a length above 10^9 for a broken connection. The rest is left to what the reply of
// ~get_contacts adds.
constexpr std::uint64_t kMostMessageBytes = 900000000;

// Returns how many pairs of `pair_bytes` each fit into a message of `most_bytes` whose other fields
// take `other_bytes`.
std::size_t mostPairs(std::uint64_t most_bytes, std::uint64_t other_bytes,
                      std::uint64_t pair_bytes);

// Converts a cycle's contacts at its stamp. `complete` is true iff the settings are complete by
// proof and nothing was skipped, rejected or truncated; without a detection it is false and there
// are no pairs. `skipped` holds "<body>: <reason>" for each unknown body, in body order. `geometry`
// has one entry per pair if hasGeometry(), `nearest` one per nearest pair of the result.
// compute_time is the detection's time from host to host.
ContactArray toContactArray(const CycleReport& report, std::size_t max_contacts,
                            std::uint64_t most_bytes = kMostMessageBytes);

// Converts one of the report's sweeps. `complete` has the same meaning as in ContactArray. Without
// a time interval, or if its detection failed, there are no pairs and `skipped` says why.
SweptContacts toSweptContacts(const CycleReport& report, const SweepReport& sweep,
                              std::size_t max_contacts,
                              std::uint64_t most_bytes = kMostMessageBytes);

// Converts the patches of the report's scene, in their order.
ContactPatches toContactPatches(const CycleReport& report, const std::vector<Patch>& patches);

// Converts the robot's link meshes, in order. A link with a problem is sent without triangles, and
// `source` says why.
LinkMeshes toLinkMeshes(const RobotGeometry& geometry, const ros::Time& stamp);

// Converts link meshes back. A malformed or empty mesh, and a link that occurs twice, keeps its
// place, has its `problem` set and has no mesh. The robot's name is empty.
RobotGeometry fromLinkMeshes(const LinkMeshes& message);

// Returns the count, or the largest 32-bit value if the count is larger.
std::uint32_t saturated(std::uint64_t count);

// Converts a Vec3f, or a Vec3d, which is rounded.
template <class Vector>
geometry_msgs::Point32 toPoint32(const Vector& v) {
  geometry_msgs::Point32 point;
  point.x = static_cast<float>(v.x);
  point.y = static_cast<float>(v.y);
  point.z = static_cast<float>(v.z);
  return point;
}

}  // namespace deformable_contact_monitor
