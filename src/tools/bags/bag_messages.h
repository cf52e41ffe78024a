// From a bag's bytes to messages, every size checked before memory is asked for.
#pragma once

#include <deformable_contact_monitor/LinkMeshes.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Header.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <set>
#include <string>

#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {

// The types that the monitor's cycles always need; tf/tfMessage is how transforms were recorded
// before tf2, and reads as tf2_msgs/TFMessage.
const std::set<std::string>& neededTypes();

bool isTransforms(const BagMessage& message);
bool isLinkMeshes(const BagMessage& message);
bool isText(const BagMessage& message);
bool isJointState(const BagMessage& message);

// They throw std::runtime_error, "<topic>: <what>", if the bytes are not exactly one message of the
// type, or the type was defined otherwise when it was recorded.
tf2_msgs::TFMessage toTransforms(const BagMessage& message);
LinkMeshes toLinkMeshes(const BagMessage& message);
std::string toText(const BagMessage& message);
// Reads the header that the message begins with.
std_msgs::Header headerOf(const BagMessage& message);
// Without a stamp it has that of its receipt.
sensor_msgs::JointState toJointState(const BagMessage& message);

}  // namespace deformable_contact_monitor
