// From a bag's bytes to messages, every size checked before memory is asked for.
//
// An object may have any type that the node accepts; all become DeformableMesh here, by the node's
// own adapters.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <ros/time.h>
#include <sensor_msgs/JointState.h>
#include <std_msgs/Header.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <set>
#include <string>

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"
#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {

// The types that the monitor's cycles always need; tf/tfMessage is how transforms were recorded
// before tf2, and reads as tf2_msgs/TFMessage.
const std::set<std::string>& neededTypes();

bool isTransforms(const BagMessage& message);
bool isLinkMeshes(const BagMessage& message);
bool isText(const BagMessage& message);
bool isJointState(const BagMessage& message);

// Returns whether tf2 accepts the transform, whatever its stamp is: frames have names, and numbers
// are finite and make a rotation.
bool isValid(const geometry_msgs::TransformStamped& transform);

// They throw std::runtime_error, "<topic>: <what>", if the bytes are not exactly one message of the
// type, or the type was defined otherwise when it was recorded.
tf2_msgs::TFMessage toTransforms(const BagMessage& message);
LinkMeshes toLinkMeshes(const BagMessage& message);
std::string toText(const BagMessage& message);
// Reads the header that a mesh of this object begins with; of an array, that of the object's
// marker.
std_msgs::Header headerOf(const BagMessage& message, const ObjectParameters& object);
// Without a stamp it has that of its receipt.
sensor_msgs::JointState toJointState(const BagMessage& message);

// Returns true if the message has a type that an object may have.
bool isMesh(const BagMessage& message);

// What is known of a mesh in a bag before its triangles are needed.
struct BagMeshHead {
  ros::Time stamp;                // of its header; zero: the type has no header
  DeformableMesh::ConstPtr mesh;  // null: it is of another type
  bool is_deletion = false;       // of a marker
  bool says_nothing = false;      // an array without the object's marker
};

// Reads what the first reading of the bags needs of a mesh of `object`. Throws std::runtime_error
// as RecordedMeshReader does.
BagMeshHead headOf(const BagMessage& message, const ObjectParameters& object);

// Decodes the messages of one object. They must come in the order of their cycles. The time of
// receipt is that of the recording. Throws std::runtime_error, "<topic>: <what>", if the bytes are
// not exactly one message of the object's type, or the recorded definition of the type differs. The
// mesh has no message if an array says nothing about the object.
using RecordedMeshReader = std::function<IncomingMesh(const BagMessage& message)>;
RecordedMeshReader recordedMeshReader(const ObjectParameters& object);

}  // namespace deformable_contact_monitor
