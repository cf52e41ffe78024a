// Reads the mesh files of robot links. Neither the files nor the library that reads them can be
// trusted. So a process of its own (read_link_mesh) reads each file, and a bad file cannot crash,
// block or fill the robot's process.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "robot/reading_limits.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

// Turns a mesh URI (package://, file://, a plain path) into a local path. Throws
// std::runtime_error, which says what was looked for and where.
using ResourceResolver = std::function<std::string(const std::string& uri)>;

// Resolves package:// with rospack, and file:// and absolute paths directly.
ResourceResolver makeRosResolver();

// Says how mesh files are read: by which program, and within which limits.
struct MeshReading {
  // Returns true when reading shall end early, as at the end of this process. It is called every
  // few milliseconds from any thread.
  std::function<bool()> stop;
  // The path of the program read_link_mesh. If it is empty, findReaderProgram() looks for the one
  // of this installation.
  std::string program;
  std::chrono::milliseconds file_time = kMaxFileTime;
  std::chrono::milliseconds robot_time = kMaxRobotTime;
  std::size_t robot_mib = kMaxRobotMib;
};

// Thrown when MeshReading::stop returned true.
class ReadingStopped : public std::runtime_error {
 public:
  ReadingStopped() : std::runtime_error("reading the robot's meshes was stopped") {}
};

// Reads one STL, OBJ, PLY, OFF or DAE file and no other file that it names. The format is the file
// name's ending. All but DAE are read as readMeshFile() (core/mesh_file.h) reads them. Of a DAE,
// node hierarchies are applied, nodes in depth-first order; polygons are triangulated; points and
// lines are dropped; nothing is joined or removed. As in rviz, COLLADA's <unit> is applied and its
// <up_axis> is not: a link's frame is the one of the file's numbers.
// Throws std::runtime_error, "<path>: <what>", if the file cannot be read within the limits of
// reading_limits.h or holds no triangle, and ReadingStopped. Thread-safe.
SourceMesh readLinkMeshFile(const std::string& path, const MeshReading& reading = {});

// Owns the meshes of all files of a robot.
class LinkMeshFiles {
 public:
  // Resolves each URI in turn, then reads each distinct file once, several at a time. An error of
  // one file is kept for mesh() and stops no other file. Throws ReadingStopped.
  LinkMeshFiles(const std::vector<std::string>& uris, const ResourceResolver& resolve,
                const MeshReading& reading);

  // Returns the mesh of one of those URIs. Throws std::runtime_error if it could not be read.
  const SourceMesh& mesh(const std::string& uri) const;

 private:
  struct File {
    SourceMesh mesh;
    std::string problem;  // empty: there is a mesh
  };

  std::map<std::string, std::string> path_of_;     // by URI
  std::map<std::string, std::string> problem_of_;  // by URI, for those without a path
  std::map<std::string, File> files_;              // by path: robots use one file for many links
};

}  // namespace deformable_contact_monitor
