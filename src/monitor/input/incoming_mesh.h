// One mesh of a deformable object on its way into the scene.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <boost/shared_ptr.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/steady_time.h"

namespace deformable_contact_monitor {

// Triangles that several meshes share. Two meshes have the same triangles iff they point to the
// same Topology.
struct Topology {
  std::uint32_t id = 0;  // topology_id of the messages
  std::size_t vertex_count = 0;
  std::vector<std::uint32_t> triangles;  // three vertex indices each, all below vertex_count
};

// Made by an adapter, stored and accepted by MeshInput, queued by CycleScheduler, and loaded into
// the scene by MonitorScene. The vertices are shared, never copied, until the scene reads them.
struct IncomingMesh {
  // If it is invalid, only its stamp may be used. Null: the original message, an array, says
  // nothing about the object; then nobody stores this.
  DeformableMesh::ConstPtr message;
  std::string problem{};                       // why it is invalid or rejected; empty: it is valid
  bool stamped_on_receipt = false;             // the original message had no stamp of its own
  SteadyTime arrival{};                        // when roscpp received the original message
  std::shared_ptr<const Topology> topology{};  // set on acceptance; fits the message's vertices
  std::string publisher{};                     // name of the node; empty: not known
  bool is_deletion = false;  // invalid because the object was deleted; a new mesh may follow soon
  ros::Time corrected{};     // the stamp by stamp_offset_s; zero: that of the message holds
  // Identifies the publisher's connection by its address. A publisher that starts anew has another
  // one, even under the same name. Null: an adapter gives the triangles, or it is not known.
  boost::shared_ptr<const void> connection{};

  const ros::Time& stamp() const { return corrected.isZero() ? message->header.stamp : corrected; }
};

}  // namespace deformable_contact_monitor
