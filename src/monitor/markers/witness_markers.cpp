// Where two bodies are in contact of which no pair of triangles is listed.
#include "monitor/markers/witness_markers.h"

#include <optional>
#include <set>
#include <utility>

#include "monitor/state/pair_distance.h"

namespace deformable_contact_monitor {

const char* const kWitness = "witness: ";

namespace {

using visualization_msgs::Marker;

constexpr double kDiameterM = 0.01;

std::set<std::pair<BodyId, BodyId>> pairsWithTriangles(const DetectionResult& result) {
  std::set<std::pair<BodyId, BodyId>> pairs;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& c = result.contacts[i];
    if (touches(result, i)) pairs.insert({c.body_a, c.body_b});
  }
  return pairs;
}

}  // namespace

void addWitnesses(const CycleReport& report, const MarkerOptions& options,
                  std::vector<Marker>* markers) {
  if (report.result == nullptr || report.result->distances.empty()) return;
  const auto drawn = pairsWithTriangles(*report.result);
  for (const MonitoredPair& pair : report.pairs) {
    if (!isOfCycle(report.bodies, pair) || drawn.count({pair.a, pair.b}) > 0) continue;
    const std::optional<PairDistance> distance =
        distanceOf(report, pair, report.options.tolerance_m);
    if (!distance || !distance->touches()) continue;
    const BodyDistance& witness = *distance->bounds;
    // rviz would refuse the marker
    if (!isFinite(witness.point_a) || !isFinite(witness.point_b)) continue;
    Marker marker =
        makeMarker(report, options, pairKey(report, pair.a, pair.b, kWitness), Marker::SPHERE_LIST);
    marker.scale.x = marker.scale.y = marker.scale.z = kDiameterM;
    marker.points = {toPoint(witness.point_a), toPoint(witness.point_b)};
    marker.colors = {contactColor(report.bodies[pair.a].kind, options.alpha),
                     contactColor(report.bodies[pair.b].kind, options.alpha)};
    marker.color = marker.colors.front();
    markers->push_back(std::move(marker));
  }
}

}  // namespace deformable_contact_monitor
