// Subscriptions to meshes that look at a message's bytes before they make a mesh of them.
#pragma once

#include <ros/subscribe_options.h>

#include <cstddef>
#include <functional>
#include <string>

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

using MeshReceiver = std::function<void(const ReceivedMesh& mesh)>;

// The message type that an object of this type subscribes to, "package/Name".
const char* messageType(MeshType type);

// Subscribes `receive`, which keeps the newest message waiting. DeformableMesh messages of
// publishers in the same process come without a copy; what other types become is written once, in
// the thread that calls back: the detection thread has work enough. What roscpp does before, nobody
// can bound from here: it reads a message of up to 1 GB from the wire before anyone sees it, and
// takes memory as bytes arrive. `expect` is called ahead of that, when a message's bytes are there.
ros::SubscribeOptions meshSubscription(
    const std::string& topic, const ObjectParameters& object, std::size_t max_bytes,
    const MeshReceiver& receive, const std::function<void()>& expect = [] {});

}  // namespace deformable_contact_monitor
