// Recorded messages of objects' types as meshes.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <functional>

#include "monitor/input/mesh_adapters.h"
#include "monitor/rules/parameters.h"
#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {

// Whether it is of a type that some object may have.
bool isMesh(const BagMessage& message);

struct BagMeshHead {
  ros::Time stamp;                // of its header; zero: it has none
  DeformableMesh::ConstPtr mesh;  // null: it is of another type
};

// Throws std::runtime_error as RecordedMeshReader does.
BagMeshHead headOf(const BagMessage& message);

// What one object's messages become, handed over in the order of their cycles; the time of receipt
// is that of the recording. Throws std::runtime_error, "<topic>: <what>", if the bytes are not
// exactly one message of the object's type, or the type was defined otherwise when it was recorded.
using RecordedMeshReader = std::function<ReceivedMesh(const BagMessage& message)>;
RecordedMeshReader recordedMeshReader(const ObjectParameters& object);

}  // namespace deformable_contact_monitor
