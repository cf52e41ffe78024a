// Where a scene goes: to topics, or into a bag.
#pragma once

#include <ros/node_handle.h>
#include <rosbag/bag.h>
#include <sensor_msgs/JointState.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "tools/common/output_file.h"
#include "tools/simulation/scene_object.h"

namespace deformable_contact_monitor {

// Publishes the states of the object and the joints, or writes them to a bag.
//
// Sends triangles with the first message, whenever topology_id changes, and at least once a second
// of stamps, so that a late subscriber, or one that lost a message, does not wait long. Most
// messages hold only vertices: triangles would make up about two thirds of a message. A rope is a
// visualization_msgs/Marker, a line strip whose width is the rope's.
class SceneOutput {
 public:
  // Writes to the bag if its path is not empty, and else publishes. The bag begins with
  // `robot_xml`, unless that is empty, at the time `begin`. All functions throw
  // rosbag::BagException, or std::system_error that names the bag, if it cannot be written.
  SceneOutput(const SceneObject& object, const std::string& topic, const std::string& frame,
              ros::NodeHandle* node, const std::string& bag_path, const std::string& robot_xml,
              const ros::Time& begin);

  // Sends one state of the object. Vertices are in metres, in `frame`.
  void send(const MeshFrame& frame, const ros::Time& stamp);
  void send(sensor_msgs::JointState joints, const ros::Time& stamp);

  // Completes the bag, which has its name only from then on. Call it after the last message.
  void finish();

 private:
  // A bag's destructor writes, and ends the program if it cannot. So a bag is closed before, and
  // one that cannot be closed is not destroyed.
  struct CloseBag {
    void operator()(rosbag::Bag* bag) const noexcept;
  };

  template <class Message>
  void sendTo(const std::string& topic, const Message& message, const ros::Time& stamp);

  const SceneObject& object_;
  const std::string topic_, frame_;
  ros::NodeHandle* node_;
  std::map<std::string, ros::Publisher> publishers_;  // by topic
  std::optional<AtomicFile> file_;                    // the bag's
  std::unique_ptr<rosbag::Bag, CloseBag> bag_;        // null: messages are published
  ros::Duration period_;                              // the expected time between two messages
  std::uint32_t subscribers_ = 0;  // of the object's topic, at the latest message
  ros::Time triangles_sent_;       // stamp of the latest message with triangles; zero: none yet
  std::uint32_t topology_id_ = 0;
};

}  // namespace deformable_contact_monitor
