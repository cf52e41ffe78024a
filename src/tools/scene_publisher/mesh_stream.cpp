// Publishes the states of one deforming object. Most messages hold only vertices: triangles rarely
// change, and would make up about two thirds of a message.
#include "tools/scene_publisher/mesh_stream.h"

#include <deformable_contact_monitor/DeformableMesh.h>

#include <utility>

namespace deformable_contact_monitor {

MeshStream::MeshStream(ros::NodeHandle* node, const std::string& topic, std::string object,
                       std::string frame_id, ros::Duration period)
    : publisher_(node->advertise<DeformableMesh>(topic, 1)),
      object_(std::move(object)),
      frame_id_(std::move(frame_id)),
      period_(period) {}

void MeshStream::publish(const MeshFrame& frame, const ros::Time& stamp) {
  DeformableMesh message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_id_;
  message.object = object_;
  message.topology_id = frame.topology_id;
  message.vertices = frame.mesh.vertices;
  // Triangles are due if the next message would be too late for them, or if the clock went back.
  const bool due = triangles_sent_.isZero() || stamp < triangles_sent_ ||
                   stamp + period_ > triangles_sent_ + ros::Duration(1);
  if (due || frame.topology_id != topology_id_) {
    message.triangles = frame.mesh.triangles;
    triangles_sent_ = stamp;
    topology_id_ = frame.topology_id;
  }
  publisher_.publish(message);
}

}  // namespace deformable_contact_monitor
