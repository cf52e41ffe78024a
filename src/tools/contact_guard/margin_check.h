// Whether the monitor's margins let the guard see what it is to slow for.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <string>

#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {

// Distances are known within a pair's margin alone. A text that names a pair of `states` whose
// margin is below slow_distance_m, and how many there are; empty: none. `monitor`: the monitor's
// private namespace as the parameter server hands it out.
std::string tooSmallMargins(const XmlRpc::XmlRpcValue& monitor, const ContactStates& states,
                            const GuardParameters& parameters);

}  // namespace deformable_contact_monitor
