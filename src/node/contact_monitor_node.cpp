// The monitor as a node of its own.
#include <ros/ros.h>

#include <exception>

#include "node/contact_monitor.h"
#include "robot/link_mesh_file.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "contact_monitor");
  const ros::NodeHandle node, private_node("~");  // outlive the try: without one, ROS logs nothing
  try {
    deformable_contact_monitor::ContactMonitor monitor(node, private_node);
    ros::spin();
  } catch (const deformable_contact_monitor::ReadingStopped&) {
    return 0;  // Ctrl-C while the robot was read
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}
