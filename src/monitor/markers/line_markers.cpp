// The lines of a cycle's markers: where triangles meet, and which way they part.
#include "monitor/markers/line_markers.h"

#include <map>
#include <utility>

#include "core/pair_geometry.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {

const char* const kSegments = "segments: ";
const char* const kNormals = "normals: ";

namespace {

using visualization_msgs::Marker;

struct Line {
  Vec3f from, to;
};

bool hasNormal(const PairGeometry& geometry) {
  const Vec3f& n = geometry.normal;
  return (geometry.flags & kNormalUndefined) == 0 && (n.x != 0 || n.y != 0 || n.z != 0);
}

Line segmentOf(const PairGeometry& geometry) { return {geometry.point_a, geometry.point_b}; }

Line normalOf(const PairGeometry& geometry) {
  const Vec3f &a = geometry.point_a, &b = geometry.point_b, &n = geometry.normal;
  const Vec3f middle{0.5F * a.x + 0.5F * b.x, 0.5F * a.y + 0.5F * b.y, 0.5F * a.z + 0.5F * b.z};
  return {middle,
          {middle.x + kNormalLengthM * n.x, middle.y + kNormalLengthM * n.y,
           middle.z + kNormalLengthM * n.z}};
}

// Of one kind, by pair of bodies.
class LineLists {
 public:
  LineLists(const CycleReport& report, const MarkerOptions& options, const char* kind,
            float width_m)
      : report_(report), options_(options), kind_(kind), width_m_(width_m) {}

  void add(const TrianglePair& pair, const Line& line, const std_msgs::ColorRGBA& from,
           const std_msgs::ColorRGBA& to) {
    if (!isFinite(line.from) || !isFinite(line.to)) return;  // rviz would refuse the marker
    auto& marker = lists_[{pair.body_a, pair.body_b}];
    marker.points.push_back(toPoint(line.from));
    marker.points.push_back(toPoint(line.to));
    marker.colors.push_back(from);
    marker.colors.push_back(to);
  }

  void moveTo(std::vector<Marker>* markers) {
    for (auto& [pair, lines] : lists_) {
      Marker marker = makeMarker(
          report_, options_, pairKey(report_, pair.first, pair.second, kind_), Marker::LINE_LIST);
      marker.scale.x = width_m_;
      marker.color = lines.colors.front();
      marker.points = std::move(lines.points);
      marker.colors = std::move(lines.colors);
      markers->push_back(std::move(marker));
    }
  }

 private:
  const CycleReport& report_;
  const MarkerOptions& options_;
  const char* const kind_;
  const float width_m_;
  std::map<std::pair<BodyId, BodyId>, Marker> lists_;
};

}  // namespace

void addLines(const CycleReport& report, const MarkerOptions& options,
              std::vector<Marker>* markers) {
  if (report.scene == nullptr || report.result == nullptr) return;
  const DetectionResult& result = *report.result;
  if (result.geometry.size() != result.contacts.size() || result.contacts.empty()) return;
  const std_msgs::ColorRGBA touching = makeColor(0, 0, 0, 1), near = makeColor(0.5F, 0.5F, 0.5F, 1);
  const std_msgs::ColorRGBA root = makeColor(0.3F, 0.9F, 0.3F, 1), tip = makeColor(0, 0.3F, 0, 1);
  LineLists segments(report, options, kSegments, 0.004F),
      normals(report, options, kNormals, 0.002F);
  const std::size_t stride =
      (result.contacts.size() + options.max_triangles - 1) / options.max_triangles;
  for (std::size_t i = 0; i < result.contacts.size(); i += stride) {
    const PairGeometry& geometry = result.geometry[i];
    const std_msgs::ColorRGBA& color = touches(result, i) ? touching : near;
    segments.add(result.contacts[i], segmentOf(geometry), color, color);
    if (hasNormal(geometry)) normals.add(result.contacts[i], normalOf(geometry), root, tip);
  }
  segments.moveTo(markers);
  normals.moveTo(markers);
}

}  // namespace deformable_contact_monitor
