// Collects the triangles of the groups that a caller asked for while a mesh file is read.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {

// Holds the groups by name. A reader looks up each group that the file has, and adds its triangles
// in file order.
class MeshGroups {
 public:
  struct Group {
    bool exists = false;  // the file has it
    TriangleRanges triangles;

    // Adds the triangles [first, end). `first` must not be below that of the call before.
    void add(std::size_t first, std::size_t end);
  };
  using ByName = std::map<std::string, Group, std::less<>>;

  explicit MeshGroups(const std::vector<std::string>& names);

  // Returns the groups that were asked for.
  ByName& wanted() { return wanted_; }

  // Returns a group of the file, which exists then, or null if nobody asked for it.
  Group* find(std::string_view name);

  // Keeps the name of a group of the file, if it is one of the first few, for messages.
  void note(std::string_view name);

  // Throws std::runtime_error, "<path>: <what>", unless all groups exist and have triangles.
  void requireAll(const std::string& path) const;

 private:
  ByName wanted_;
  std::vector<std::string> noted_;  // in quotes
};

}  // namespace deformable_contact_monitor
