// Robot descriptions, and the same text as an SRDF. The first byte chooses the kind of geometry,
// and whether the others are the text or what a mostly well-formed one is made of.
#include <stdexcept>
#include <string>

#include "core/triangle_mesh.h"
#include "fuzz_target.h"
#include "robot/robot_geometry.h"
#include "urdf_writer.h"

namespace deformable_contact_monitor {
namespace {

// Files are another target's affair (link_mesh).
std::string resolveNothing(const std::string& uri) {
  throw std::runtime_error("no such file: " + uri);
}

// Its root is called as a URDF's.
void trySrdf(const std::string& text) {
  try {
    srdfWarnings(readSrdf(text), "robot", {"link"});
  } catch (const std::invalid_argument& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
  }
}

// Past the first check: it is a robot, whatever its links are.
bool tryUrdf(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return false;
  RobotGeometryOptions options;
  options.kind = static_cast<GeometryKind>(data[0] % kGeometryKinds.size());
  constexpr std::uint8_t kMade = 128;
  ByteSource source(data + 1, size - 1);
  const std::string text = data[0] < kMade ? source.text(size) : urdfFrom(&source);
  trySrdf(text);
  try {
    const RobotGeometry robot = loadRobotGeometry(text, options, resolveNothing);
    for (const LinkGeometry& link : robot.links) {
      requireThat(!link.link.empty(), "a link without a name");
      validate(link.mesh, link.link);
      requireThat(link.problem.empty() != link.mesh.triangles.empty(),
                  "a link has a problem and a mesh, or neither");
    }
    geometryWarnings(robot);
    return true;
  } catch (const std::invalid_argument& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
    return false;
  }
}

const FuzzTargetEntry entry("urdf", tryUrdf);

}  // namespace
}  // namespace deformable_contact_monitor
