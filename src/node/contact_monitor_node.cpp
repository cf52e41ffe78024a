// The monitor as a node of its own.
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <thread>

#include "node/contact_monitor.h"
#include "robot/link_mesh_file.h"

namespace {

std::atomic<int> exit_code{0};

// Ctrl-C ends the node within a second, also where the ROS master does not answer, which roscpp
// waits for, or a robot of millions of triangles is being prepared. The node writes no files, so
// nothing is lost.
void endSoonAfterShutdown() {
  constexpr std::chrono::milliseconds kPatience(600), kPeriod(20);
  std::thread([=] {
    while (!ros::isShuttingDown()) std::this_thread::sleep_for(kPeriod);
    std::this_thread::sleep_for(kPatience);
    std::_Exit(exit_code);
  }).detach();
}

}  // namespace

int main(int argc, char** argv) {
  ros::init(argc, argv, "contact_monitor");
  const ros::NodeHandle node, private_node("~");  // outlive the try: without one, ROS logs nothing
  endSoonAfterShutdown();
  try {
    deformable_contact_monitor::ContactMonitor monitor(node, private_node);
    while (ros::ok() && !monitor.isForgotten()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
    }
    if (monitor.isForgotten()) {
      exit_code = 1;
      ROS_FATAL("ends, for the ROS master does not know it any more; respawn starts it again");
    }
  } catch (const deformable_contact_monitor::ReadingStopped&) {
    return 0;  // Ctrl-C while the robot was read
  } catch (const std::exception& error) {
    exit_code = 1;
    ROS_FATAL_STREAM(error.what());
  }
  return exit_code;
}
