// Finds the part of an object that a robot holds: the triangles near the holding links.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/incoming_mesh.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Returns the triangles of a body that are at most `radius_m` > 0 from some triangle of another
// body of the scene, or from its surface if that body has a radius, ascending. That is the distance
// in a straight line, and exactly what a detector lists as touching or near for a margin of
// `radius_m`: triangles that intersect, and those whose distance, rounded to float32, is at most
// that much. Triangles with a vertex that is not finite are near to nothing.
std::vector<std::uint32_t> trianglesWithin(const Scene& scene, BodyId body, float radius_m);

// What ~attach_object with a radius asks about.
struct HoldQuestion {
  std::string object;
  const IncomingMesh& mesh;               // the object's newest one
  const std::vector<std::string>& links;  // of the robot, or rigid objects; not empty
  float radius_m;
  AttachedObjects attached{};  // the rigid objects that links carry now
};

// Returns why such a hold is not possible whatever the meshes and transforms are; empty: it is. The
// object must be one of the parameters'.
std::string holdProblem(const std::string& object, float radius_m,
                        const MonitorParameters& parameters);

// Returns the frames whose poses findHeldPart() needs, at the mesh's stamp.
std::vector<FrameAtStamp> framesOfHold(const HoldQuestion& question,
                                       const MonitorParameters& parameters);

// Returns the triangles of the mesh within the radius of the holding links and rigid objects, all
// posed at the mesh's stamp. Links without geometry hold nothing. Throws std::invalid_argument,
// naming the body, if no triangle is that near, if no link has geometry, or if a pose or the mesh
// of a link is not known.
std::shared_ptr<const HeldPart> findHeldPart(const HoldQuestion& question,
                                             const RobotGeometry& robot,
                                             const MonitorParameters& parameters,
                                             const TransformLookup& lookup);

}  // namespace deformable_contact_monitor
