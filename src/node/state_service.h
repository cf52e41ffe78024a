// Serves what planners ask: the service ~check_states and the topics ~states_to_check and
// ~states_checked.
#pragma once

#include <deformable_contact_monitor/CheckStates.h>
#include <deformable_contact_monitor/StatesToCheck.h>
#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <memory>

#include "core/state_checker.h"
#include "monitor/planning/state_questions.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The most questions of ~states_to_check that wait. One more drops the oldest.
constexpr int kMostWaitingQuestions = 64;

// Answers in two threads of its own, one for the service and one for the topic, which take turns.
// So neither meshes nor cycles wait for a planner.
class StateService {
 public:
  // What the arguments refer to must outlive this.
  StateService(const MonitorParameters& parameters, QuestionSources sources,
               std::unique_ptr<StateChecker> checker, const ros::NodeHandle& private_node);

  // Ends both threads. A question that is being answered ends soon once the sources' requests are
  // stopped. No question is answered after this.
  void stop();

 private:
  bool checkStates(CheckStates::Request& request, CheckStates::Response& response);
  void receive(const StatesToCheck::ConstPtr& question);

  StateQuestions questions_;
  ros::CallbackQueue service_queue_, topic_queue_;
  ros::AsyncSpinner service_spinner_{1, &service_queue_}, topic_spinner_{1, &topic_queue_};
  ros::Publisher publisher_;
  ros::Subscriber subscriber_;
  ros::ServiceServer service_;
};

}  // namespace deformable_contact_monitor
