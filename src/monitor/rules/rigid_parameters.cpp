// Reads objects of type `rigid`: their frame, and their mesh file or primitive.
#include "monitor/rules/rigid_parameters.h"

#include <array>
#include <cmath>
#include <exception>
#include <optional>
#include <stdexcept>

#include "robot/link_mesh_files.h"
#include "robot/primitives.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {
namespace {

// The range of a primitive's sizes [m].
constexpr double kLeastSizeM = 1e-6, kMostSizeM = 1000;

// Adds a problem for each key that only objects with messages have.
void refuseKeysOfMessages(ParameterReader* entry) {
  for (const char* const key : {"topic", "required", "stamp_offset_s", "frame_id", "faces", "cells",
                                "marker", "max_depth_jump", "min_seen"}) {
    if (entry->has(key)) {
      entry->addProblem(key, "is not supported with type rigid, which has no messages");
    }
  }
  if (!entry->has("parts")) return;
  entry->addProblem("parts",
                    "are not supported with type rigid; make each part an object of its own, in "
                    "the same frame");
}

// Reads a length of a primitive, which has no default.
double lengthOf(ParameterReader* section, const char* name) {
  if (!section->has(name)) section->addProblem(name, "is missing");
  return section->number(name, kLeastSizeM, kLeastSizeM, kMostSizeM);
}

SourceMesh readBoxSize(ParameterReader* entry) {
  const std::array<double, 3> size = entry->point("box").value_or(std::array<double, 3>{1, 1, 1});
  for (const double length_m : size) {
    if (length_m >= kLeastSizeM && length_m <= kMostSizeM) continue;
    throw std::invalid_argument(
        "must be three lengths in [1e-06, 1000] m, such as [1.2, 0.8, 0.04]");
  }
  return makeBox({size[0], size[1], size[2]});
}

// Reads the map of a cylinder or a sphere.
SourceMesh readRound(const std::string& key, ParameterReader* entry,
                     std::vector<std::string>* warnings) {
  std::optional<ParameterReader> section = entry->section(key);
  if (!section) return makeSphere(1);  // a problem was added
  const double radius_m = lengthOf(&*section, "radius");
  const double length_m = key == "cylinder" ? lengthOf(&*section, "length") : 0;
  section->warnOfUnknown(warnings);
  return key == "cylinder" ? makeCylinder(radius_m, length_m) : makeSphere(radius_m);
}

SourceMesh readFile(ParameterReader* entry) {
  const std::string uri = entry->text("mesh", "");
  if (uri.empty()) return makeSphere(1);  // a problem was added
  try {
    return readLinkMeshFile(makeRosResolver()(uri));
  } catch (const std::exception& error) {
    throw std::runtime_error("is '" + uri + "': " + error.what());
  }
}

// Applies the scale and rounds vertices, as for links. Throws std::runtime_error if a vertex is not
// finite then.
TriangleMesh toMesh(const SourceMesh& source, double scale) {
  LinkMeshBuilder builder;
  builder.append(source, Eigen::Affine3d(Eigen::Scaling(scale)));
  std::size_t bad = 0;
  for (std::size_t i = 0; i + 2 < builder.mesh().vertices.size(); i += 3) {
    const float* const v = &builder.mesh().vertices[i];
    bad += !std::isfinite(v[0]) || !std::isfinite(v[1]) || !std::isfinite(v[2]);
  }
  if (bad > 0)
    throw std::runtime_error("has " + std::to_string(bad) + " vertices that are not finite");
  return builder.mesh();
}

// A wrong unit is the usual reason for a size like that.
void warnOfFile(const RigidParameters& rigid, const std::string& note,
                std::vector<std::string>* warnings) {
  constexpr double kLargestM = 10, kSmallestM = 1e-3;
  const std::string object = "rigid object '" + rigid.name + "': ";
  const double length_m = linkLengthM({"", "", *rigid.mesh, ""});
  if (length_m > kLargestM || length_m < kSmallestM) {
    warnings->push_back(object + std::to_string(length_m) +
                        " m long; if its file is in millimetres, set scale: 0.001");
  }
  if (!note.empty()) warnings->push_back(object + note);
}

}  // namespace

void readRigid(ParameterReader* entry, std::vector<std::string>* warnings, RigidParameters* rigid) {
  refuseKeysOfMessages(entry);
  rigid->frame = entry->text("frame", "");
  if (rigid->frame.empty()) {
    entry->addProblem("frame", "is missing: type rigid needs the TF frame that poses it");
  }
  entry->refuseSlash("frame", rigid->frame);
  std::vector<std::string> shapes;
  for (const char* const shape : {"mesh", "box", "cylinder", "sphere"}) {
    if (entry->has(shape)) shapes.emplace_back(shape);
  }
  const bool has_scale = entry->has("scale");
  const double scale = entry->number("scale", 1, 1e-6, 1e6);
  if (shapes.size() != 1) {
    return entry->addProblem("mesh, box, cylinder and sphere",
                             "are the shapes of type rigid: give one");
  }
  const std::string& shape = shapes.front();
  if (has_scale && shape != "mesh") {
    entry->addProblem("scale", "is not supported with a " + shape + ", whose sizes are in metres");
  }
  try {
    const SourceMesh source = shape == "mesh"  ? readFile(entry)
                              : shape == "box" ? readBoxSize(entry)
                                               : readRound(shape, entry, warnings);
    rigid->mesh = std::make_shared<const TriangleMesh>(toMesh(source, scale));
    if (shape == "mesh") warnOfFile(*rigid, source.note, warnings);
  } catch (const std::exception& error) {
    entry->addProblem(shape, error.what());
  }
}

}  // namespace deformable_contact_monitor
