// Runs the monitor as a node of its own. Exit code: 0 after a shutdown, 1 if it could not start or
// is no longer registered with the ROS master, and 2 if the command line is wrong.
#include <ros/callback_queue.h>
#include <ros/ros.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "node/contact_monitor.h"
#include "robot/link_mesh_files.h"

namespace {

std::atomic<int> exit_code{0};

constexpr const char* kHelp =
    R"(A node that publishes which triangles of a robot's links and of deforming objects touch.

Usage: roslaunch deformable_contact_monitor contact_monitor.launch [NAME:=VALUE...]
       rosrun deformable_contact_monitor contact_monitor [REMAPPING...]

  roslaunch deformable_contact_monitor contact_monitor.launch \
    reference_frame:=base_link objects:="[{name: cloth, topic: /cloth/mesh}]"

By rosrun it has private parameters (_margin_m:=0.05) and takes remappings (__name:=monitor).
config/contact_monitor.yaml explains all parameters. The launch file's arguments are listed by
roslaunch --ros-args deformable_contact_monitor contact_monitor.launch

Options:
  -h [ --help ]         Print this and exit
  --version             Print the version and exit
)";

// Answers --help and --version, and refuses every other word that ROS does not read. Returns the
// exit code; nothing: the node is to run. Does not touch ROS, so that a running node of the same
// name goes on.
std::optional<int> answer(int argc, const char* const* argv) {
  std::vector<std::string> words;
  ros::removeROSArgs(argc, argv, words);
  for (const std::string& word : words) {
    const bool is_help = word == "--help" || word == "-h";
    if (!is_help && word != "--version") continue;
    std::fputs(is_help ? kHelp : "contact_monitor " DCM_VERSION "\n", stdout);
    return 0;
  }
  if (words.size() < 2) return std::nullopt;  // the first is the program's name
  std::fprintf(stderr, "contact_monitor: '%s' is not one of its arguments (see --help)\n",
               words[1].c_str());
  return 2;
}

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
  if (const std::optional<int> code = answer(argc, argv)) return *code;
  // Otherwise a file or a pipe would get the lines of INFO only when the node ends.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
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
          "it); see config/docs/console.md#the-ros-master");
    }
  } catch (const deformable_contact_monitor::ReadingStopped&) {
    return 0;  // Ctrl-C while the robot was read
  } catch (const std::exception& error) {
    if (ros::isShuttingDown()) return 0;  // Ctrl-C while it started: roscpp is no longer whole
    exit_code = 1;
    ROS_FATAL_STREAM(error.what() << "\n  see config/docs/console.md#it-does-not-start");
  }
  return exit_code;
}
