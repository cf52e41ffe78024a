// Matches the patches of a call with those of the last one by the triangles that they have in
// common. The arrays owner_a_ and owner_b_ tell to which known patch a triangle belongs, so
// counting takes one step for each triangle of a patch.
#include "core/analysis/patch_tracker.h"

#include <algorithm>
#include <iterator>
#include <set>
#include <tuple>

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Sets the owner of each of these triangles, which are ascending.
void setOwner(const std::vector<std::uint32_t>& triangles, std::uint32_t owner,
              std::vector<std::uint32_t>* owners) {
  if (!triangles.empty() && owners->size() <= triangles.back()) {
    owners->resize(std::size_t{triangles.back()} + 1, kNone);
  }
  for (const std::uint32_t t : triangles) (*owners)[t] = owner;
}

// Adds 1 to the count of the owner of each triangle that has one. Lists owners whose count was 0.
void count(const std::vector<std::uint32_t>& triangles, const std::vector<std::uint32_t>& owners,
           std::vector<std::size_t>* counts, std::vector<std::uint32_t>* counted) {
  for (const std::uint32_t t : triangles) {
    const std::uint32_t owner = t < owners.size() ? owners[t] : kNone;
    if (owner == kNone) continue;
    if ((*counts)[owner]++ == 0) counted->push_back(owner);
  }
}

}  // namespace

// For a body with itself, a triangle may change from one side of its contacts to the other, so both
// lists become one.
PatchTracker::Triangles PatchTracker::trianglesOf(const Patch& patch) {
  if (patch.body_a != patch.body_b) return {patch.triangles_a, patch.triangles_b};
  Triangles all;
  std::set_union(patch.triangles_a.begin(), patch.triangles_a.end(), patch.triangles_b.begin(),
                 patch.triangles_b.end(), std::back_inserter(all.a));
  return all;
}

// Each triangle belongs to at most one known patch of a pair of bodies. Returns how many triangles
// each new patch shares with each known one, where there are any.
std::vector<PatchTracker::Overlap> PatchTracker::overlaps(const std::vector<KnownPatch>& known,
                                                          const std::vector<Triangles>& patches) {
  for (std::uint32_t k = 0; k < known.size(); ++k) {
    setOwner(known[k].triangles.a, k, &owner_a_);
    setOwner(known[k].triangles.b, k, &owner_b_);
  }
  std::vector<Overlap> found;
  std::vector<std::size_t> counts(known.size(), 0);
  std::vector<std::uint32_t> counted;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    count(patches[p].a, owner_a_, &counts, &counted);
    count(patches[p].b, owner_b_, &counts, &counted);
    for (const std::uint32_t k : counted) {
      found.push_back({counts[k], known[k].id, p});
      counts[k] = 0;
    }
    counted.clear();
  }
  for (const KnownPatch& patch : known) {
    setOwner(patch.triangles.a, kNone, &owner_a_);
    setOwner(patch.triangles.b, kNone, &owner_b_);
  }
  return found;
}

// Gives ids to the patches of one pair of bodies: the largest overlaps choose first.
void PatchTracker::assignOfPair(const Scene& scene, KnownPair* known, Patch* begin, Patch* end) {
  const auto count = static_cast<std::size_t>(end - begin);
  std::vector<Triangles> triangles;
  triangles.reserve(count);
  for (Patch* patch = begin; patch != end; ++patch) triangles.push_back(trianglesOf(*patch));
  std::vector<Overlap> common = overlaps(known->patches, triangles);
  std::sort(common.begin(), common.end(), [](const Overlap& a, const Overlap& b) {
    return std::tie(b.triangles, a.id, a.patch) < std::tie(a.triangles, b.id, b.patch);
  });
  std::set<std::uint32_t> taken;
  for (const Overlap& overlap : common) {
    if (begin[overlap.patch].id != 0 || !taken.insert(overlap.id).second) continue;
    begin[overlap.patch].id = overlap.id;
  }
  known->patches.clear();
  for (std::size_t p = 0; p < count; ++p) {
    if (begin[p].id == 0) begin[p].id = ++last_id_;
    known->patches.push_back({begin[p].id, std::move(triangles[p])});
  }
  if (count == 0) return;
  known->topology_a = scene.body(begin->body_a).topology_revision;
  known->topology_b = scene.body(begin->body_b).topology_revision;
}

void PatchTracker::assign(const Scene& scene, std::vector<Patch>* patches) {
  // Triangles have other indices after a change of the mesh, so the patches of that body are
  // forgotten.
  for (auto known = known_.begin(); known != known_.end();) {
    const auto [a, b] = known->first;
    const bool is_there = a < scene.bodyCount() && b < scene.bodyCount();
    const bool is_same = is_there && scene.body(a).topology_revision == known->second.topology_a &&
                         scene.body(b).topology_revision == known->second.topology_b;
    known = is_same ? std::next(known) : known_.erase(known);
  }
  const auto bodies = [](const Patch& patch) { return std::make_pair(patch.body_a, patch.body_b); };
  for (Patch& patch : *patches) patch.id = 0;
  std::stable_sort(patches->begin(), patches->end(),
                   [&](const Patch& a, const Patch& b) { return bodies(a) < bodies(b); });
  Patch* const end = patches->data() + patches->size();
  Patch* begin = patches->data();
  for (const auto& [a, b] : scene.enabledPairs()) {
    const auto pair = std::make_pair(a, b);
    Patch* const last =
        std::find_if(begin, end, [&](const Patch& patch) { return bodies(patch) != pair; });
    if (begin == last) {
      known_.erase(pair);
      continue;
    }
    assignOfPair(scene, &known_[pair], begin, last);
    std::sort(begin, last, [](const Patch& x, const Patch& y) { return x.id < y.id; });
    begin = last;
  }
}

}  // namespace deformable_contact_monitor
