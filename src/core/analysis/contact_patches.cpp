// Joins contacts to patches with a union-find over vertices. Its items are the vertices that
// contacts use; equal vertices are one item. Each contact joins all vertices of its two triangles.
// Two contacts are in the same patch iff their vertices end up in the same set.
#include "core/analysis/contact_patches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/analysis/union_find.h"
#include "core/common/posed_body.h"
#include "core/rules/vertex_hash.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

using ContactList = std::vector<std::uint32_t>;  // places in DetectionResult::contacts, ascending

// Returns the contacts of each pair of bodies, ascending. Contacts of a pair mostly follow one
// another in the list.
std::map<std::pair<BodyId, BodyId>, ContactList> byBodies(const TrianglePairs& pairs) {
  std::map<std::pair<BodyId, BodyId>, ContactList> lists;
  auto last = lists.end();
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::pair<BodyId, BodyId> bodies(pairs[i].body_a, pairs[i].body_b);
    if (last == lists.end() || last->first != bodies) last = lists.try_emplace(bodies).first;
    last->second.push_back(static_cast<std::uint32_t>(i));
  }
  return lists;
}

// Sums up the contacts of one patch, which are added one by one. It keeps all normals, because the
// signs of some are known only at the end.
class PatchSums {
 public:
  // `touches`: the triangles intersect, and are not only near.
  void add(const PairGeometry& geometry, bool touches) {
    const Vec3d a = toDouble(geometry.point_a), b = toDouble(geometry.point_b);
    const Vec3d middle = (a + b) * 0.5;
    const bool is_coplanar = (geometry.flags & kCoplanar) != 0;
    ++count_;
    middle_sum_ = middle_sum_ + middle;
    if (touches && !is_coplanar) {
      const double segment_m = length(b - a);
      curve_length_m_ += segment_m;
      curve_sum_ = curve_sum_ + middle * segment_m;
    }
    if ((geometry.flags & kSeparationUndefined) == 0) {
      min_separation_m_ = std::fmin(min_separation_m_, double{geometry.separation_m});
    }
    if ((geometry.flags & kNormalUndefined) != 0) return;
    (is_coplanar ? signless_normals_ : normals_).push_back(toDouble(geometry.normal));
  }

  // Writes the sums to the patch. At least one contact must have been added.
  void finish(Patch* patch) {
    patch->pair_count = count_;
    patch->curve_length_m = curve_length_m_;
    patch->min_separation_m = min_separation_m_;
    patch->centroid = curve_length_m_ > 0 ? curve_sum_ * (1 / curve_length_m_)
                                          : middle_sum_ * (1.0 / static_cast<double>(count_));
    finishNormal(patch);
  }

 private:
  // Coplanar pairs come last: each takes the sign that agrees with the sum so far.
  void finishNormal(Patch* patch) {
    // A sum that is shorter than this part of the number of normals counts as zero.
    constexpr double kCancelled = 1e-6;
    Vec3d sum;
    for (const Vec3d& normal : normals_) sum = sum + normal;
    for (const Vec3d& normal : signless_normals_) {
      normals_.push_back(dot(normal, sum) < 0 ? normal * -1.0 : normal);
      sum = sum + normals_.back();
    }
    patch->normal_spread_rad = std::numeric_limits<double>::quiet_NaN();
    const double sum_length = length(sum);
    if (!(sum_length > kCancelled * static_cast<double>(normals_.size()))) return;
    patch->normal = sum * (1 / sum_length);
    double angles_rad = 0;
    for (const Vec3d& normal : normals_) {
      angles_rad += std::atan2(length(cross(normal, patch->normal)), dot(normal, patch->normal));
    }
    patch->normal_spread_rad = angles_rad / static_cast<double>(normals_.size());
  }

  std::size_t count_ = 0;
  Vec3d middle_sum_, curve_sum_;
  double curve_length_m_ = 0;
  double min_separation_m_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<Vec3d> normals_, signless_normals_;
};

// Returns the area of these triangles of a body in the scene frame [m^2].
double areaOf(const Body& body, const std::vector<std::uint32_t>& triangles) {
  const PosedBody posed(body);
  double area_m2 = 0;
  for (const std::uint32_t t : triangles) {
    area_m2 += 0.5 * length(doubleAreaNormal(posed.triangle(t)));
  }
  return area_m2;
}

// Returns whether two bodies touch by their radii alone there: their triangles are apart, and have
// no common segment.
bool areBareApart(const Scene& scene, const DetectionResult& result, std::size_t contact) {
  const TrianglePair& pair = result.contacts[contact];
  const double sum_m = double{scene.body(pair.body_a).radius_m} + scene.body(pair.body_b).radius_m;
  return sum_m > 0 && result.geometry[contact].separation_m > static_cast<float>(-sum_m);
}

}  // namespace

// Numbers the vertices that contacts use. Numbers are those of the union-find.
class PatchFinder::Numbering {
 public:
  Numbering(const TriangleMesh& mesh, std::size_t contacts, VertexNumbers* numbers)
      : mesh_(mesh), numbers_(*numbers) {
    // A contact has at most six vertices in one body. The table is at most half full.
    const std::size_t most = std::min(mesh.vertexCount(), 6 * contacts);
    std::size_t size = 16;
    while (size < 2 * most) size *= 2;
    numbers_.table.assign(size, kNone);
    if (numbers_.of_vertex.size() < mesh.vertexCount()) {
      numbers_.of_vertex.resize(mesh.vertexCount(), kNone);
    }
    if (numbers_.of_triangle.size() < mesh.triangleCount()) {
      numbers_.of_triangle.resize(mesh.triangleCount(), kNone);
    }
  }
  Numbering(const Numbering&) = delete;
  Numbering& operator=(const Numbering&) = delete;
  // Resets only what was used, so that the time depends on the contacts and not on the size of the
  // mesh.
  ~Numbering() {
    for (const std::uint32_t v : numbers_.asked) numbers_.of_vertex[v] = kNone;
    for (const std::uint32_t t : numbers_.joined) numbers_.of_triangle[t] = kNone;
    numbers_.asked.clear();
    numbers_.joined.clear();
  }

  // Joins the triangle's vertices. Returns the number of one of them.
  std::uint32_t join(std::uint32_t triangle, UnionFind* joined) {
    std::uint32_t& first = numbers_.of_triangle[triangle];
    if (first != kNone) return first;
    numbers_.joined.push_back(triangle);
    const std::uint32_t* corner = &mesh_.triangles[3 * std::size_t{triangle}];
    first = number(corner[0], joined);
    joined->join(first, number(corner[1], joined));
    joined->join(first, number(corner[2], joined));
    return first;
  }

 private:
  // Returns the number of a vertex. It is a new one unless an equal vertex has a number.
  std::uint32_t number(std::uint32_t v, UnionFind* joined) {
    std::uint32_t& number = numbers_.of_vertex[v];
    if (number != kNone) return number;
    numbers_.asked.push_back(v);
    const Vec3f at = mesh_.vertex(v);
    const std::size_t mask = numbers_.table.size() - 1;
    std::size_t slot = vertexHash(at, 0) & mask;
    for (; numbers_.table[slot] != kNone; slot = (slot + 1) & mask) {
      const std::uint32_t other = numbers_.table[slot];
      if (mesh_.vertex(other) == at) return number = numbers_.of_vertex[other];
    }
    numbers_.table[slot] = v;
    return number = joined->add();
  }

  const TriangleMesh& mesh_;
  VertexNumbers& numbers_;
};

// Returns the contacts of each patch, in the order of the patches' first contacts.
std::vector<std::vector<std::uint32_t>> PatchFinder::joinedContacts(const Scene& scene,
                                                                    const TrianglePairs& pairs,
                                                                    const ContactList& contacts) {
  const BodyId body_a = pairs[contacts.front()].body_a, body_b = pairs[contacts.front()].body_b;
  UnionFind joined(0);
  ContactList node;
  node.reserve(contacts.size());
  Numbering a(scene.body(body_a).mesh, contacts.size(), &numbers_[0]);
  std::optional<Numbering> other;
  if (body_a != body_b) {
    other.emplace(scene.body(body_b).mesh, contacts.size(), &numbers_[1]);
  }
  Numbering& b = other ? *other : a;
  for (const std::uint32_t i : contacts) {
    node.push_back(a.join(pairs[i].triangle_a, &joined));
    joined.join(node.back(), b.join(pairs[i].triangle_b, &joined));
  }
  std::vector<std::uint32_t> patch_of(joined.size(), kNone);  // by root
  std::vector<ContactList> patches;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    std::uint32_t& patch = patch_of[joined.find(node[i])];
    if (patch == kNone) {
      patch = static_cast<std::uint32_t>(patches.size());
      patches.emplace_back();
    }
    patches[patch].push_back(contacts[i]);
  }
  return patches;
}

// Returns the triangles that these contacts have in body_a, or in body_b, ascending, each once.
std::vector<std::uint32_t> PatchFinder::trianglesOf(const TrianglePairs& pairs,
                                                    const ContactList& contacts,
                                                    std::uint32_t TrianglePair::*triangle) {
  std::vector<std::uint32_t> triangles;
  for (const std::uint32_t i : contacts) {
    const std::uint32_t t = pairs[i].*triangle;
    if (seen_[t]) continue;
    seen_[t] = true;
    triangles.push_back(t);
  }
  for (const std::uint32_t t : triangles) seen_[t] = false;
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

std::vector<Patch> PatchFinder::find(const Scene& scene, const DetectionResult& result) {
  if (result.geometry.size() != result.contacts.size()) {
    throw std::invalid_argument("patches need the geometry of " +
                                std::to_string(result.contacts.size()) + " contacts, not of " +
                                std::to_string(result.geometry.size()));
  }
  std::vector<Patch> patches;
  for (const auto& [bodies, contacts] : byBodies(result.contacts)) {
    const Body &a = scene.body(bodies.first), &b = scene.body(bodies.second);
    seen_.resize(std::max({seen_.size(), a.mesh.triangleCount(), b.mesh.triangleCount()}));
    for (const ContactList& of_patch : joinedContacts(scene, result.contacts, contacts)) {
      Patch patch;
      patch.body_a = bodies.first;
      patch.body_b = bodies.second;
      PatchSums sums;
      for (const std::uint32_t i : of_patch) {
        sums.add(result.geometry[i], result.touches(i) && !areBareApart(scene, result, i));
      }
      sums.finish(&patch);
      patch.triangles_a = trianglesOf(result.contacts, of_patch, &TrianglePair::triangle_a);
      patch.triangles_b = trianglesOf(result.contacts, of_patch, &TrianglePair::triangle_b);
      patch.area_a_m2 = areaOf(a, patch.triangles_a);
      patch.area_b_m2 = areaOf(b, patch.triangles_b);
      patches.push_back(std::move(patch));
    }
  }
  return patches;
}

}  // namespace deformable_contact_monitor
