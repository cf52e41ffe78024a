// Subscriptions to meshes, with a check of each message's bytes before roscpp reads them.
#pragma once

#include <ros/subscribe_options.h>

#include <cstddef>
#include <functional>
#include <string>

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Takes each mesh that arrives, valid or not, in the thread that calls back.
using MeshReceiver = std::function<void(const IncomingMesh& mesh)>;

// Returns the message type that an object of this type subscribes to, as "package/Name".
const char* messageType(MeshType type);

// Returns options that subscribe `receive` to an object's topic. A message larger than `max_bytes`
// is handed over as an invalid mesh, and so is one that is damaged.
//
// The queue keeps the newest message only. DeformableMesh messages of publishers in the same
// process come without a copy. Other types are converted in the thread that calls back, as the
// detection thread has enough work. What roscpp does before is out of reach: it accepts a message
// of up to 1 GB from the wire before anyone can check it, but it takes memory only as the bytes
// arrive.
ros::SubscribeOptions meshSubscription(const std::string& topic, const ObjectParameters& object,
                                       std::size_t max_bytes, const MeshReceiver& receive);

}  // namespace deformable_contact_monitor
