// Serves what planners ask: the service ~check_states and the topics ~states_to_check and
// ~states_checked.
#include "node/state_service.h"

#include <ros/console.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <thread>
#include <utility>

#include "monitor/input/checked_subscription.h"

namespace deformable_contact_monitor {
namespace {

// Leaves half of the processors to the cycles, which run at the same time.
int threadsOfChecker() {
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / 2);
}

// Lets the cycles' threads go first where processors are short. On Linux each thread has a priority
// of its own, and lowering it needs no rights.
void yieldToCycles() {
  constexpr int kNice = 10;
  thread_local bool has_yielded = false;
  if (has_yielded) return;
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), kNice);
  has_yielded = true;
}

}  // namespace

StateService::StateService(const MonitorParameters& parameters, QuestionSources sources,
                           std::unique_ptr<StateChecker> checker,
                           const ros::NodeHandle& private_node)
    : questions_(parameters, std::move(sources), std::move(checker), threadsOfChecker()) {
  ros::NodeHandle topic_node(private_node), service_node(private_node);
  topic_node.setCallbackQueue(&topic_queue_);
  service_node.setCallbackQueue(&service_queue_);
  publisher_ = topic_node.advertise<StatesChecked>("states_checked", kMostWaitingQuestions);
  ros::SubscribeOptions options = checkedSubscription<StatesToCheck>(
      "states_to_check", kMostWaitingQuestions,
      [this](const StatesToCheck::ConstPtr& question) { receive(question); },
      [](const std::string& problem) {
        ROS_ERROR_STREAM("~states_to_check: a message is dropped: "
                         << problem << "; see config/docs/plan_around_a_cloth.md");
      });
  subscriber_ = topic_node.subscribe(options);
  service_ = service_node.advertiseService("check_states", &StateService::checkStates, this);
  service_spinner_.start();
  topic_spinner_.start();
}

void StateService::stop() {
  service_spinner_.stop();
  topic_spinner_.stop();
}

bool StateService::checkStates(CheckStates::Request& request, CheckStates::Response& response) {
  yieldToCycles();
  response.checked = questions_.answer(request.states);
  if (!response.checked.success) {
    ROS_WARN_STREAM_THROTTLE(
        1, "~check_states: refused: " << response.checked.reason
                                      << "; see config/docs/plan_around_a_cloth.md");
  }
  return true;
}

void StateService::receive(const StatesToCheck::ConstPtr& question) {
  yieldToCycles();
  const auto answer = boost::make_shared<StatesChecked>(questions_.answer(*question));
  if (!answer->success) {
    ROS_WARN_STREAM_THROTTLE(
        1, "~states_to_check: refused: " << answer->reason
                                         << "; see config/docs/plan_around_a_cloth.md");
  }
  publisher_.publish(answer);
}

}  // namespace deformable_contact_monitor
