// Sums up contacts for each pair of bodies.
//
// Contacts are sorted by body_a, triangle_a, body_b. They are cut into blocks that threads sum up
// independently; no block splits the contacts of one triangle of body_a, whose normal counts once.
#include "monitor/state/pair_summary.h"

#include <algorithm>

#include "core/common/parallel.h"
#include "core/common/posed_body.h"
#include "core/predicates/triangle.h"

namespace deformable_contact_monitor {
namespace {

using Summaries = std::unordered_map<std::uint64_t, PairSummary>;

constexpr std::size_t kBlock = 2048;  // contacts of one block

std::uint64_t key(BodyId a, BodyId b) { return (std::uint64_t{a} << 32U) | b; }

Vec3d cornerSum(const Triangle& t) {
  return toDouble(t.v[0]) + toDouble(t.v[1]) + toDouble(t.v[2]);
}

// Transforms the sum of so many points of a body from its own frame to the scene frame [m].
Vec3d posedSum(const RigidTransform& pose, const Vec3d& sum, double points) {
  const double* const r = pose.rotation;
  const double* const t = pose.translation;
  return {r[0] * sum.x + r[1] * sum.y + r[2] * sum.z + points * t[0],
          r[3] * sum.x + r[4] * sum.y + r[5] * sum.z + points * t[1],
          r[6] * sum.x + r[7] * sum.y + r[8] * sum.z + points * t[2]};
}

bool sameTriangleA(const TrianglePair& a, const TrianglePair& b) {
  return a.body_a == b.body_a && a.triangle_a == b.triangle_a;
}

// Keeps the contact at the lesser distance; of two at the same distance, the first.
void keepLess(std::size_t contact, double distance_m, std::size_t* kept, double* kept_m) {
  if (distance_m > *kept_m || (distance_m == *kept_m && contact >= *kept)) return;
  *kept = contact;
  *kept_m = distance_m;
}

void add(const PairSummary& part, PairSummary* sum) {
  sum->count += part.count;
  sum->min_separation_m = std::min(sum->min_separation_m, part.min_separation_m);
  keepLess(part.nearest, part.nearest_m, &sum->nearest, &sum->nearest_m);
  keepLess(part.deepest, part.deepest_m, &sum->deepest, &sum->deepest_m);
  sum->corner_sum = sum->corner_sum + part.corner_sum;
  sum->normal_sum = sum->normal_sum + part.normal_sum;
  sum->area_sum += part.area_sum;
}

// Finds the nearest and the deepest of `count` contacts, of which place(i) is the place in the
// list. The detector's verdict tells whether they touch, the geometry of contacts how deep they
// are.
template <class Place>
void findLeast(const CycleReport& report, const DetectionResult& result, std::size_t count,
               const Place& place, PairSummary* sum) {
  const std::size_t compared = result.separations_m.empty() ? 1 : count;  // else all touch
  for (std::size_t i = 0; i < compared; ++i) {
    keepLess(place(i), result.separationM(place(i)), &sum->nearest, &sum->nearest_m);
  }
  sum->min_separation_m = sum->nearest_m;
  if (report.result.get() != &result || !hasGeometry(report)) return;
  for (std::size_t i = 0; i < count; ++i) {
    keepLess(place(i), result.geometry[place(i)].separation_m, &sum->deepest, &sum->deepest_m);
  }
  sum->min_separation_m = std::min(sum->nearest_m, sum->deepest_m);
}

// Sums up `count` contacts, at least one, which are all of one pair of bodies; place(i) is the
// place of the i-th in the list, ascending. Corners are summed up in the bodies' own frames, so
// that only the two sums have to be transformed.
template <class Place>
PairSummary sumUp(const CycleReport& report, const DetectionResult& result, std::size_t count,
                  const Place& place) {
  const TrianglePairs& contacts = result.contacts;
  const BodyId a = contacts[place(0)].body_a, b = contacts[place(0)].body_b;
  const Scene& scene = *report.scene;
  const PosedBody of_a(scene.body(a)), of_b(scene.body(b));
  const bool has_normal = report.bodies.at(a).kind != BodyKind::kDeformable;
  PairSummary sum;
  Vec3d sum_a, sum_b, corners_of_a;
  for (std::size_t i = 0; i < count; ++i) {
    const TrianglePair& contact = contacts[place(i)];
    if (i == 0 || contact.triangle_a != contacts[place(i - 1)].triangle_a) {
      corners_of_a = cornerSum(of_a.received(contact.triangle_a));
      if (has_normal) {
        const Vec3d normal = doubleAreaNormal(of_a.triangle(contact.triangle_a));
        sum.normal_sum = sum.normal_sum + normal;
        sum.area_sum += length(normal);
      }
    }
    // The vertices have just arrived, but the triangles are not in the cache any more: indices are
    // prefetched first, and then the vertices that they name.
    constexpr std::size_t kFar = 32, kNear = 16;  // contacts ahead
    if (i + kFar < count) of_b.prefetchCorners(contacts[place(i + kFar)].triangle_b);
    if (i + kNear < count) of_b.prefetchVertices(contacts[place(i + kNear)].triangle_b);
    sum_a = sum_a + corners_of_a;
    sum_b = sum_b + cornerSum(of_b.received(contact.triangle_b));
  }
  sum.count = count;
  const double corners = 3 * static_cast<double>(count);
  sum.corner_sum =
      posedSum(scene.body(a).pose, sum_a, corners) + posedSum(scene.body(b).pose, sum_b, corners);
  findLeast(report, result, count, place, &sum);
  return sum;
}

// Sums up contacts [begin, end) of any bodies. Runs of one pair of bodies are summed up before they
// go into the map, because a search for each contact would be slow.
Summaries summarize(const CycleReport& report, const DetectionResult& result, std::size_t begin,
                    std::size_t end) {
  Summaries summaries;
  const TrianglePairs& contacts = result.contacts;
  for (std::size_t first = begin; first < end;) {
    const BodyId a = contacts[first].body_a, b = contacts[first].body_b;
    std::size_t last = first;
    while (last < end && contacts[last].body_a == a && contacts[last].body_b == b) ++last;
    const auto place = [first](std::size_t i) { return first + i; };
    add(sumUp(report, result, last - first, place), &summaries[key(a, b)]);
    first = last;
  }
  return summaries;
}

}  // namespace

Vec3d PairSummary::centroid() const {
  return count == 0 ? Vec3d() : corner_sum * (1.0 / (6.0 * static_cast<double>(count)));
}

Vec3d PairSummary::meanNormal() const {
  constexpr double kCancelled = 1e-6;  // a shorter sum is rounding
  const double size = length(normal_sum);
  return size > kCancelled * area_sum ? normal_sum * (1 / size) : Vec3d();
}

PairSummaries::PairSummaries(const CycleReport& report, const DetectionResult* result) {
  if (report.scene == nullptr || result == nullptr) return;
  const TrianglePairs& contacts = result->contacts;
  // Moves the bound of a block behind the contacts of one triangle.
  const auto start = [&contacts](std::size_t i) {
    while (i > 0 && i < contacts.size() && sameTriangleA(contacts[i - 1], contacts[i])) ++i;
    return i;
  };
  std::vector<Summaries> parts(blockCount(contacts.size(), kBlock));
  parallelBlocks(contacts.size(), kBlock,
                 [&](std::size_t block, std::size_t begin, std::size_t end) {
                   parts[block] = summarize(report, *result, start(begin), start(end));
                 });
  for (const Summaries& part : parts) {
    for (const auto& [pair, summary] : part) add(summary, &by_pair_[pair]);
  }
  if (report.part_pairs.empty()) return;
  std::map<PartPair, std::vector<std::size_t>> of_parts;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    forEachPartPair(report, contacts[i],
                    [&](const PartPair& pair) { of_parts[pair].push_back(i); });
  }
  for (const auto& [pair, places] : of_parts) {
    const auto place = [&all = places](std::size_t i) { return all[i]; };
    by_part_[pair] = sumUp(report, *result, places.size(), place);
  }
}

PairSummary PairSummaries::of(const MonitoredPair& pair) const {
  if (pair.part_a == 0 && pair.part_b == 0) return of(pair.a, pair.b);
  const auto found = by_part_.find(partKey(pair));
  return found == by_part_.end() ? PairSummary() : found->second;
}

PairSummary PairSummaries::of(BodyId a, BodyId b) const {
  const auto found = by_pair_.find(key(a, b));
  return found == by_pair_.end() ? PairSummary() : found->second;
}

}  // namespace deformable_contact_monitor
