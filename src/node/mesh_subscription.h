// Subscriptions to meshes that look at a message's bytes before they make a mesh of them.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/subscribe_options.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace deformable_contact_monitor {

// `refusal`: why it is no mesh, and then `message` has its stamp alone; empty: it is one.
using MeshReceiver =
    std::function<void(const DeformableMesh::ConstPtr& message, const std::string& refusal)>;

// Why `size` bytes are no DeformableMesh of at most `max_bytes`; empty: they are one.
//
// roscpp reserves what an array claims to hold before it looks whether that was sent: 5 KB cost it
// 16 GB.
std::string whyNoMesh(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes);

// Subscribes `receive`, which keeps the newest message waiting. Messages of publishers in the same
// process come without a copy. What roscpp does before, nobody can bound from here: it reads a
// message of up to 1 GB from the wire before anyone sees it, and takes memory as bytes arrive.
ros::SubscribeOptions meshSubscription(const std::string& topic, std::size_t max_bytes,
                                       const MeshReceiver& receive);

}  // namespace deformable_contact_monitor
