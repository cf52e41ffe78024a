// Conversions between what the monitor computes and its messages. Pure functions.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <ros/time.h>

#include <cstddef>
#include <cstdint>

#include "monitor/cycle_report.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Of one message on the wire. roscpp's lengths have 32 bits, and its subscribers take more than
// 10^9 for a broken connection; some of that is left to what a service's reply adds.
constexpr std::uint64_t kMostMessageBytes = 900000000;

// How many pairs, of `pair_bytes` each, have room in a message of `most_bytes` whose other fields
// take `other_bytes`.
std::size_t mostPairs(std::uint64_t most_bytes, std::uint64_t other_bytes,
                      std::uint64_t pair_bytes);

// The report as a message. Keeps the first pairs of the sorted list, as many as have room in
// `most_bytes`, and no more than `max_contacts` if that is not 0; if some are missing, `truncated`
// is set. pair_count stays exact. Counts that have 32 bits stop there. `complete` is true iff the
// settings are complete by proof and nothing was skipped, rejected or truncated; without a
// detection it is false and there are no pairs. `skipped` holds "<body>: <reason>" for each unknown
// body, in body order. `geometry` has one for each pair if hasGeometry(). compute_time is the
// detection's time from host to host.
ContactArray toContactArray(const CycleReport& report, std::size_t max_contacts,
                            std::uint64_t most_bytes = kMostMessageBytes);

// Of 64 bits; counts of messages that have 32 stop there.
std::uint32_t saturated(std::uint64_t count);
ContactPair toContactPair(const TrianglePair& pair);

// The robot's link meshes as a message, in order. A link with a problem goes out without triangles,
// and `source` says why.
LinkMeshes toLinkMeshes(const RobotGeometry& geometry, const ros::Time& stamp);

// The inverse. A malformed or empty mesh, and a link that was sent before in the same message,
// costs only that link: its place is kept, with `problem` set and no mesh. The robot's name is
// empty.
RobotGeometry fromLinkMeshes(const LinkMeshes& message);

}  // namespace deformable_contact_monitor
