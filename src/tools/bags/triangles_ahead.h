// Finds triangles for meshes that were recorded before any message with triangles.
//
// The node would have to wait for the next message with triangles; an offline tool can look ahead.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Publishers send triangles only now and then, so a recording may begin with meshes that have none.
// Such a mesh takes the triangles of the next mesh of its object that has any, if topology_id and
// number of vertices are the same in all meshes from the one to the other, and the clock does not
// go back between them: a simulator that starts anew also counts topology_id anew. Only triangles
// that are needed stay in memory.
class TrianglesAhead {
 public:
  // A mesh and how often the clock had gone back before it.
  struct Cycle {
    std::uint64_t number = 0;
    std::size_t part = 0;
  };

  // Takes every DeformableMesh of the bags, in order of receipt. `number` identifies the mesh;
  // meshes with the same `object` belong together.
  void add(const std::string& object, std::uint64_t number, const ros::Time& stamp,
           const DeformableMesh::ConstPtr& mesh);

  // Decides which mesh takes which triangles. `cycles` are the meshes in the order of their cycles,
  // with all numbers from 0 on. Call it once, after the last mesh.
  void settle(const std::vector<Cycle>& cycles);

  // Returns the message whose triangles the mesh needs; null if it needs none, or there are none.
  // Only the first mesh that needs them, in the order of cycles, gets them: later ones use its.
  DeformableMesh::ConstPtr of(std::uint64_t number) const;

  // Returns the number of meshes whose triangles came later.
  std::uint64_t count() const { return count_; }

 private:
  using Messages = std::map<std::uint64_t, DeformableMesh::ConstPtr>;  // by number
  struct Mesh {
    ros::Time stamp;
    std::uint64_t number = 0;
    std::uint32_t topology_id = 0;
    std::size_t coordinates = 0;
    bool has_triangles = false;
  };
  struct Object {
    std::vector<Mesh> meshes;
    std::set<std::uint32_t> wanted;   // topology ids whose triangles have not come yet
    DeformableMesh::ConstPtr newest;  // the newest mesh with triangles
    std::uint64_t newest_number = 0;
    ros::Time newest_stamp;
    bool is_newest_known = false;  // no stamp has fallen since it came
    Messages kept;                 // with triangles
  };

  // Does so for an object's meshes of one part.
  void settle(const std::vector<Mesh>& meshes, const Messages& with_triangles);

  std::map<std::string, Object> objects_;
  Messages needed_;  // by the mesh that needs it
  std::uint64_t count_ = 0;
};

}  // namespace deformable_contact_monitor
