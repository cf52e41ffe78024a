// Asks the MoveIt example (config/docs/cloth_validity_checker.h) about one state, with stand-ins of
// MoveIt's classes. Usage: cloth_validity JOINT POSITION [JOINT POSITION...]. Prints "valid" or
// "not".
#include <ros/ros.h>

#include <cstdio>
#include <cstdlib>

#include "cloth_validity_checker.h"

int main(int argc, char** argv) {
  ros::init(argc, argv, "cloth_validity", ros::init_options::AnonymousName);
  ompl_interface::ModelBasedPlanningContext context;
  for (int i = 1; i + 1 < argc; i += 2) {
    context.group.names.emplace_back(argv[i]);
    context.space->positions.push_back(std::atof(argv[i + 1]));
  }
  const ClothValidityChecker checker(&context, ros::NodeHandle(), 0.0F);
  const ompl::base::State state;
  double distance = 0;
  const bool is_valid = checker.isValid(&state);
  if (is_valid != checker.isValid(&state, distance)) return 1;
  std::puts(is_valid ? "valid" : "not");
  return 0;
}
