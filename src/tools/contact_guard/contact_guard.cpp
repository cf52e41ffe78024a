// contact_guard: the node that publishes a speed scale and a stop from the states of a monitor.
//
// It subscribes to the monitor's ~contact_states and publishes ~speed_scale, ~stop and ~warning at
// a fixed rate, and at once if they change. Class Guard decides; this file holds what needs ROS:
// topics, the service ~release, diagnostics, and two threads.
#include <deformable_contact_monitor/ContactStates.h>
#include <diagnostic_updater/diagnostic_updater.h>
#include <ros/message_event.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>
#include <std_msgs/Float64.h>
#include <std_srvs/Trigger.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <mutex>
#include <string>
#include <utility>

#include "core/steady_time.h"
#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
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

// Runs the guard on three threads: the output in run(), and callbacks on two threads of a spinner.
// One callback asks the ROS master for parameters, which may take long; the callback of states and
// the output wait for neither it nor the master. So they log nothing, because roscpp's logging
// waits while a parameter is asked for.
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
        every_second_(node.createWallTimer(ros::WallDuration(1), &GuardNode::lookAround, this)),
        states_(node.subscribe(parameters_.monitor + "/contact_states", kMostWaiting,
                               &GuardNode::store, this, ros::TransportHints().tcpNoDelay())) {
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
    while (ros::ok()) {
      {
        std::unique_lock<std::mutex> lock(mutex_);
        news_.wait_until(lock, due, [this] { return has_news_; });
        has_news_ = false;
      }
      const SteadyTime now = steadyNow();
      publish(now >= due);
      if (now >= due) due = std::max(due + period, now);  // none is made up for
    }
  }

 private:
  // Several, because a latch must see each message.
  static constexpr std::uint32_t kMostWaiting = 20;

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
      if (output.stop) unsaid_stop_ = output.because;
      if (!output.near.empty() && !before.warn) unsaid_near_ = output.near;
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
  }

  // Logs a stop of the last second that began or went on for another reason, or that there was
  // none any more. `because`: why the robot was stopped last; empty: it was not.
  void tell(const std::string& because) {
    std::string reason = withoutNumbers(because);
    if (reason == told_) return;
    told_ = std::move(reason);
    if (because.empty()) {
      ROS_INFO("no stop any more");
    } else {
      ROS_WARN_STREAM("stop: " << because);
    }
  }

  // Takes a message, and wakes run().
  void store(const ros::MessageEvent<const ContactStates>& event) {
    const ContactStates::ConstPtr& states = event.getConstMessage();
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      guard_.store(*states, event.getPublisherName(), ros::Time::now(), steadyNow());
      newest_ = states;
      has_news_ = true;
    }
    news_.notify_one();
  }

  // Logs what has changed, checks the margins of the pairs, which may change at any time, and sends
  // diagnostics. All of these may wait for the ROS master. Being called once a second, it logs
  // little of an object that trembles at stop_distance_m.
  void lookAround(const ros::WallTimerEvent& /*event*/) {
    ContactStates::ConstPtr states;
    std::string stop, near;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      states = newest_;
      std::swap(stop, unsaid_stop_);
      std::swap(near, unsaid_near_);
      // The first states need some time.
      if (!std::exchange(has_looked_, true) && !output_.stop) stop.clear();
    }
    tell(stop);
    if (!near.empty()) ROS_WARN_STREAM("near: " << near);
    if (states != nullptr && !states->states.empty()) checkMargins(*states);
    updater_.force_update();
  }

  // Compares the monitor's margins with the guard's distances, and warns where that has changed.
  // The parameters are cached, so that the ROS master is only asked after they have changed. It is
  // asked without holding the mutex.
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

  // Fills the status `guard` of /diagnostics.
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

  std::string told_;         // the reason of the stop that was logged last; empty: no stop
  bool has_looked_ = false;  // lookAround() was called

  std::mutex mutex_;  // guards what follows
  std::condition_variable news_;
  bool has_news_ = false;
  ContactStates::ConstPtr newest_;  // null: none came
  Guard guard_;
  GuardOutput output_;
  std::string unsaid_stop_, unsaid_near_;  // the last ones since lookAround()
  double nearest_m_ = 0;
  std::string margin_warning_;  // only lookAround() writes it

  ros::Publisher scale_publisher_, stop_publisher_, warning_publisher_;
  diagnostic_updater::Updater updater_;
  ros::ServiceServer release_;
  ros::WallTimer every_second_;
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
    ros::AsyncSpinner spinner(2);
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
