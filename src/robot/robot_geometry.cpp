// Loads the geometry of a robot's links: reads the URDF, then all mesh files, then builds one mesh
// for each link. The mesh files are read together, before any link is built, because reading them
// takes the most time and can be done in parallel. Files of links that are left out are not read.
#include "robot/robot_geometry.h"

#include <boost/algorithm/cxx11/any_of.hpp>
#include <map>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "robot/joint_problems.h"
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

// Reads a robot's description and gives its links and joints their prefix.
UrdfDocument readDescription(const RobotDescription& robot, GeometryKind kind) {
  UrdfDocument document;
  try {
    document = readUrdf(robot.urdf_xml, kind);
  } catch (const std::invalid_argument& error) {
    if (robot.source.empty()) throw;
    throw std::invalid_argument(robot.source + ": " + error.what());
  }
  document.root_link = robot.link_prefix + document.root_link;
  for (UrdfLink& link : document.links) link.name = robot.link_prefix + link.name;
  for (RobotJoint& joint : document.joints) {
    for (std::string* name : {&joint.name, &joint.parent, &joint.child}) {
      name->insert(0, robot.link_prefix);
    }
    if (!joint.mimics.empty()) joint.mimics.insert(0, robot.link_prefix);
  }
  findJointProblems(&document.joints);
  return document;
}

// Returns the robot in words: "'psm'", or with a prefix "'psm' with frame_prefix 'PSM1/'".
std::string nameOf(const UrdfDocument& document, const RobotDescription& robot) {
  return "'" + document.name + "'" +
         (robot.link_prefix.empty() ? "" : " with frame_prefix '" + robot.link_prefix + "'");
}

// Throws std::invalid_argument if two robots have a link of the same name.
void requireOwnNames(const std::vector<UrdfDocument>& documents,
                     const std::vector<RobotDescription>& robots) {
  std::map<std::string, std::size_t> robot_of;
  for (std::size_t i = 0; i < documents.size(); ++i) {
    for (const UrdfLink& link : documents[i].links) {
      const auto [other, is_new] = robot_of.emplace(link.name, i);
      if (is_new) continue;
      throw std::invalid_argument(
          "robots: '" + link.name + "' is a link of robots[" + std::to_string(other->second) +
          "], " + nameOf(documents[other->second], robots[other->second]) + ", and of robots[" +
          std::to_string(i) + "], " + nameOf(documents[i], robots[i]) +
          "; give each robot its own frame_prefix");
    }
  }
}

// Throws std::invalid_argument if an option names links that no robot has, with similar names.
void requireLinks(const std::vector<std::string>& names, const char* option,
                  const std::vector<UrdfDocument>& documents,
                  const std::vector<RobotDescription>& robots) {
  std::vector<std::string> links;
  std::string of;
  for (std::size_t i = 0; i < documents.size(); ++i) {
    for (const UrdfLink& link : documents[i].links) links.push_back(link.name);
    of += (of.empty() ? "" : ", ") + nameOf(documents[i], robots[i]);
  }
  std::string unknown;
  for (const std::string& name : names) {
    if (boost::algorithm::any_of_equal(links, name)) continue;
    unknown += (unknown.empty() ? "'" : ", '") + name + "'" + nearestNameHint(name, links);
  }
  if (unknown.empty()) return;
  const bool has_source = robots.size() == 1 && !robots.front().source.empty();
  throw std::invalid_argument((has_source ? robots.front().source + ": " : "") + option + ": " +
                              unknown + ": no such link in robot " + of);
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

bool DescribedRobot::operator==(const DescribedRobot& other) const {
  return name == other.name && links == other.links && srdf == other.srdf;
}

RobotGeometry loadRobots(const std::vector<RobotDescription>& robots,
                         const RobotGeometryOptions& options, const ResourceResolver& resolve,
                         const MeshReading& reading) {
  std::vector<UrdfDocument> documents;
  documents.reserve(robots.size());
  for (const RobotDescription& robot : robots) {
    documents.push_back(readDescription(robot, options.kind));
  }
  requireOwnNames(documents, robots);
  requireLinks(options.links, "links", documents, robots);
  requireLinks(options.ignored_links, "ignored_links", documents, robots);

  RobotGeometry all;
  all.root_link = documents.front().root_link;
  all.kind = options.kind;
  std::vector<const UrdfLink*> links;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    DescribedRobot robot{documents[i].name, {}, {}};
    for (const UrdfLink& link : documents[i].links) {
      robot.links.insert(link.name);
      const bool wanted =
          options.links.empty() || boost::algorithm::any_of_equal(options.links, link.name);
      if (!wanted || boost::algorithm::any_of_equal(options.ignored_links, link.name)) continue;
      if (!link.elements.empty() || !link.problem.empty()) {
        links.push_back(&link);
      } else if (link.has_others) {
        all.unmonitored_links.push_back(link.name);
      }
    }
    robot.srdf = prefixed(robots[i].srdf, robots[i].link_prefix, robot.links);
    all.link_names.insert(robot.links.begin(), robot.links.end());
    all.joints.insert(all.joints.end(), documents[i].joints.begin(), documents[i].joints.end());
    all.robots.push_back(std::move(robot));
  }
  const LinkMeshFiles files(meshUris(links), resolve, reading);
  GeometryLoader loader(files, reading.stop);
  for (const UrdfLink* link : links) all.links.push_back(loader.load(*link));
  return all;
}

RobotGeometry loadRobotGeometry(const std::string& urdf_xml, const RobotGeometryOptions& options,
                                const ResourceResolver& resolve, const MeshReading& reading) {
  return loadRobots({{urdf_xml, "", "", {}}}, options, resolve, reading);
}

}  // namespace deformable_contact_monitor
