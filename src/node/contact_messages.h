// Conversions between what the monitor computes and its messages. Pure functions.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <ros/time.h>

#include <cstddef>

#include "node/cycle_report.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// The report as a message. `max_contacts` > 0 keeps the first so many pairs of the sorted list and
// sets `truncated`; pair_count stays exact. `complete` is true iff the settings are complete by
// proof and nothing was skipped, rejected or truncated; without a detection it is false and
// there are no pairs. `skipped` holds "<body>: <reason>" for each unknown body, in body order.
// `geometry` stays empty. compute_time is the detection's time from host to host.
ContactArray toContactArray(const CycleReport& report, std::size_t max_contacts);

// The robot's link meshes as a message, in order. A link with a problem goes out without triangles,
// and `source` says why.
LinkMeshes toLinkMeshes(const RobotGeometry& geometry, const ros::Time& stamp);

// The inverse. A malformed or empty mesh, and a link that was sent before in the same message,
// costs only that link: its place is kept, with `problem` set and no mesh. The robot's name is
// empty.
RobotGeometry fromLinkMeshes(const LinkMeshes& message);

}  // namespace deformable_contact_monitor
