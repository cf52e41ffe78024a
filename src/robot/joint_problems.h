// What is wrong with how a robot's joints hang together. urdfdom accepts all of it.
#pragma once

#include <vector>

#include "robot/robot_joint.h"

namespace deformable_contact_monitor {

// Sets tree_problem and mimic_problem of each of these joints of one robot.
void findJointProblems(std::vector<RobotJoint>* joints);

}  // namespace deformable_contact_monitor
