// The monitor as a node of its own.
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <exception>

#include "node/contact_monitor.h"
#include "robot/link_mesh_file.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "contact_monitor");
  const ros::NodeHandle node, private_node("~");  // outlive the try: without one, ROS logs nothing
  try {
    deformable_contact_monitor::ContactMonitor monitor(node, private_node);
    while (ros::ok() && !monitor.isForgotten()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
    }
    if (monitor.isForgotten()) {
      ROS_FATAL("ends, for the ROS master does not know it any more; respawn starts it again");
      return 1;
    }
  } catch (const deformable_contact_monitor::ReadingStopped&) {
    return 0;  // Ctrl-C while the robot was read
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
