// Checks the bytes of messages. Each walkOver() follows the definition of its message type, field
// by field.
#include "monitor/input/message_bytes.h"

#include "monitor/input/wire_walker.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kWord = sizeof(std::uint32_t);
constexpr std::size_t kPointBytes = 3 * sizeof(double);
constexpr std::size_t kPoseBytes = 7 * sizeof(double);
constexpr std::size_t kLeastStampedPoseBytes = 4 * kWord + kPoseBytes;  // with an empty frame
constexpr std::size_t kLeastTransformBytes = kLeastStampedPoseBytes + kWord;
constexpr std::size_t kColorBytes = 4 * sizeof(float);
constexpr std::size_t kLeastFieldBytes = 3 * kWord + 1;  // a PointField with an empty name

// A Marker whose arrays and strings are empty.
constexpr std::size_t kLeastMarkerBytes = 14 * kWord + 10 * sizeof(double) + kColorBytes + 2;

// The overloads walk over the fields of one message type each; the pointer only selects the type.
void walkOver(const DeformableMesh* /*type*/, WireWalker* walk) {
  walk->header();
  walk->array("object", 1);
  walk->word("topology_id");
  walk->array("vertices", kWord);
  walk->array("triangles", kWord);
}

void walkOver(const shape_msgs::Mesh* /*type*/, WireWalker* walk) {
  walk->array("triangles", 3 * kWord);
  walk->array("vertices", kPointBytes);
}

void walkOver(const visualization_msgs::Marker* /*type*/, WireWalker* walk) {
  walk->header();
  walk->array("ns", 1);
  walk->skip("id, type and action", 3 * kWord);
  walk->skip("pose", kPoseBytes);
  walk->skip("scale", kPointBytes);
  walk->skip("color", kColorBytes);
  walk->skip("lifetime and frame_locked", 2 * kWord + 1);
  walk->array("points", kPointBytes);
  walk->array("colors", kColorBytes);
  walk->array("text", 1);
  walk->array("mesh_resource", 1);
  walk->skip("mesh_use_embedded_materials", 1);
}

void walkOver(const visualization_msgs::MarkerArray* /*type*/, WireWalker* walk) {
  for (std::uint32_t left = walk->count("markers", kLeastMarkerBytes); left > 0; --left) {
    walkOver(static_cast<const visualization_msgs::Marker*>(nullptr), walk);
  }
}

void walkOver(const sensor_msgs::PointCloud2* /*type*/, WireWalker* walk) {
  walk->header();
  walk->skip("height and width", 2 * kWord);
  for (std::uint32_t left = walk->count("fields", kLeastFieldBytes); left > 0; --left) {
    walk->array("fields.name", 1);
    walk->skip("fields", kLeastFieldBytes - kWord);
  }
  walk->skip("is_bigendian, point_step and row_step", 1 + 2 * kWord);
  walk->array("data", 1);
  walk->skip("is_dense", 1);
}

void walkOver(const geometry_msgs::PoseArray* /*type*/, WireWalker* walk) {
  walk->header();
  walk->array("poses", kPoseBytes);
}

#ifdef DCM_HAS_NAV_MSGS
void walkOver(const nav_msgs::Path* /*type*/, WireWalker* walk) {
  walk->header();
  for (std::uint32_t left = walk->count("poses", kLeastStampedPoseBytes); left > 0; --left) {
    walk->header();
    walk->skip("poses.pose", kPoseBytes);
  }
}
#endif

#ifdef DCM_HAS_PCL_MSGS
void walkOver(const pcl_msgs::PolygonMesh* /*type*/, WireWalker* walk) {
  walk->header();
  walkOver(static_cast<const sensor_msgs::PointCloud2*>(nullptr), walk);
  const std::uint32_t polygons = walk->count("polygons", kWord);
  for (std::uint32_t i = 0; i < polygons && walk->problem().empty(); ++i) {
    // An empty polygon has 4 bytes here, and six times as many in memory.
    const std::uint32_t corners = walk->count("polygons.vertices", kWord);
    walk->skip("polygons.vertices", kWord * std::size_t{corners});
    if (corners >= 3 || !walk->problem().empty()) continue;
    walk->reject("polygon " + std::to_string(i) + " has " + std::to_string(corners) +
                 " vertices, must have at least 3");
  }
}
#endif

void walkOver(const LinkMeshes* /*type*/, WireWalker* walk) {
  walk->header();
  for (std::uint32_t left = walk->count("meshes", 4 * kWord); left > 0; --left) {
    walk->array("meshes.link", 1);
    walk->array("meshes.source", 1);
    walk->array("meshes.vertices", kWord);
    walk->array("meshes.triangles", kWord);
  }
}

void walkOver(const StatesToCheck* /*type*/, WireWalker* walk) {
  walk->skip("id", 2 * kWord);
  walk->texts("joint_names");
  walk->array("positions", sizeof(double));
  walk->texts("objects");
  walk->skip("margin, first_only and max_time", 3 * kWord + 1);
}

void walkOver(const tf2_msgs::TFMessage* /*type*/, WireWalker* walk) {
  for (std::uint32_t left = walk->count("transforms", kLeastTransformBytes); left > 0; --left) {
    walk->header();
    walk->array("transforms.child_frame_id", 1);
    walk->skip("transforms.transform", kPoseBytes);
  }
}

void walkOver(const std_msgs::String* /*type*/, WireWalker* walk) { walk->array("data", 1); }

void walkOver(const sensor_msgs::JointState* /*type*/, WireWalker* walk) {
  walk->header();
  walk->texts("name");
  for (const char* field : {"position", "velocity", "effort"}) walk->array(field, sizeof(double));
}

}  // namespace

// The limit is a parameter, so the text names it.
std::string meshSizeProblem(std::uint64_t bytes, std::size_t max_bytes) {
  if (bytes <= max_bytes) return "";
  return "the mesh has " + std::to_string(bytes) + " bytes, more than max_mesh_mib allows";
}

ros::Time stampIn(const std::uint8_t* bytes, std::size_t size) {
  WireWalker walk(bytes, size);
  walk.word("header.seq");
  const std::uint32_t sec = walk.word("header.stamp");
  const std::uint32_t nsec = walk.word("header.stamp");
  ros::Time stamp;
  if (walk.problem().empty() && nsec < 1000000000) stamp = ros::Time(sec, nsec);
  return stamp;
}

template <typename M>
std::string validateBytes(const std::uint8_t* bytes, std::size_t size) {
  WireWalker walk(bytes, size);
  walkOver(static_cast<const M*>(nullptr), &walk);
  if (!walk.problem().empty() || walk.left() == 0) return walk.problem();
  return std::to_string(walk.left()) + " bytes follow the message";
}

template std::string validateBytes<DeformableMesh>(const std::uint8_t*, std::size_t);
template std::string validateBytes<LinkMeshes>(const std::uint8_t*, std::size_t);
template std::string validateBytes<StatesToCheck>(const std::uint8_t*, std::size_t);
template std::string validateBytes<geometry_msgs::PoseArray>(const std::uint8_t*, std::size_t);
template std::string validateBytes<sensor_msgs::JointState>(const std::uint8_t*, std::size_t);
template std::string validateBytes<sensor_msgs::PointCloud2>(const std::uint8_t*, std::size_t);
template std::string validateBytes<shape_msgs::Mesh>(const std::uint8_t*, std::size_t);
template std::string validateBytes<std_msgs::String>(const std::uint8_t*, std::size_t);
template std::string validateBytes<tf2_msgs::TFMessage>(const std::uint8_t*, std::size_t);
template std::string validateBytes<visualization_msgs::Marker>(const std::uint8_t*, std::size_t);
template std::string validateBytes<visualization_msgs::MarkerArray>(const std::uint8_t*,
                                                                    std::size_t);
#ifdef DCM_HAS_NAV_MSGS
template std::string validateBytes<nav_msgs::Path>(const std::uint8_t*, std::size_t);
#endif
#ifdef DCM_HAS_PCL_MSGS
template std::string validateBytes<pcl_msgs::PolygonMesh>(const std::uint8_t*, std::size_t);
#endif

}  // namespace deformable_contact_monitor
