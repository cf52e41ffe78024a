// Checks that the monitor's margins are large enough for the guard's slow_distance_m.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

// Returns a warning that names a pair of `states` whose margin is below slow_distance_m, and how
// many such pairs there are; empty: none. The monitor knows distances only within a pair's margin,
// so the guard would not slow for such a pair in time. `monitor` is the monitor's private namespace
// as the parameter server returns it.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters);

}  // namespace deformable_contact_monitor
