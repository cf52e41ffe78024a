// Stand-ins for MoveIt's planning context and its state space (state_validity_checker.h).
#pragma once

#include <moveit/ompl_interface/detail/state_validity_checker.h>

#include <memory>
#include <utility>
#include <vector>

namespace ompl_interface {

// Its states are all those positions.
class ModelBasedStateSpace {
 public:
  virtual ~ModelBasedStateSpace() = default;
  virtual void copyToRobotState(moveit::core::RobotState& robot,
                                const ompl::base::State* /*state*/) const {
    robot.positions = positions;
  }

  std::vector<double> positions;
};

class ModelBasedPlanningContext {
 public:
  const std::shared_ptr<ModelBasedStateSpace>& getOMPLStateSpace() const { return space; }
  const moveit::core::JointModelGroup* getJointModelGroup() const { return &group; }

  std::shared_ptr<ModelBasedStateSpace> space = std::make_shared<ModelBasedStateSpace>();
  moveit::core::JointModelGroup group;
};

}  // namespace ompl_interface
