// A line of the file is `part BODY NAME RANGE...`, `group BODY NAME GROUP...` or `skip PART PART`.
// Names get the numbers 1, 2, ... of their body in the order in which they come.
#include "tools/detect_contacts/parts_file.h"

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr const char* kRest = "rest";  // the triangles of no named part

// Reads one file, line by line.
class PartsReader {
 public:
  PartsReader(std::string path, Scene* scene)
      : path_(std::move(path)), scene_(*scene), bodies_(scene->bodyCount()) {}

  void read() {
    std::ifstream file(path_);
    if (!file) throw std::runtime_error(path_ + ": cannot be opened");
    std::string text;
    while (std::getline(file, text)) {
      ++line_;
      std::istringstream words(text.substr(0, text.find('#')));
      std::string what;
      if (!(words >> what)) continue;
      if (what == "part") {
        addPart(words);
      } else if (what == "group") {
        addGroups(words);
      } else if (what == "skip") {
        addSkipped(words);
      } else {
        refuse("'" + what + "' is neither part, group nor skip");
      }
    }
    if (file.bad()) throw std::runtime_error(path_ + ": cannot be read");
    for (BodyId id = 0; id < bodies_.size(); ++id) {
      if (!bodies_[id].names.empty()) scene_.setParts(id, bodies_[id].parts);
    }
  }

 private:
  struct NamedParts {
    std::map<std::string, PartId> names;
    std::vector<PartId> parts;
  };

  [[noreturn]] void refuse(const std::string& what) const {
    throw std::runtime_error(path_ + " line " + std::to_string(line_) + ": " + what);
  }

  // Reads a number of digits alone, below `end`.
  std::uint32_t number(const std::string& text, std::size_t end, const std::string& of_what) const {
    std::uint32_t value = 0;
    const char* const last = text.data() + text.size();
    const auto parsed = std::from_chars(text.data(), last, value);
    if (parsed.ec != std::errc() || parsed.ptr != last) {
      refuse("'" + text + "' is no number of a " + of_what);
    }
    if (value >= end) {
      refuse(of_what + " " + text + " does not exist; there are " + std::to_string(end));
    }
    return value;
  }

  // Returns the part of that name, which is a new one if no line before has it.
  PartId partOf(BodyId id, const std::string& name) {
    if (name == kRest || name.find(':') != std::string::npos) {
      refuse("'" + name + "' cannot be the name of a part");
    }
    NamedParts& own = bodies_[id];
    own.parts.resize(scene_.body(id).mesh.triangleCount());
    constexpr std::size_t kMost = 255;
    const bool is_new = own.names.count(name) == 0;
    if (is_new && own.names.size() == kMost) {
      refuse("body " + std::to_string(id) + " has 255 parts already");
    }
    const auto next = static_cast<PartId>(own.names.size() + 1);
    return own.names.emplace(name, next).first->second;
  }

  // Gives the triangles from `first` to `last` to a part of a body.
  void add(BodyId id, PartId part, std::uint32_t first, std::uint32_t last) {
    std::vector<PartId>& parts = bodies_[id].parts;
    for (std::uint32_t t = first; t <= last; ++t) {
      if (parts[t] != 0 && parts[t] != part) {
        refuse("triangle " + std::to_string(t) + " of body " + std::to_string(id) +
               " has another part already");
      }
      parts[t] = part;
    }
  }

  // Reads the rest of a line `part BODY NAME RANGE...`; a range is a triangle, or FIRST-LAST.
  void addPart(std::istringstream& words) {
    std::string body, name, range;
    if (!(words >> body >> name >> range)) refuse("part needs a body, a name and triangles");
    const BodyId id = number(body, bodies_.size(), "body");
    const PartId part = partOf(id, name);
    const std::size_t count = bodies_[id].parts.size();
    do {
      const std::size_t dash = range.find('-');
      const std::uint32_t first = number(range.substr(0, dash), count, "triangle");
      const std::uint32_t last =
          dash == std::string::npos ? first : number(range.substr(dash + 1), count, "triangle");
      if (last < first) refuse("'" + range + "' ends before it begins");
      add(id, part, first, last);
    } while (words >> range);
  }

  // Reads the rest of a line `group BODY NAME GROUP...`. A body has the name of its file.
  void addGroups(std::istringstream& words) {
    std::string body, name;
    if (!(words >> body >> name)) refuse("group needs a body, a name and groups of its file");
    const BodyId id = number(body, bodies_.size(), "body");
    const PartId part = partOf(id, name);
    std::vector<std::string> groups;
    for (std::string group; words >> group;) groups.push_back(group);
    if (groups.empty()) refuse("group needs a body, a name and groups of its file");
    std::vector<TriangleRanges> triangles;
    try {
      const TriangleMesh mesh = readMeshGroups(scene_.body(id).name, groups, &triangles);
      if (mesh.triangles != scene_.body(id).mesh.triangles) refuse("the mesh file has changed");
    } catch (const std::runtime_error& error) {
      refuse(error.what());
    }
    for (const TriangleRanges& ranges : triangles) {
      for (const auto& [first, last] : ranges) add(id, part, first, last);
    }
  }

  // Reads BODY, for all of its parts, or BODY:NAME. Names must come before they are used.
  std::pair<BodyId, std::vector<PartId>> partsOf(const std::string& text) const {
    const std::size_t colon = text.find(':');
    const BodyId id = number(text.substr(0, colon), bodies_.size(), "body");
    std::vector<PartId> parts;
    if (colon == std::string::npos) {
      for (std::size_t part = 0; part <= bodies_[id].names.size(); ++part) {
        parts.push_back(static_cast<PartId>(part));
      }
    } else if (text.substr(colon + 1) == kRest) {
      parts.push_back(0);
    } else {
      const auto found = bodies_[id].names.find(text.substr(colon + 1));
      if (found == bodies_[id].names.end()) refuse("no line before says what '" + text + "' is");
      parts.push_back(found->second);
    }
    return {id, parts};
  }

  // Reads the rest of a line `skip PART PART`.
  void addSkipped(std::istringstream& words) {
    std::string one, other, more;
    if (!(words >> one >> other) || words >> more) refuse("skip needs two bodies or parts");
    const auto [a, of_a] = partsOf(one);
    const auto [b, of_b] = partsOf(other);
    for (const PartId part_a : of_a) {
      for (const PartId part_b : of_b) scene_.setPartPairEnabled(a, part_a, b, part_b, false);
    }
  }

  const std::string path_;
  Scene& scene_;
  std::vector<NamedParts> bodies_;
  int line_ = 0;
};

}  // namespace

void readParts(const std::string& path, Scene* scene) { PartsReader(path, scene).read(); }

}  // namespace deformable_contact_monitor
