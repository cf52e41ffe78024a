// Reads the vertices and faces of Wavefront OBJ files. Groups and objects are joined into one mesh;
// their names are looked at if somebody asks for groups. Other statements do not describe triangles
// and are skipped.
#include <algorithm>
#include <charconv>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"
#include "core/mesh_files/polygons.h"

namespace deformable_contact_monitor {
namespace {

// The largest index of a vertex that is accepted, counted from 1.
constexpr std::int64_t kIndexLimit = std::int64_t{1} << 31;

// Returns whether the text has only characters of indices and the slashes between them. The indices
// of texture coordinates and normals are not used, so their values are not checked.
bool isIndexList(const char* at, const char* end) {
  for (; at != end; ++at) {
    if ((*at < '0' || *at > '9') && *at != '/' && *at != '-') return false;
  }
  return true;
}

// Reads one file. read() may be called once.
class ObjReader {
 public:
  ObjReader(const std::string& path, std::string_view content, MeshGroups* groups)
      : text_(path, content, MeshTextRules{true, true}), groups_(groups) {}

  TriangleMesh read(MeshFileReport* report) {
    if (!text_.skipToWord()) return {};
    do {
      const std::string_view statement = text_.word();
      if (statement == "v") {
        readVertex();
      } else if (statement == "f" || statement == "fo") {  // fo: a face, in old files
        readFace();
      } else if (groups_ != nullptr && (statement == "g" || statement == "o")) {
        readNames(statement == "g" ? &groups_here_ : &objects_here_);
      } else if (statement == "F" || statement == "V") {
        text_.fail("OBJ statements are in lower case");
      } else if (statement == "call" || statement == "surf") {
        text_.fail("'" + std::string(statement) +
                   "' is not supported: write what it stands for as triangles");
      }
    } while (text_.nextLine());
    if (farthest_index_ > static_cast<std::int64_t>(mesh_.vertexCount())) {
      text_.failOnLine(farthest_line_, "the face refers to vertex " +
                                           std::to_string(farthest_index_) + ", but there are " +
                                           std::to_string(mesh_.vertexCount()) + " vertices");
    }
    polygons_.triangulate(mesh_.vertices, report);
    return std::move(mesh_);
  }

 private:
  // Reads x, y and z. A weight or a colour may follow; it must be numbers, which are ignored.
  void readVertex() {
    for (int i = 0; i < 3; ++i) mesh_.vertices.push_back(text_.real("a coordinate"));
    while (!text_.atLineEnd()) text_.real("a weight or a colour");
  }

  // Reads the corners of a face up to the end of the line.
  void readFace() {
    const std::size_t first = mesh_.triangleCount();
    polygons_.begin();
    while (!text_.atLineEnd()) polygons_.add(vertexIndex(text_.word()));
    if (polygons_.size() < 3) {
      text_.fail("a face needs 3 vertices or more, this one has " +
                 std::to_string(polygons_.size()));
    }
    for (const auto* groups : {&groups_here_, &objects_here_}) {
      for (MeshGroups::Group* group : *groups) group->add(first, mesh_.triangleCount());
    }
  }

  // Reads the names of the groups, or of the object, that the faces from here on belong to.
  void readNames(std::vector<MeshGroups::Group*>* here) {
    here->clear();
    while (!text_.atLineEnd()) {
      const std::string_view name = text_.word();
      groups_->note(name);
      MeshGroups::Group* const group = groups_->find(name);
      const bool is_new = std::find(here->begin(), here->end(), group) == here->end();
      if (group != nullptr && is_new) here->push_back(group);
    }
  }

  // Returns the vertex index of "v", "v/vt", "v//vn" or "v/vt/vn". In the file, 1 is the first
  // vertex and -1 the last one so far.
  std::uint32_t vertexIndex(std::string_view word) {
    std::int64_t index = 0;
    const char* end = word.data() + word.size();
    const auto parsed = std::from_chars(word.data(), end, index);
    if (parsed.ec == std::errc::invalid_argument || !isIndexList(parsed.ptr, end) ||
        (parsed.ptr != end && *parsed.ptr != '/')) {
      text_.failAt(word, "a vertex index");
    }
    const auto count = static_cast<std::int64_t>(mesh_.vertexCount());
    if (parsed.ec != std::errc() || index == 0 || index < -count || index > kIndexLimit) {
      text_.fail("vertex index " + quoted(word) + " is out of range; there are " +
                 std::to_string(count) + " vertices up to here, the first is 1");
    }
    if (index < 0) return static_cast<std::uint32_t>(count + index);
    if (index > farthest_index_) {
      farthest_index_ = index;
      farthest_line_ = text_.line();
    }
    return static_cast<std::uint32_t>(index - 1);
  }

  MeshText text_;
  TriangleMesh mesh_;
  PolygonList polygons_{&mesh_.triangles};
  // A face may come before its vertices, so the largest index is checked at the end.
  std::int64_t farthest_index_ = 0;
  std::size_t farthest_line_ = 0;
  MeshGroups* groups_;
  std::vector<MeshGroups::Group*> groups_here_, objects_here_;  // only those that were asked for
};

}  // namespace

TriangleMesh readObj(const std::string& path, std::string_view content, MeshFileReport* report,
                     MeshGroups* groups) {
  return ObjReader(path, content, groups).read(report);
}

}  // namespace deformable_contact_monitor
