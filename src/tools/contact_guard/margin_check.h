// Checks that the monitor's margins are large enough for the guard's distances.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

// Returns a warning that names a pair of `states` whose margin is below the distance up to which
// the guard must see it, and how many such pairs there are; empty: none. That distance is the
// greatest of slow_distance_m, warn_distance_m, and with time_to_contact_s the way of the fastest
// approach. The monitor knows distances only within a pair's margin, so the guard would act too
// late. `monitor` is the monitor's private namespace as the parameter server returns it.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters);

}  // namespace deformable_contact_monitor
