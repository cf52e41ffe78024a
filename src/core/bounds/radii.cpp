#include "core/bounds/radii.h"

#include <algorithm>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/bounds/distance_rounding.h"
#include "core/bounds/pair_radii.h"
#include "core/bounds/ways_along_mesh.h"
#include "core/common/cycle_limit.h"
#include "core/common/stopwatch.h"
#include "core/rules/margins.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kPi = 3.14159265358979323846;

// Returns the margin of two triangles [m].
float marginOf(const Scene& scene, const TrianglePair& pair) {
  const Body &a = scene.body(pair.body_a), &b = scene.body(pair.body_b);
  return pairMargin(a.marginOf(a.partOf(pair.triangle_a)), b.marginOf(b.partOf(pair.triangle_b)));
}

// Returns how much a body's margin must grow so that no contact of its pairs is missed: by its own
// radius and the largest one of its partners. A pair has the larger margin of its two bodies.
std::vector<double> growths(const Scene& scene) {
  std::vector<double> growth(scene.bodyCount());
  for (const auto& [a, b] : scene.enabledPairs()) {
    const double sum = double{scene.body(a).radius_m} + scene.body(b).radius_m;
    growth[a] = std::max(growth[a], sum);
    growth[b] = std::max(growth[b], sum);
  }
  return growth;
}

// Takes the radii off the bounds of a distance, which are those of the triangles.
void deflate(const PairRadii& radii, BodyDistance* distance) {
  if (radii.sum() == 0) return;
  distance->low_m = distance->low_m <= radii.sum() ? 0 : roundedDown(distance->low_m - radii.sum());
  if (!std::isfinite(distance->high_m)) return;
  const bool touch = distance->high_m <= radii.touch_m;
  distance->high_m = touch ? 0 : roundedUp(distance->high_m - radii.sum());
  const Vec3d way = toDouble(distance->point_b) - toDouble(distance->point_a);
  const double gap_m = length(way);
  if (gap_m == 0) return;
  movePoints(radii, gap_m, toFloat(way * (1 / gap_m)), touch, &distance->point_a,
             &distance->point_b);
}

// Takes the radii off the geometry of a contact.
void deflate(const PairRadii& radii, PairGeometry* geometry) {
  if (geometry->separation_m > 0) {
    geometry->point_a = movedAlong(geometry->normal, radii.a_m, geometry->point_a);
    geometry->point_b = movedAlong(geometry->normal, -radii.b_m, geometry->point_b);
  }
  const double separation_m = geometry->separation_m - radii.sum();
  if (std::abs(separation_m) > FLT_MAX) geometry->flags |= kSeparationUndefined;
  geometry->separation_m = finiteFloat(separation_m);
}

class InflatedDetector : public Detector {
 public:
  explicit InflatedDetector(std::unique_ptr<Detector> detector) : detector_(std::move(detector)) {}
  std::string backend() const override { return detector_->backend(); }
  std::pmr::memory_resource& vertexMemory() override { return detector_->vertexMemory(); }
  void reset() override { detector_->reset(); }

  const DetectionResult& detect(const Scene& scene, const Options& options) override {
    const bool has_radii = scene.anyRadius(), has_part_margins = scene.anyPartMargin();
    works_here_ = has_radii || has_part_margins;
    if (!works_here_) return detector_->detect(scene, options);
    requireValid(options);
    requireSupported(scene, options);
    const Stopwatch cycle;
    Options of_parts = options;
    of_parts.nearest_by_part |= options.nearest && has_part_margins;
    if (has_radii) {
      bare_ = scene;
      run(scene, of_parts);
    } else {
      detector_->detect(scene, of_parts);
      detector_->swapResult(result_);
    }
    if (has_radii || options.near_pairs || !options.nearest) keepContacts(scene, options);
    keepNearest(scene);
    keepDistances(scene);
    if (!options.nearest_by_part) result_.nearest_parts.clear();
    result_.round_trip_ms = cycle.elapsedMs();
    return result_;
  }

  void swapResult(DetectionResult& result) override {
    if (!works_here_) return detector_->swapResult(result);
    result_.swap(result);
  }

 private:
  static void requireSupported(const Scene& scene, const Options& options);
  void run(const Scene& scene, const Options& options);
  void detectWithin(const Scene& scene, const Options& options, bool with_margins,
                    DetectionResult* result);
  void takeSearch();
  void keepContacts(const Scene& scene, const Options& options);
  void keepNearest(const Scene& scene);
  void keepDistances(const Scene& scene);

  std::unique_ptr<Detector> detector_;
  Scene bare_;               // without radii, and with margins that are larger by them
  bool works_here_ = false;  // the last result is not the detector's own
  DetectionResult result_, search_;
};

void InflatedDetector::requireSupported(const Scene& scene, const Options& options) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    if (!scene.takesPart(id)) continue;
    if (options.tolerance_m > 0 && !body.part_margins_m.empty()) {
      throw std::invalid_argument(body.name + ": its parts have margins of their own, which are " +
                                  "only decided exactly; set tolerance_m to 0");
    }
    if (body.radius_m == 0) continue;
    if (options.motion == Motion::kSwept) {
      throw std::invalid_argument(body.name + ": it has a radius, and motion \"swept\" finds no " +
                                  "contacts of such bodies; set motion \"instant\"");
    }
    if (options.tolerance_m > 0) {
      throw std::invalid_argument(body.name + ": it has a radius, whose contacts are only found " +
                                  "exactly; set tolerance_m to 0");
    }
    if (body.device_vertices && scene.pairEnabled(id, id)) {
      throw std::invalid_argument(body.name + ": its vertices are on a device, but it has a " +
                                  "radius, and contacts with itself are looked for on the host");
    }
  }
}

// A list of contacts needs margins as large as the radii, and a search those of the user as well.
// The search comes first, with half of the time, because a long list would leave it none.
void InflatedDetector::run(const Scene& scene, const Options& options) {
  const bool lists_near = options.near_pairs || !options.nearest;
  const bool is_one = lists_near || !scene.anyMargin();
  if (!is_one) {
    Options search = options;
    search.geometry = false;
    SteadyTime& deadline = search.limits.deadline;
    const SteadyTime now = std::chrono::steady_clock::now();
    if (deadline != SteadyTime::max() && deadline > now) deadline = now + (deadline - now) / 2;
    detectWithin(scene, search, true, &search_);
  }
  Options list = options;
  list.near_pairs = true;
  list.nearest = options.nearest && is_one;
  list.nearest_by_part = options.nearest_by_part && is_one;
  detectWithin(scene, list, lists_near, &result_);
  if (!is_one) takeSearch();
}

// Adds what the search found to the list of contacts.
void InflatedDetector::takeSearch() {
  result_.nearest.swap(search_.nearest);
  result_.nearest_parts.swap(search_.nearest_parts);
  if (!search_.distances.empty()) {
    const bool all_listed = result_.guaranteed && !result_.cut_off && result_.left_out == 0;
    std::set<std::pair<BodyId, BodyId>> listed;
    for (const BodyDistance& d : result_.distances) {
      if (d.is_listed) listed.emplace(d.body_a, d.body_b);
    }
    for (BodyDistance& d : search_.distances) {
      d.is_listed = all_listed || listed.count({d.body_a, d.body_b}) > 0;
    }
    result_.distances.swap(search_.distances);
  }
  // The list may have had no time to look at the triangles that the search rejected.
  if (search_.counters.rejected > result_.counters.rejected) {
    result_.counters.rejected = search_.counters.rejected;
    result_.rejected_parts.swap(search_.rejected_parts);
  }
  if (search_.cut_off) result_.cutOff(search_.cut_off_because);
  result_.guaranteed = result_.guaranteed && search_.guaranteed;
  for (const auto& stage : search_.stages_ms) {
    result_.stages_ms.emplace_back("search_" + stage.first, stage.second);
  }
  result_.detect_ms += search_.detect_ms;
}

// Takes the radii off the nearest pairs, and drops those that are beyond their margin then. Parts
// of a body may have different margins, so the nearest pair of two bodies is found anew among those
// of their parts.
void InflatedDetector::keepNearest(const Scene& scene) {
  const auto isBeyond = [&scene](const NearestPair& nearest) {
    return nearest.distance_m > marginOf(scene, nearest.pair);
  };
  // By bodies: the distance of the triangles, and the pair without the radii.
  std::map<std::pair<BodyId, BodyId>, std::pair<float, NearestPair>> best;
  std::vector<NearestOfParts>& parts = result_.nearest_parts;
  for (NearestOfParts& of : parts) {
    const float bare_m = of.nearest.distance_m;
    deflate({scene.body(of.parts.body_a), scene.body(of.parts.body_b)}, &of.nearest);
    if (isBeyond(of.nearest)) continue;
    const auto [place, is_new] =
        best.try_emplace({of.parts.body_a, of.parts.body_b}, bare_m, of.nearest);
    auto& [least_m, least] = place->second;
    if (!is_new && std::tie(bare_m, of.nearest.pair) < std::tie(least_m, least.pair)) {
      place->second = {bare_m, of.nearest};
    }
  }
  parts.erase(std::remove_if(parts.begin(), parts.end(),
                             [&](const NearestOfParts& of) { return isBeyond(of.nearest); }),
              parts.end());
  std::vector<NearestPair>& nearest = result_.nearest;
  for (NearestPair& of : nearest) {
    const Body &a = scene.body(of.pair.body_a), &b = scene.body(of.pair.body_b);
    deflate({a, b}, &of);
    if (a.part_margins_m.empty() && b.part_margins_m.empty()) continue;
    const auto found = best.find({of.pair.body_a, of.pair.body_b});
    if (found != best.end()) of = found->second.second;
  }
  nearest.erase(std::remove_if(nearest.begin(), nearest.end(), isBeyond), nearest.end());
}

// Takes the radii off the bounds, and makes them agree with what is listed.
void InflatedDetector::keepDistances(const Scene& scene) {
  using BodyPair = std::pair<BodyId, BodyId>;
  if (result_.distances.empty()) return;
  std::map<BodyPair, std::uint32_t> count;
  std::set<BodyPair> touching;
  for (std::size_t i = 0; i < result_.contacts.size(); ++i) {
    const BodyPair bodies(result_.contacts[i].body_a, result_.contacts[i].body_b);
    ++count[bodies];
    if (result_.touches(i)) touching.insert(bodies);
  }
  std::set<BodyPair> near;
  for (const NearestPair& nearest : result_.nearest) {
    const BodyPair bodies(nearest.pair.body_a, nearest.pair.body_b);
    near.insert(bodies);
    if (nearest.distance_m == 0) touching.insert(bodies);
  }
  for (BodyDistance& distance : result_.distances) {
    const BodyPair bodies(distance.body_a, distance.body_b);
    const Body &a = scene.body(bodies.first), &b = scene.body(bodies.second);
    deflate({a, b}, &distance);
    distance.contact_count = count[bodies];
    if (touching.count(bodies) > 0) {
      distance.low_m = distance.high_m = 0;
    } else if (distance.is_exact && near.count(bodies) == 0) {  // beyond its margin
      const bool is_beyond_all = a.part_margins_m.empty() && b.part_margins_m.empty();
      if (!is_beyond_all && result_.cut_off && std::isfinite(distance.high_m)) {
        distance.is_exact = distance.is_listed = false;  // another part may be near
        continue;
      }
      const float margin_m = pairMargin(a.margin_m, b.margin_m);
      if (is_beyond_all) distance.low_m = std::max(distance.low_m, margin_m);
      distance.high_m = INFINITY;
    }
  }
}

// The margins cover the rounding of a sum, and of the difference that apartM() rounds.
void InflatedDetector::detectWithin(const Scene& scene, const Options& options, bool with_margins,
                                    DetectionResult* result) {
  const std::vector<double> growth = growths(scene);
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const double margin_m = with_margins ? scene.body(id).margin_m : 0;
    bare_.setRadius(id, 0);
    bare_.setPartMargins(id, {});  // the body's margin is the largest of them
    bare_.setMargin(id, growth[id] == 0 ? static_cast<float>(margin_m)
                                        : roundedUp(std::min<double>(
                                              (margin_m + growth[id]) * (1 + 0x1p-22), FLT_MAX)));
  }
  detector_->detect(bare_, options);
  detector_->swapResult(*result);
}

// Drops the pairs that are no contacts, and takes the radii off the others.
void InflatedDetector::keepContacts(const Scene& scene, const Options& options) {
  const bool lists_near = options.near_pairs || !options.nearest;
  const bool has_geometry = result_.geometry.size() == result_.contacts.size();
  const bool has_separations = lists_near && scene.anyMargin();
  const bool has_self_contacts = std::any_of(
      result_.contacts.begin(), result_.contacts.end(), [&scene](const TrianglePair& pair) {
        return pair.body_a == pair.body_b && scene.body(pair.body_a).radius_m > 0;
      });
  std::map<BodyId, WaysAlongMesh> ways;
  std::pair<BodyId, std::uint32_t> start(0, 0);
  bool has_start = false;
  const auto isCloseAlong = [&](const TrianglePair& pair) {
    const Body& body = scene.body(pair.body_a);
    WaysAlongMesh& way = ways.try_emplace(pair.body_a, body).first->second;
    if (!has_start || start != std::make_pair(pair.body_a, pair.triangle_a)) {
      way.startAt(pair.triangle_a, kPi * body.radius_m);
    }
    has_start = true;
    start = {pair.body_a, pair.triangle_a};
    return way.reaches(pair.triangle_b);
  };
  const CycleLimit limit(options.limits);
  PacedLimit pace(limit, 256);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < result_.contacts.size(); ++i) {
    if (has_self_contacts && pace.over()) {
      result_.left_out += result_.contacts.size() - i;
      result_.cutOff(limit.why());
      break;
    }
    const TrianglePair pair = result_.contacts[i];
    const Body &a = scene.body(pair.body_a), &b = scene.body(pair.body_b);
    const PairRadii radii(a, b);
    const float apart_m = radii.apartM(result_.separationM(i));
    if (apart_m > (lists_near ? marginOf(scene, pair) : 0)) continue;
    if (pair.body_a == pair.body_b && a.radius_m > 0 && isCloseAlong(pair)) continue;
    result_.contacts[kept] = pair;
    if (!result_.separations_m.empty()) result_.separations_m[kept] = apart_m;
    if (has_geometry) {
      result_.geometry[kept] = result_.geometry[i];
      if (radii.sum() > 0) deflate(radii, &result_.geometry[kept]);
    }
    ++kept;
  }
  result_.contacts.resize(kept);
  if (has_geometry) result_.geometry.resize(kept);
  if (!result_.separations_m.empty()) result_.separations_m.resize(kept);
  if (!has_separations) result_.separations_m.clear();
}

}  // namespace

std::unique_ptr<Detector> withRadiiAndPartMargins(std::unique_ptr<Detector> detector) {
  return std::make_unique<InflatedDetector>(std::move(detector));
}

}  // namespace deformable_contact_monitor
