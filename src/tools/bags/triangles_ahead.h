// Triangles that a recording has later than the meshes that need them.
#pragma once

#include <deformable_contact_monitor/DeformableMesh.h>
#include <ros/time.h>

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// A recording that began between two messages with triangles has meshes before the first of them.
// Such a mesh takes the triangles of the next mesh of its object that was sent with any, if
// topology_id and number of vertices are the same in all meshes from the one to the other. Keeps
// those triangles alone.
class TrianglesAhead {
 public:
  // Every DeformableMesh of the bags, in order of receipt. `number` tells them apart; those of one
  // `object`, whatever its name, belong together.
  void add(const std::string& object, std::uint64_t number, const ros::Time& stamp,
           const DeformableMesh::ConstPtr& mesh);

  // After the last mesh, once.
  void settle();

  // The message whose triangles that mesh needs; null: it needs none, or there are none. It is the
  // first in the order of stamps that needs them, and meshes after it know them by it.
  DeformableMesh::ConstPtr of(std::uint64_t number) const;

  // Meshes that have their triangles thus.
  std::uint64_t count() const { return count_; }

 private:
  struct Mesh {
    ros::Time stamp;
    std::uint64_t number = 0;
    std::uint32_t topology_id = 0;
    std::size_t coordinates = 0;
    bool has_triangles = false;
  };
  struct Object {
    std::vector<Mesh> meshes;
    std::set<std::uint32_t> wanted;   // topology ids whose triangles had not come
    DeformableMesh::ConstPtr newest;  // with triangles
    std::uint64_t newest_number = 0;
    ros::Time newest_stamp;
    std::map<std::uint64_t, DeformableMesh::ConstPtr> kept;  // with triangles, by number
  };

  void settle(Object* object);

  std::map<std::string, Object> objects_;
  std::map<std::uint64_t, DeformableMesh::ConstPtr> needed_;  // by the mesh that needs it
  std::uint64_t count_ = 0;
};

}  // namespace deformable_contact_monitor
