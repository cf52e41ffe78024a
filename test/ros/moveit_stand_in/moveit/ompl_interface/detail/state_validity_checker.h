// Stand-ins for the classes of OMPL and MoveIt (Noetic) that config/docs/cloth_validity_checker.h
// uses, with the same names and signatures. MoveIt is not in Debian.
#pragma once

#include <string>
#include <vector>

namespace ompl::base {

class State {};

class StateValidityChecker {
 public:
  virtual ~StateValidityChecker() = default;
  virtual bool isValid(const State* state) const = 0;
  virtual bool isValid(const State* state, double& distance) const = 0;
};

}  // namespace ompl::base

namespace moveit::core {

class JointModelGroup {
 public:
  const std::vector<std::string>& getVariableNames() const { return names; }

  std::vector<std::string> names;
};

class RobotState {
 public:
  void copyJointGroupPositions(const JointModelGroup* /*group*/, std::vector<double>& to) const {
    to = positions;
  }

  std::vector<double> positions;
};

}  // namespace moveit::core

namespace ompl_interface {

class ModelBasedPlanningContext;

class TSStateStorage {
 public:
  moveit::core::RobotState* getStateStorage() const { return &state_; }

 private:
  mutable moveit::core::RobotState state_;
};

class StateValidityChecker : public ompl::base::StateValidityChecker {
 public:
  explicit StateValidityChecker(const ModelBasedPlanningContext* planning_context)
      : planning_context_(planning_context) {}

  bool isValid(const ompl::base::State* /*state*/) const override { return is_valid; }
  bool isValid(const ompl::base::State* /*state*/, double& /*distance*/) const override {
    return is_valid;
  }

  bool is_valid = true;

 protected:
  const ModelBasedPlanningContext* planning_context_;
  std::string group_name_;
  TSStateStorage tss_;
};

}  // namespace ompl_interface
