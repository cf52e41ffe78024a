// Measures a scene on the host for a cold start: takes a sample of the triangles, culls those that
// no partner can touch, separates oversized ones, and picks seeds among the rest. The functions are
// overloaded for Triangle (one moment) and MovingTriangle (swept motion).
#include "cuda/cycle/cold_start.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/common/posed_body.h"
#include "core/common/scene_queries.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/rules/clustering.h"
#include "core/rules/common_motion.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {

namespace {

// Returns the centroid of a triangle [scaled]; of a moving one, that of both states.
Vec3f seedAt(const SizeSplit& split, const Triangle& t) {
  Vec3f points[3];
  split.scaled(t, points);
  return meanOf<Triangle>(points);
}
Vec3f seedAt(const SizeSplit& split, const MovingTriangle& t) {
  Vec3f points[6];
  split.scaled(t, points);
  return meanOf<MovingTriangle>(points);
}

// Selects `count` of `triangles` triangles, in ascending order: one from each of `count` equal
// parts of their order. A hash varies the place within each part, because a constant stride could
// always hit the same spot of a regular mesh.
struct Sample {
  std::size_t count, triangles;

  std::size_t operator[](std::size_t i) const {
    const std::size_t begin = i * triangles / count, end = (i + 1) * triangles / count;
    return begin + mixed(i) % (end - begin);
  }
};

// Returns triangle `t` of a body in the form that the motion needs. The last argument only selects
// the overload.
Triangle hullOf(const PosedBody& /*earlier*/, const PosedBody& body, std::uint32_t t,
                const Triangle* /*as*/) {
  return body.triangle(t);
}
MovingTriangle hullOf(const PosedBody& earlier, const PosedBody& body, std::uint32_t t,
                      const MovingTriangle* /*as*/) {
  return {earlier.triangle(t), body.triangle(t)};
}

const Aabb& setBoxOf(const Aabb& box, const Vec3f& /*common_motion*/) { return box; }
Aabb setBoxOf(const MovingBox& box, const Vec3f& common_motion) {
  return sweptBox(box, common_motion);
}

// Adds a sampled triangle to the set, with three vertices of its own. A full WorkingSet shares
// vertices between triangles; here that would take longer than it saves.
void add(const Triangle& t, WorkingSet& set) {
  set.vertices.insert(set.vertices.end(), t.v, t.v + 3);
}
void add(const MovingTriangle& t, WorkingSet& set) {
  set.earlier.insert(set.earlier.end(), t.from.v, t.from.v + 3);
  add(t.to, set);
}

// Adds the sampled triangles of one body whose vertices are finite and whose box meets the box of a
// partner. `first`: the number of the body's first triangle. `next`: the sample's first element
// that is not of an earlier body; it is moved on to the next body. Prefetches vertices, because
// sampled triangles are far apart in memory.
template <class Hull>
void addSampled(const Body& body, float growth_m, const PartnerBoxes<BoxOf<Hull>>& partners,
                const Sample& sample, std::size_t first, std::size_t& next, WorkingSet& set) {
  const PosedBody now(body), earlier = PosedBody::earlier(body);
  const std::size_t end = first + body.mesh.triangleCount();
  std::vector<std::uint32_t> sampled;
  for (; next < sample.count && sample[next] < end; ++next) {
    sampled.push_back(static_cast<std::uint32_t>(sample[next] - first));
  }
  for (std::size_t i = 0; i < sampled.size(); ++i) {
    if (i + 32 < sampled.size()) now.prefetchCorners(sampled[i + 32]);
    if (i + 16 < sampled.size()) now.prefetchVertices(sampled[i + 16]);
    const std::uint32_t t = sampled[i];
    const Hull hull = hullOf(earlier, now, t, static_cast<const Hull*>(nullptr));
    if (!isFinite(hull)) continue;
    const BoxOf<Hull> box = inflated(boxOf(hull), growth_m);
    if (!partners.meet(box)) continue;
    add(hull, set);
    set.triangle.push_back(t);
    set.boxes.push_back(setBoxOf(box, set.common_motion));
  }
}

// Returns whether some triangles may be culled by their partners' boxes. A body that may touch
// itself keeps all of its triangles, wherever the others are.
bool needsBoxes(const Scene& scene) {
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id) && !scene.pairEnabled(id, id)) return true;
  }
  return false;
}

// Returns the sampled triangles of all bodies. It is incomplete if the limit was over.
template <class Hull>
WorkingSet sampledSet(const Scene& scene, const Options& options, const Sample& sample,
                      BodyBoxes& boxes, const CycleLimit& limit) {
  WorkingSet set;
  set.vertices.reserve(3 * sample.count);
  set.triangle.reserve(sample.count);
  set.boxes.reserve(sample.count);
  const bool culls = needsBoxes(scene);
  if (culls) boxes.update<Hull>(scene, options, limit);
  if (limit.wasOver()) return set;
  if (kIsMoving<Hull>) set.common_motion = commonMotionOf(scene);
  PartnerBoxes<BoxOf<Hull>> itself;
  itself.self = true;
  std::size_t first = 0, next = 0;
  for (BodyId id = 0; id < scene.bodyCount() && !limit.over(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    addSampled<Hull>(body, growthOf<Hull>(body, options),
                     culls ? boxes.partnersOf<Hull>(scene, id) : itself, sample, first, next, set);
    first += body.mesh.triangleCount();
  }
  set.corners.resize(set.vertices.size());
  std::iota(set.corners.begin(), set.corners.end(), 0U);
  return set;
}

// Returns how many of `triangles` triangles an inspection examines.
std::size_t sampleSize(Inspection inspection, std::size_t triangles, std::size_t most_seeds) {
  constexpr std::size_t kBrief = 256, kLeastSample = 2048, kEachSeed = 4;
  if (inspection == Inspection::kAll) return triangles;
  return std::min(triangles, inspection == Inspection::kBrief
                                 ? kBrief
                                 : std::max(kLeastSample, kEachSeed * most_seeds));
}

// Returns the box that decides to which partitions a triangle belongs.
Aabb reachOf(const Triangle& t) { return boxOf(t); }
Aabb reachOf(const MovingTriangle& t) { return partitionBox(boxOf(t), 0); }

// Removes triangles that do not reach into the partition. It ignores margins and pads, which change
// the estimates little.
template <class Hull>
void keepPartition(const WorkingSet& set, const ScenePartition& partition,
                   std::vector<TriangleIndex>& list) {
  if (partition.isWhole()) return;
  const auto elsewhere = [&](TriangleIndex t) {
    return !partition.reaches(reachOf(set.posed<Hull>(t)));
  };
  list.erase(std::remove_if(list.begin(), list.end(), elsewhere), list.end());
}

template <class Hull>
ColdStart measureAs(const Scene& scene, const ScenePartition& partition, const Options& options,
                    const ClusterCountPolicy& policy, Inspection inspection, BodyBoxes& boxes,
                    const CycleLimit& limit) {
  const std::size_t triangles = trianglesThatTakePart(scene);
  const std::size_t most_seeds = clusterCountFor(options.clusters, policy, triangles, 0);
  const Sample sample{sampleSize(inspection, triangles, most_seeds), triangles};
  ColdStart start;
  const WorkingSet set = sampledSet<Hull>(scene, options, sample, boxes, limit);
  SizeSplit split;
  if (sample.count > 0) split.spare = split.spare * sample.count / triangles;
  if (!limit.wasOver()) splitBySize(set, split, limit);
  if (limit.wasOver()) return start;
  keepPartition<Hull>(set, partition, split.regular);
  keepPartition<Hull>(set, partition, split.oversized);
  const auto ofAll = [&](std::size_t sampled) {
    return sample.count == 0 ? 0 : sampled * triangles / sample.count;
  };
  start.scale = split.scale;
  start.size_rule = split.rule;
  start.regular = ofAll(split.regular.size());
  start.oversized = ofAll(split.oversized.size());
  start.seeds.resize(
      std::max<std::size_t>(1, clusterCountFor(options.clusters, policy, start.regular, 0)));
  // With fewer sampled triangles than seeds, some seeds would coincide. So all triangles are
  // examined.
  if (inspection == Inspection::kSample && sample.count < triangles &&
      start.seeds.size() > split.regular.size()) {
    return measureAs<Hull>(scene, partition, options, policy, Inspection::kAll, boxes, limit);
  }
  for (std::size_t g = 0; g < start.seeds.size() && !split.regular.empty(); ++g) {
    const TriangleIndex t = split.regular[seedOf(g, start.seeds.size(), split.regular.size())];
    start.seeds[g] = seedAt(split, set.posed<Hull>(t));
  }
  return start;
}

}  // namespace

ColdStart SceneMeasurer::measure(const Scene& scene, const ScenePartition& partition,
                                 const Options& options, const ClusterCountPolicy& policy,
                                 Inspection inspection, const CycleLimit& limit) {
  BodyBoxes& boxes = inspection == Inspection::kBrief ? brief_boxes_ : boxes_;
  return options.motion == Motion::kSwept
             ? measureAs<MovingTriangle>(scene, partition, options, policy, inspection, boxes,
                                         limit)
             : measureAs<Triangle>(scene, partition, options, policy, inspection, boxes, limit);
}

}  // namespace deformable_contact_monitor
