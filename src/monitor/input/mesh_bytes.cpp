// Whether the bytes of a message are one, looked at before memory is taken for what they claim.
#include "monitor/input/mesh_bytes.h"

#include <cstring>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kWord = sizeof(std::uint32_t);
constexpr std::size_t kPointBytes = 3 * sizeof(double);
constexpr std::size_t kColorBytes = 4 * sizeof(float);
constexpr std::size_t kLeastFieldBytes = 3 * kWord + 1;  // of a PointField, which has a name

// Walks over serialized fields: little endian, an array after its length.
class FieldWalk {
 public:
  FieldWalk(const std::uint8_t* bytes, std::size_t size) : next_(bytes), left_(size) {}

  std::uint32_t word(const char* field) {
    std::uint32_t value = 0;
    if (left_ < kWord) return fail(std::string("the message ends before ") + field);
    std::memcpy(&value, next_, kWord);
    skip(kWord);
    return value;
  }

  void skipBytes(const char* field, std::size_t bytes) {
    if (bytes > left_) {
      fail(std::string("the message ends within ") + field);
      return;
    }
    skip(bytes);
  }

  void array(const char* field, std::size_t item_bytes) {
    const std::uint64_t items = count(field, item_bytes);
    skip(items * item_bytes);
  }

  // Of items that have at least so many bytes each, and stand where the walk goes on; 0 where so
  // many cannot be there.
  std::uint32_t count(const char* field, std::size_t least_bytes) {
    const std::uint64_t items = word(field);
    if (items * least_bytes <= left_) return static_cast<std::uint32_t>(items);
    return fail(std::string(field) + " claims " + std::to_string(items * least_bytes) +
                " bytes, but " + std::to_string(left_) + " are there");
  }

  void header() {
    word("header.seq");
    word("header.stamp");
    word("header.stamp");
    array("header.frame_id", 1);
  }

  std::size_t left() const { return left_; }
  const std::string& problem() const { return problem_; }  // the first

 private:
  void skip(std::size_t bytes) {
    next_ += bytes;
    left_ -= bytes;
  }

  std::uint32_t fail(const std::string& problem) {
    if (problem_.empty()) problem_ = problem;
    left_ = 0;
    return 0;
  }

  const std::uint8_t* next_;
  std::size_t left_;
  std::string problem_;
};

void walkOver(const DeformableMesh* /*type*/, FieldWalk* walk) {
  walk->header();
  walk->array("object", 1);
  walk->word("topology_id");
  walk->array("vertices", kWord);
  walk->array("triangles", kWord);
}

void walkOver(const shape_msgs::Mesh* /*type*/, FieldWalk* walk) {
  walk->array("triangles", 3 * kWord);
  walk->array("vertices", kPointBytes);
}

void walkOver(const visualization_msgs::Marker* /*type*/, FieldWalk* walk) {
  walk->header();
  walk->array("ns", 1);
  walk->skipBytes("id, type and action", 3 * kWord);
  walk->skipBytes("pose", 7 * sizeof(double));
  walk->skipBytes("scale", kPointBytes);
  walk->skipBytes("color", kColorBytes);
  walk->skipBytes("lifetime and frame_locked", 2 * kWord + 1);
  walk->array("points", kPointBytes);
  walk->array("colors", kColorBytes);
  walk->array("text", 1);
  walk->array("mesh_resource", 1);
  walk->skipBytes("mesh_use_embedded_materials", 1);
}

void walkOver(const sensor_msgs::PointCloud2* /*type*/, FieldWalk* walk) {
  walk->header();
  walk->skipBytes("height and width", 2 * kWord);
  for (std::uint32_t left = walk->count("fields", kLeastFieldBytes); left > 0; --left) {
    walk->array("fields.name", 1);
    walk->skipBytes("fields", kLeastFieldBytes - kWord);
  }
  walk->skipBytes("is_bigendian, point_step and row_step", 1 + 2 * kWord);
  walk->array("data", 1);
  walk->skipBytes("is_dense", 1);
}

}  // namespace

std::string whyTooLarge(std::uint64_t bytes, std::size_t max_bytes) {
  if (bytes <= max_bytes) return "";
  return "the mesh has " + std::to_string(bytes) + " bytes, more than max_mesh_mib allows";
}

std::uint64_t byteCount(const DeformableMesh& message) {
  return std::uint64_t{message.header.frame_id.size()} + message.object.size() +
         kWord * (std::uint64_t{message.vertices.size()} + message.triangles.size());
}

std::uint64_t byteCount(const shape_msgs::Mesh& message) {
  return 3 * kWord * std::uint64_t{message.triangles.size()} +
         kPointBytes * std::uint64_t{message.vertices.size()};
}

std::uint64_t byteCount(const visualization_msgs::Marker& message) {
  return kPointBytes * std::uint64_t{message.points.size()} +
         kColorBytes * std::uint64_t{message.colors.size()} + message.header.frame_id.size() +
         message.ns.size() + message.text.size() + message.mesh_resource.size();
}

std::uint64_t byteCount(const sensor_msgs::PointCloud2& message) {
  return message.header.frame_id.size() + kLeastFieldBytes * std::uint64_t{message.fields.size()} +
         message.data.size();
}

ros::Time stampIn(const std::uint8_t* bytes, std::size_t size) {
  FieldWalk walk(bytes, size);
  walk.word("header.seq");
  const std::uint32_t sec = walk.word("header.stamp");
  const std::uint32_t nsec = walk.word("header.stamp");
  ros::Time stamp;
  if (walk.problem().empty() && nsec < 1000000000) stamp = ros::Time(sec, nsec);
  return stamp;
}

template <typename M>
std::string whyNoMesh(const std::uint8_t* bytes, std::size_t size, std::size_t max_bytes) {
  FieldWalk walk(bytes, size);
  walkOver(static_cast<const M*>(nullptr), &walk);
  if (!walk.problem().empty()) return walk.problem();
  if (walk.left() > 0) return std::to_string(walk.left()) + " bytes follow the mesh";
  return whyTooLarge(size, max_bytes);
}

template std::string whyNoMesh<DeformableMesh>(const std::uint8_t*, std::size_t, std::size_t);
template std::string whyNoMesh<shape_msgs::Mesh>(const std::uint8_t*, std::size_t, std::size_t);
template std::string whyNoMesh<visualization_msgs::Marker>(const std::uint8_t*, std::size_t,
                                                           std::size_t);
template std::string whyNoMesh<sensor_msgs::PointCloud2>(const std::uint8_t*, std::size_t,
                                                         std::size_t);

}  // namespace deformable_contact_monitor
