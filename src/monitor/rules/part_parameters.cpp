// Reads the parameter `parts` of objects.
#include "monitor/rules/part_parameters.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>

#include "monitor/cycle_report.h"
#include "robot/link_mesh_files.h"

namespace deformable_contact_monitor {
namespace {

using Range = TriangleRanges::value_type;

// The groups that parts are, by mesh file.
struct WantedGroup {
  std::size_t part;  // its place in the list of parts
  std::string name;
};
using WantedGroups = std::map<std::string, std::vector<WantedGroup>>;

constexpr std::size_t kMostNamedParts = 255;  // what PartId can number beside the body's own rest
constexpr int kLastTriangle = std::numeric_limits<int>::max();

// Sorts ranges, and joins those that overlap or follow each other.
std::vector<Range> joined(std::vector<Range> ranges) {
  std::sort(ranges.begin(), ranges.end());
  std::vector<Range> all;
  for (const Range& range : ranges) {
    if (all.empty() || range.first > all.back().second + 1U) {
      all.push_back(range);
    } else {
      all.back().second = std::max(all.back().second, range.second);
    }
  }
  return all;
}

// Reads triangle indices, one per line. Throws std::runtime_error with the line.
std::vector<Range> readIndices(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error("the file cannot be read");
  std::vector<Range> indices;
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    const bool is_number = line.size() <= 10 && line.find_first_not_of("0123456789") == line.npos;
    const std::uint64_t index = is_number ? std::stoull(line) : 0;
    if (!is_number || index > kLastTriangle) {
      throw std::runtime_error("line " + std::to_string(number) + " is '" + line.substr(0, 40) +
                               "', must be the index of a triangle");
    }
    indices.emplace_back(index, index);
  }
  if (indices.empty()) throw std::runtime_error("the file has no triangle");
  return joined(std::move(indices));
}

// Returns why a part cannot have this name; empty if it can.
std::string nameProblem(const std::string& name) {
  if (name.empty()) return "is missing";
  if (name == kHeldPart)
    return "is 'held', which is the part that ~attach_object with a radius holds";
  if (name.find_first_of(":*") == std::string::npos) return "";
  return "is '" + name + "', must have no ':' and no '*'";
}

std::optional<PartBox> readBox(ParameterReader* entry, std::vector<std::string>* warnings) {
  std::optional<ParameterReader> section = entry->section("box");
  if (!section) return std::nullopt;
  const auto min = section->point("min"), max = section->point("max");
  section->warnOfUnknown(warnings);
  if (!min || !max) return std::nullopt;
  for (std::size_t i = 0; i < min->size(); ++i) {
    if ((*min)[i] > (*max)[i])
      section->addProblem("min", "is above max in axis " + std::string(1, "xyz"[i]));
  }
  return PartBox{*min, *max};
}

// Reads which group of which file a part is. The file is that of the object's faces if the part
// names no other one.
void readGroup(ParameterReader* entry, const std::string& faces, std::size_t part,
               WantedGroups* groups) {
  const std::string name = entry->text("group", ""), file = entry->text("group_file", faces);
  if (name.empty()) return;
  if (file.empty()) {
    entry->addProblem("group_file",
                      "is missing: it names the mesh file that has the group '" + name + "'");
    return;
  }
  (*groups)[file].push_back({part, name});
}

// Reads each mesh file once, and gives parts the triangles of their groups.
void readGroups(const WantedGroups& groups, ParameterReader* object,
                std::vector<PartParameters>* parts) {
  for (const auto& [file, wanted] : groups) {
    std::vector<std::string> names;
    for (const WantedGroup& group : wanted) names.push_back(group.name);
    try {
      std::vector<TriangleRanges> ranges;
      const auto mesh = std::make_shared<const TriangleMesh>(
          readMeshGroups(makeRosResolver()(file), names, &ranges));
      for (std::size_t i = 0; i < wanted.size(); ++i) {
        PartParameters& part = (*parts)[wanted[i].part];
        part.ranges = std::move(ranges[i]);
        part.mesh = mesh;
      }
    } catch (const std::exception& error) {
      object->addProblem("parts", "cannot be groups of '" + file + "': " + error.what());
    }
  }
}

// Reads what the part is made of, which must be exactly one of the choices, but for groups.
void readTriangles(ParameterReader* entry, std::vector<std::string>* warnings,
                   PartParameters* part) {
  const bool has_ranges = entry->has("triangles"), has_file = entry->has("indices_file");
  const bool has_box = entry->has("box"), has_group = entry->has("group");
  if (has_ranges + has_file + has_box + has_group != 1) {
    entry->addProblem("triangles, indices_file, box and group",
                      "are the ways to make a part: give one");
    return;
  }
  part->box = readBox(entry, warnings);
  for (const auto& [first, last] : entry->ranges("triangles", 0, kLastTriangle)) {
    part->ranges.emplace_back(first, last);
  }
  part->ranges = joined(std::move(part->ranges));
  if (has_ranges && part->ranges.empty()) entry->addProblem("triangles", "has no range");
  const std::string path = has_file ? entry->text("indices_file", "") : "";
  if (path.empty()) return;
  try {
    part->ranges = readIndices(makeRosResolver()(path));
  } catch (const std::exception& error) {
    entry->addProblem("indices_file", "is '" + path + "': " + error.what());
  }
}

// Adds a problem for the first triangle that two parts share.
void checkOverlaps(const std::vector<PartParameters>& parts, ParameterReader* object) {
  std::vector<std::pair<Range, const PartParameters*>> all;
  for (const PartParameters& part : parts) {
    for (const Range& range : part.ranges) all.emplace_back(range, &part);
  }
  std::sort(all.begin(), all.end());
  for (std::size_t i = 1; i < all.size(); ++i) {
    const auto& [before, part] = all[i - 1];
    const auto& [range, other] = all[i];
    if (range.first > before.second) continue;
    object->addProblem("parts", "'" + part->name + "' and '" + other->name +
                                    "' both have triangle " + std::to_string(range.first));
    return;
  }
}

}  // namespace

std::vector<PartParameters> readParts(ParameterReader* object, const std::string& object_name,
                                      const std::string& faces,
                                      std::vector<std::string>* warnings) {
  std::vector<PartParameters> parts;
  WantedGroups groups;
  std::set<std::string> names;
  for (ParameterReader& entry : object->structs("parts")) {
    PartParameters part;
    part.name = entry.text("name", "");
    const std::string problem = nameProblem(part.name);
    if (!problem.empty()) {
      entry.addProblem("name", problem);
    } else if (!names.insert(part.name).second) {
      entry.addProblem("name", "is '" + part.name + "', which is another part's name");
    }
    readTriangles(&entry, warnings, &part);
    if (entry.has("group")) readGroup(&entry, faces, parts.size(), &groups);
    if (entry.has("margin_m")) {
      part.margin_m = static_cast<float>(entry.number("margin_m", 0, 0, kMaxMarginM));
    }
    entry.warnOfUnknown(warnings);
    parts.push_back(std::move(part));
  }
  if (parts.size() > kMostNamedParts) {
    object->addProblem("parts", "are " + std::to_string(parts.size()) + ", must be at most 255");
  }
  if (!parts.empty() && object_name.find_first_of(":*") != std::string::npos) {
    object->addProblem("name", "is '" + object_name +
                                   "', must have no ':' and no '*', because the object has parts");
  }
  readGroups(groups, object, &parts);
  checkOverlaps(parts, object);
  return parts;
}

}  // namespace deformable_contact_monitor
