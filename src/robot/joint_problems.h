// Finds joints that form no tree, and bad mimics. urdfdom accepts all of them.
#pragma once

#include <vector>

#include "robot/robot_joint.h"

namespace deformable_contact_monitor {

// Sets tree_problem and mimic_problem of each of these joints of one robot.
void findJointProblems(std::vector<RobotJoint>* joints);

}  // namespace deformable_contact_monitor
