// All mesh files of a robot.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "robot/link_mesh_file.h"
#include "robot/robot_geometry.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

class LinkMeshFiles {
 public:
  // Resolves each URI in turn, then reads each distinct file once, several at a time. What is wrong
  // with one is kept for mesh(). Throws ReadingStopped.
  LinkMeshFiles(const std::vector<std::string>& uris, const ResourceResolver& resolve,
                const MeshReading& reading);

  // Of one of those URIs. Throws std::runtime_error if it could not be had.
  const SourceMesh& mesh(const std::string& uri) const;

 private:
  struct File {
    SourceMesh mesh;
    std::string problem;  // empty: there is a mesh
  };

  std::map<std::string, std::string> path_of_;     // by URI
  std::map<std::string, std::string> problem_of_;  // by URI, of those without a path
  std::map<std::string, File> files_;              // by path: robots use one file for many links
};

}  // namespace deformable_contact_monitor
