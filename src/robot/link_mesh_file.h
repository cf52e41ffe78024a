// Mesh files of robot links. They are foreign, and so is the library that reads them: each is read
// by a process of its own.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>

#include "robot/reading_limits.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

struct MeshReading {
  // Whether to give up, at the end of this process; asked every few milliseconds, from any thread.
  std::function<bool()> stop;
  // The program read_link_mesh; empty: this installation's (reader_program.h).
  std::string program;
  std::chrono::milliseconds file_time = kMaxFileTime;
  std::chrono::milliseconds robot_time = kMaxRobotTime;
  std::size_t robot_mib = kMaxRobotMib;
};

// MeshReading::stop said so.
class ReadingStopped : public std::runtime_error {
 public:
  ReadingStopped() : std::runtime_error("reading the robot's meshes was stopped") {}
};

// Reads STL (ascii or binary), DAE or OBJ, and no other file that it names; the format is the file
// name's ending, STL's flavour its content. Node hierarchies are applied, nodes in depth-first
// order; polygons are triangulated; points and lines are dropped; nothing is joined or removed.
// As in rviz, COLLADA's <unit> is applied and its <up_axis> is not: a link's frame is what the
// file's numbers say.
// Throws std::runtime_error, "<path>: <what>", if the file cannot be read within the limits of
// reading_limits.h or holds no triangle, and ReadingStopped. Any thread.
SourceMesh readLinkMeshFile(const std::string& path, const MeshReading& reading = {});

}  // namespace deformable_contact_monitor
