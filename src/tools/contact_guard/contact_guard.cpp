// contact_guard: the node that publishes a speed scale and a stop from the states of a monitor.
//
// It subscribes to the monitor's ~contact_states and publishes ~speed_scale, ~stop and ~warning at
// a fixed rate, and at once if they change. Class Guard decides; this file holds what needs ROS:
// topics, the service ~release, diagnostics, and two threads.
#include <deformable_contact_monitor/ContactStates.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Float64.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <exception>
#include <mutex>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "tools/common/command_line.h"
#include "tools/common/ros_words.h"
#include "tools/common/run_tool.h"
#include "tools/contact_guard/guard.h"
#include "tools/contact_guard/guard_parameters.h"

namespace deformable_contact_monitor {
namespace {

SteadyTime steadyNow() { return std::chrono::steady_clock::now(); }

// Reads all parameters of the private namespace at once, and logs what is not at its default.
// Throws GuardParameterError.
GuardParameters readParameters(const ros::NodeHandle& private_node) {
  XmlRpc::XmlRpcValue tree;
  ros::param::get(private_node.getNamespace(), tree);
  GuardParameters parameters = parseGuardParameters(tree);
  std::string changed;
  for (const std::string& value : parameters.changed) changed += "\n  " + value;
  ROS_INFO_STREAM("on the parameter server below "
                  << private_node.getNamespace() << ": "
                  << (changed.empty() ? "the defaults alone" : "not the default are") << changed);
  return parameters;
}

// Runs the guard on two threads: callbacks on a spinner's thread, the output in run(). A callback
// that takes long (one asks the ROS master for parameters) therefore cannot delay a stop.
class GuardNode {
 public:
  // Subscribes last, so that the subscription is destroyed first, before anything that its callback
  // uses. Callbacks run only after main() has started the spinner.
  GuardNode(ros::NodeHandle node, ros::NodeHandle private_node)
      : parameters_(readParameters(private_node)),
        guard_(parameters_, steadyNow()),
        scale_publisher_(private_node.advertise<std_msgs::Float64>("speed_scale", 1)),
        stop_publisher_(private_node.advertise<std_msgs::Bool>("stop", 1)),
        warning_publisher_(private_node.advertise<std_msgs::Bool>("warning", 1)),
        updater_(node, private_node, private_node.getNamespace()),
        release_(private_node.advertiseService("release", &GuardNode::release, this)),
        states_(node.subscribe(parameters_.monitor + "/contact_states", 1, &GuardNode::store, this,
                               ros::TransportHints().tcpNoDelay())) {
    updater_.setHardwareID("none");
    updater_.add("guard", this, &GuardNode::describe);
  }
  GuardNode(const GuardNode&) = delete;
  GuardNode& operator=(const GuardNode&) = delete;

  // Publishes until ROS shuts down. It is paced by the steady clock, so the output goes on when ROS
  // time stands still. It sleeps until the next output is due or a message has arrived.
  void run() {
    const auto period = fromSeconds(1 / parameters_.rate_hz);
    SteadyTime due = steadyNow();
    SteadyTime diagnostics_due = due;
    while (ros::ok()) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        news_.wait_until(lock, due, [this] { return has_news_; });
        has_news_ = false;
      }
      const SteadyTime now = steadyNow();
      publish(now >= due);
      if (now >= due) due = now + period;
      if (now < diagnostics_due) continue;
      diagnostics_due = now + std::chrono::seconds(1);
      updater_.force_update();
    }
  }

 private:
  // Publishes the output if it is due or has changed. Decides while the mutex is held, and
  // publishes without it, so that sending never delays a callback.
  void publish(bool is_due) {
    GuardOutput output, before;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      const ros::Time now = ros::Time::now();
      output = guard_.decide(now, steadyNow());
      nearest_m_ = guard_.nearest(now);
      before = std::exchange(output_, output);
    }
    const bool turned = output.stop != before.stop;
    const bool warned = output.warn != before.warn;
    if (!is_due && !turned && !warned && output.scale == before.scale) return;
    std_msgs::Bool stop;
    stop.data = output.stop;
    stop_publisher_.publish(stop);
    std_msgs::Float64 scale;
    scale.data = output.scale;
    scale_publisher_.publish(scale);
    std_msgs::Bool warning;
    warning.data = output.warn;
    warning_publisher_.publish(warning);
    tell(output);
    // A distance that wavers around warn_distance_m must not fill the log.
    if (warned && !output.near.empty()) ROS_WARN_STREAM_THROTTLE(1, "near: " << output.near);
  }

  // Logs a stop that begins, ends or goes on for another reason, at most one line a second, so that
  // an object that trembles at stop_distance_m does not fill the log. Waits a second after the
  // start, because the first states need some time.
  void tell(const GuardOutput& output) {
    std::string reason = output.stop ? output.because : "";
    reason.erase(std::remove_if(reason.begin(), reason.end(),  // numbers always change
                                [](char c) { return (c >= '0' && c <= '9') || c == '.'; }),
                 reason.end());
    const SteadyTime now = steadyNow();
    if (reason == told_ || now - told_at_ < std::chrono::seconds(1)) return;
    told_ = std::move(reason);
    told_at_ = now;
    if (output.stop) {
      ROS_WARN_STREAM("stop: " << output.because);
    } else {
      ROS_INFO("no stop any more");
    }
  }

  // Takes a message in the spinner's thread, and wakes run(). Once a second, a message that lists
  // pairs also starts the check of their margins, which may change at any time.
  void store(const ContactStates& states) {
    const SteadyTime now = steadyNow();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      guard_.store(states, ros::Time::now(), now);
      has_news_ = true;
    }
    news_.notify_one();
    if (states.states.empty() || now < margins_due_) return;
    margins_due_ = now + std::chrono::seconds(1);
    checkMargins(states);
  }

  // Compares the monitor's margins with the guard's distances, and warns where that has changed.
  // The parameters are cached, so that the ROS master is only asked after they have changed. It is
  // asked without holding the mutex, because that may take long.
  void checkMargins(const ContactStates& states) {
    XmlRpc::XmlRpcValue tree;
    ros::param::getCached(parameters_.monitor, tree);
    const std::string warning = tooSmallMargins(tree, states, parameters_);
    if (warning == margin_warning_) return;
    if (!warning.empty()) ROS_WARN_STREAM(warning);
    const std::lock_guard<std::mutex> lock(mutex_);
    margin_warning_ = warning;
  }

  // Serves ~release: ends a latched stop unless there is still a reason to stop.
  bool release(std_srvs::Trigger::Request& /*request*/, std_srvs::Trigger::Response& response) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const std::string cause = guard_.release(ros::Time::now(), steadyNow());
    response.success = cause.empty();
    response.message = cause.empty() ? "released" : "still stopped: " + cause;
    return true;
  }

  // Fills the status `guard` of /diagnostics. run() calls it once a second.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status) {
    using diagnostic_msgs::DiagnosticStatus;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (output_.stop) {
      status.summary(DiagnosticStatus::ERROR, "stop: " + output_.because);
    } else if (output_.scale < 1) {
      status.summary(DiagnosticStatus::WARN, "slow: " + output_.because);
    } else if (output_.warn) {
      status.summary(DiagnosticStatus::WARN, "near: " + output_.near);
    } else {
      status.summary(DiagnosticStatus::OK, "free");
    }
    if (!margin_warning_.empty()) status.mergeSummary(DiagnosticStatus::WARN, margin_warning_);
    status.add("stop", output_.stop);
    status.add("speed scale", output_.scale);
    status.add("warning", output_.warn);
    status.add("latched", guard_.isLatched());
    status.add("least certain distance [m]", nearest_m_);
  }

  const GuardParameters parameters_;

  std::string told_;  // the reason of the stop that was logged last; empty: no stop
  SteadyTime told_at_ = steadyNow();
  SteadyTime margins_due_;  // when the spinner's thread looks at the margins again

  std::mutex mutex_;  // guards what follows
  std::condition_variable news_;
  bool has_news_ = false;
  Guard guard_;
  GuardOutput output_;
  double nearest_m_ = 0;
  std::string margin_warning_;  // only the spinner's thread writes it

  ros::Publisher scale_publisher_, stop_publisher_, warning_publisher_;
  diagnostic_updater::Updater updater_;
  ros::ServiceServer release_;
  ros::Subscriber states_;
};

// Runs the node until ROS shuts down. Returns the exit code.
int runGuard(int argc, char** argv) {
  // Otherwise a file or a pipe would get the lines of INFO only when the node ends.
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);
  ros::init(argc, argv, "contact_guard");
  const ros::NodeHandle node, private_node("~");  // outlive the try: without one, ROS logs nothing
  try {
    GuardNode guard(node, private_node);
    ros::AsyncSpinner spinner(1);
    spinner.start();
    guard.run();
  } catch (const std::exception& error) {
    ROS_FATAL_STREAM(error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

// Exit code: 0 after a shutdown, 1 after an exception, such as wrong parameters, and 2 if the
// command line is wrong.
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("contact_guard", [argc, argv] {
    dcm::CommandLine line(
        "contact_guard",
        "A node that publishes a speed scale and a stop, computed from the states of a running\n"
        "contact_monitor. Start it by\n\n"
        "  roslaunch deformable_contact_monitor contact_guard.launch slow_distance_m:=0.1",
        "It has private parameters (_stop_distance_m:=0.02) and takes remappings (__name:=guard).\n"
        "Its README and contact_guard.launch list them.");
    return line.parse(dcm::wordsForNode(argc, argv)) ? dcm::runGuard(argc, argv) : 0;
  });
}
