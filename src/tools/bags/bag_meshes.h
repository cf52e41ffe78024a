// Decodes recorded messages of the objects' types.
//
// An object may have any type that the node accepts; all become DeformableMesh here, by the node's
// own adapters.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <functional>

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"
#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {

// Returns true if the message has a type that an object may have.
bool isMesh(const BagMessage& message);

struct BagMeshHead {
  ros::Time stamp;                // of its header; zero: the type has no header
  DeformableMesh::ConstPtr mesh;  // null: it is of another type
  bool is_deletion = false;       // of a marker
};

// Reads what the first reading of the bags needs. Throws std::runtime_error as RecordedMeshReader
// does.
BagMeshHead headOf(const BagMessage& message);

// Decodes the messages of one object. They must come in the order of their cycles. The time of
// receipt is that of the recording. Throws std::runtime_error, "<topic>: <what>", if the bytes are
// not exactly one message of the object's type, or the recorded definition of the type differs.
using RecordedMeshReader = std::function<IncomingMesh(const BagMessage& message)>;
RecordedMeshReader recordedMeshReader(const ObjectParameters& object);

}  // namespace deformable_contact_monitor
