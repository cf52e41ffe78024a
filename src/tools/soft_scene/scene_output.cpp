// Where a scene goes: to topics, or into a bag.
#include "tools/soft_scene/scene_output.h"

#include <deformable_contact_monitor/DeformableMesh.h>
#include <std_msgs/String.h>
#include <visualization_msgs/Marker.h>

#include <utility>

namespace deformable_contact_monitor {
namespace {

// Returns the line through the vertices, in their order.
visualization_msgs::Marker ropeMarker(const MeshFrame& frame, const SceneObject& object) {
  visualization_msgs::Marker marker;
  marker.ns = object.name;
  marker.type = visualization_msgs::Marker::LINE_STRIP;
  marker.pose.orientation.w = 1;
  marker.scale.x = 2 * object.radius_m;
  marker.color.r = 0.9F;
  marker.color.g = 0.8F;
  marker.color.b = 0.5F;
  marker.color.a = 1;
  for (std::size_t i = 0; i < frame.mesh.vertexCount(); ++i) {
    const Vec3f p = frame.mesh.vertex(i);
    geometry_msgs::Point point;
    point.x = p.x;
    point.y = p.y;
    point.z = p.z;
    marker.points.push_back(point);
  }
  return marker;
}

}  // namespace

template <class Message>
void SceneOutput::sendTo(const std::string& topic, const Message& message, const ros::Time& stamp) {
  if (bag_) {
    bag_->write(topic.front() == '/' ? topic : "/" + topic, stamp, message);
    return;
  }
  ros::Publisher& publisher = publishers_[topic];
  if (!publisher) publisher = node_->advertise<Message>(topic, 10);
  publisher.publish(message);
}

SceneOutput::SceneOutput(const SceneObject& object, const std::string& topic,
                         const std::string& frame, ros::NodeHandle* node,
                         const std::string& bag_path, const std::string& robot_xml,
                         const ros::Time& begin)
    : object_(object), topic_(topic), frame_(frame), node_(node), period_(1 / object.rate_hz) {
  if (bag_path.empty()) {
    if (object.isRope()) {
      publishers_[topic] = node->advertise<visualization_msgs::Marker>(topic, 1);
    } else if (object.isWanted()) {
      publishers_[topic] = node->advertise<DeformableMesh>(topic, 1);
    }
    return;
  }
  file_.emplace(bag_path);
  bag_.reset(new rosbag::Bag(file_->writtenAs(), rosbag::bagmode::Write));
  bag_->setCompression(rosbag::compression::BZ2);
  if (robot_xml.empty()) return;
  std_msgs::String description;
  description.data = robot_xml;
  sendTo("robot_description", description, begin);
}

void SceneOutput::CloseBag::operator()(rosbag::Bag* bag) const noexcept {
  try {
    bag->close();
  } catch (...) {
    return;
  }
  delete bag;
}

void SceneOutput::finish() {
  if (!bag_) return;
  bag_->close();
  file_->finish();
}

void SceneOutput::send(const MeshFrame& frame, const ros::Time& stamp) {
  if (object_.isRope()) {
    visualization_msgs::Marker marker = ropeMarker(frame, object_);
    marker.header.stamp = stamp;
    marker.header.frame_id = frame_;
    sendTo(topic_, marker, stamp);
    return;
  }
  DeformableMesh message;
  message.header.stamp = stamp;
  message.header.frame_id = frame_;
  message.object = object_.name;
  message.topology_id = frame.topology_id;
  message.vertices = frame.mesh.vertices;
  // Triangles are due for a new subscriber, if the next message would be too late for them, or if
  // the clock went back.
  const auto subscribers = bag_ ? 0 : publishers_[topic_].getNumSubscribers();
  const bool is_new = subscribers > std::exchange(subscribers_, subscribers);
  const bool due = is_new || triangles_sent_.isZero() || stamp < triangles_sent_ ||
                   stamp + period_ > triangles_sent_ + ros::Duration(1);
  if (due || frame.topology_id != topology_id_) {
    message.triangles = frame.mesh.triangles;
    triangles_sent_ = stamp;
    topology_id_ = frame.topology_id;
  }
  sendTo(topic_, message, stamp);
}

void SceneOutput::send(sensor_msgs::JointState joints, const ros::Time& stamp) {
  joints.header.stamp = stamp;
  sendTo("joint_states", joints, stamp);
}

}  // namespace deformable_contact_monitor
