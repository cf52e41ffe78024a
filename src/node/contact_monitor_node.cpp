// Runs the monitor as a node of its own. Exit code: 0 after a shutdown, 1 if it could not start or
// is no longer registered with the ROS master.
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <thread>

#include "node/contact_monitor.h"
#include "robot/link_mesh_files.h"

namespace {

std::atomic<int> exit_code{0};

// Ends the process within a second of Ctrl-C. Otherwise a shutdown waits for a ROS master that does
// not answer, or until a robot of millions of triangles is prepared. The node writes no files, so
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
  const ros::NodeHandle node, private_node("~");  // outlive the try block: ROS logs with them only
  endSoonAfterShutdown();
  try {
    deformable_contact_monitor::ContactMonitor monitor(node, private_node);
    while (ros::ok() && !monitor.isUnregistered()) {
      ros::getGlobalCallbackQueue()->callAvailable(ros::WallDuration(0.1));
    }
    if (monitor.isUnregistered()) {
      exit_code = 1;
      ROS_FATAL(
          "shutting down: this node is no longer registered with the ROS master (respawn restarts "
          "it)");
    }
  } catch (const deformable_contact_monitor::ReadingStopped&) {
    return 0;  // Ctrl-C while the robot was read
  } catch (const std::exception& error) {
    exit_code = 1;
    ROS_FATAL_STREAM(error.what());
  }
  return exit_code;
}
