// An example for MoveIt with OMPL: a state is valid if MoveIt says so, and contact_monitor says
// that the robot is free of cloth there. config/docs/plan_around_a_cloth.md explains it. Tests
// compile it against stand-ins of MoveIt's classes.
//
// In a copy of MoveIt's planning context, after it has set its own checker:
//   ompl_simple_setup_->setStateValidityChecker(std::make_shared<ClothValidityChecker>(this,
//   node));
#pragma once

#include <deformable_contact_monitor/CheckStates.h>
#include <deformable_contact_monitor/ContactState.h>
#include <moveit/ompl_interface/detail/state_validity_checker.h>
#include <moveit/ompl_interface/model_based_planning_context.h>
#include <ros/console.h>
#include <ros/node_handle.h>

#include <mutex>
#include <string>
#include <vector>

// Any thread of the planner may ask. One asks at a time, because they share a connection.
class ClothValidityChecker : public ompl_interface::StateValidityChecker {
 public:
  // `clearance_m` >= 0 is how far away from the cloth a state must be [m].
  ClothValidityChecker(const ompl_interface::ModelBasedPlanningContext* context,
                       const ros::NodeHandle& node, float clearance_m = 0)
      : StateValidityChecker(context), node_(node), clearance_m_(clearance_m) {}

  bool isValid(const ompl::base::State* state) const override {
    return StateValidityChecker::isValid(state) && isFreeOfCloth(state);
  }
  bool isValid(const ompl::base::State* state, double& distance) const override {
    return StateValidityChecker::isValid(state, distance) && isFreeOfCloth(state);
  }

 private:
  using CheckStates = deformable_contact_monitor::CheckStates;

  // Returns false as well if the monitor does not answer or does not know: that is not "free".
  bool isFreeOfCloth(const ompl::base::State* state) const {
    moveit::core::RobotState* const robot = tss_.getStateStorage();
    planning_context_->getOMPLStateSpace()->copyToRobotState(*robot, state);
    const moveit::core::JointModelGroup* const group = planning_context_->getJointModelGroup();
    CheckStates question;
    question.request.states.joint_names = group->getVariableNames();
    robot->copyJointGroupPositions(group, question.request.states.positions);
    question.request.states.margin = clearance_m_;
    question.request.states.first_only = clearance_m_ <= 0;
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!client_.isValid()) {
      client_ = node_.serviceClient<CheckStates>("contact_monitor/check_states", true);
    }
    if (!client_.call(question) || !question.response.checked.success) {
      ROS_ERROR_STREAM_THROTTLE(1,
                                "no answer about the cloth: " << question.response.checked.reason);
      return false;
    }
    return question.response.checked.state.at(0) == deformable_contact_monitor::ContactState::NONE;
  }

  mutable ros::NodeHandle node_;
  const float clearance_m_;
  mutable std::mutex mutex_;  // guards the client
  mutable ros::ServiceClient client_;
};
