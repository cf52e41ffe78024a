// Loads the geometry of a robot's links: reads the URDF, then all mesh files, then builds one mesh
// for each link. The mesh files are read together, before any link is built, because reading them
// takes the most time and can be done in parallel. Files of links that are left out are not read.
#include "robot/robot_geometry.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "robot/link_mesh_files.h"
#include "robot/nearest_name.h"
#include "robot/primitives.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {
namespace {

// Builds the mesh of one link from its elements. An element that fails is named in the problem.
class GeometryLoader {
 public:
  GeometryLoader(const LinkMeshFiles& files, const std::function<bool()>& stop)
      : files_(files), stop_(stop) {}

  LinkGeometry load(const UrdfLink& link) {
    LinkGeometry geometry;
    geometry.link = link.name;
    geometry.problem = link.problem;
    LinkMeshBuilder builder;
    for (const UrdfElement& element : link.elements) {
      if (stop_ && stop_()) throw ReadingStopped();
      const std::string name = describe(*element.geometry);
      geometry.source += (geometry.source.empty() ? "" : "; ") + name;
      try {
        append(element, builder, &geometry.notes);
      } catch (const std::exception& e) {
        geometry.problem += (geometry.problem.empty() ? "" : "; ") + name + ": " + e.what();
      }
    }
    if (geometry.problem.empty()) {
      geometry.mesh = builder.mesh();
    } else {
      geometry.problem = "link '" + link.name + "': " + geometry.problem;
    }
    return geometry;
  }

 private:
  // Returns the file or the primitive in words, for messages and LinkGeometry::source.
  static std::string describe(const urdf::Geometry& geometry) {
    std::ostringstream text;
    if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      text << (mesh->filename.empty() ? "mesh without a file name" : mesh->filename);
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      text << "box " << box->dim.x << " x " << box->dim.y << " x " << box->dim.z << " m";
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      text << "cylinder of radius " << cylinder->radius << " m, length " << cylinder->length
           << " m";
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      text << "sphere of radius " << sphere->radius << " m";
    }
    return text.str();
  }

  // Adds the triangles of one element. A mesh is scaled in its own frame first, and then placed at
  // the element's origin. A negative scale is allowed; it mirrors the mesh.
  void append(const UrdfElement& element, LinkMeshBuilder& builder,
              std::vector<std::string>* notes) {
    if (!element.origin.matrix().allFinite()) {
      throw std::invalid_argument("its origin is not finite");
    }
    const urdf::Geometry& geometry = *element.geometry;
    if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) {
      const Eigen::Vector3d scale(mesh->scale.x, mesh->scale.y, mesh->scale.z);
      if (!scale.allFinite() || (scale.array() == 0).any()) {
        std::ostringstream text;
        text << "its scale is " << scale.transpose() << ", but must be finite and nowhere zero";
        throw std::invalid_argument(text.str());
      }
      const SourceMesh& source = files_.mesh(mesh->filename);
      builder.append(source, element.origin * Eigen::Scaling(scale));
      if (!source.note.empty()) notes->push_back(mesh->filename + ": " + source.note);
    } else if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
      builder.append(makeBox({box->dim.x, box->dim.y, box->dim.z}), element.origin);
    } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
      builder.append(makeCylinder(cylinder->radius, cylinder->length), element.origin);
    } else if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
      builder.append(makeSphere(sphere->radius), element.origin);
    } else {
      throw std::invalid_argument("unknown geometry");
    }
  }

  const LinkMeshFiles& files_;
  const std::function<bool()>& stop_;
};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Throws std::invalid_argument if an option names links that the robot lacks, with similar names.
void requireLinks(const std::vector<std::string>& names, const char* option,
                  const UrdfDocument& document) {
  std::vector<std::string> links;
  for (const UrdfLink& link : document.links) links.push_back(link.name);
  std::string unknown;
  for (const std::string& name : names) {
    if (contains(links, name)) continue;
    unknown += (unknown.empty() ? "'" : ", '") + name + "'" + nearestNameHint(name, links);
  }
  if (!unknown.empty()) {
    throw std::invalid_argument(std::string(option) + ": " + unknown + ": no such link in robot '" +
                                document.name + "'");
  }
}

// Returns the URIs of all mesh files of these links. A URI may be there several times.
std::vector<std::string> meshUris(const std::vector<const UrdfLink*>& links) {
  std::vector<std::string> uris;
  for (const UrdfLink* link : links) {
    for (const UrdfElement& element : link->elements) {
      const auto* mesh = dynamic_cast<const urdf::Mesh*>(element.geometry.get());
      if (mesh != nullptr) uris.push_back(mesh->filename);
    }
  }
  return uris;
}

}  // namespace

RobotGeometry loadRobotGeometry(const std::string& urdf_xml, const RobotGeometryOptions& options,
                                const ResourceResolver& resolve, const MeshReading& reading) {
  const UrdfDocument document = readUrdf(urdf_xml, options.kind);
  requireLinks(options.links, "links", document);
  requireLinks(options.ignored_links, "ignored_links", document);

  RobotGeometry robot;
  robot.name = document.name;
  robot.root_link = document.root_link;
  robot.kind = options.kind;
  std::vector<const UrdfLink*> links;
  for (const UrdfLink& link : document.links) {
    robot.link_names.insert(link.name);
    const bool wanted = options.links.empty() || contains(options.links, link.name);
    if (!wanted || contains(options.ignored_links, link.name)) continue;
    if (!link.elements.empty() || !link.problem.empty()) {
      links.push_back(&link);
    } else if (link.has_others) {
      robot.unmonitored_links.push_back(link.name);
    }
  }
  const LinkMeshFiles files(meshUris(links), resolve, reading);
  GeometryLoader loader(files, reading.stop);
  for (const UrdfLink* link : links) robot.links.push_back(loader.load(*link));
  return robot;
}

}  // namespace deformable_contact_monitor
