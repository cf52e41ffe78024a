#include "core/tiles/surface_regions.h"

#include <algorithm>
#include <array>

namespace deformable_contact_monitor {
namespace {

// A triangle beside the region, with a key for each time that one beside it came in.
struct Candidate {
  float key;            // the least comes in first
  std::uint32_t order;  // in which they were found
  std::uint32_t triangle;
};

bool isLater(const Candidate& a, const Candidate& b) {
  return a.key != b.key ? a.key > b.key : a.order > b.order;
}

class Grower {
 public:
  Grower(const std::vector<PlacedTriangle>& triangles, const std::vector<std::uint32_t>& neighbours,
         std::size_t most)
      : triangles_(triangles), neighbours_(neighbours), most_(most), region_(triangles.size()) {
    regions_.triangle.reserve(triangles.size());
    regions_.begin.assign(1, 0);
  }

  SurfaceRegions grow(const CycleLimit& limit) {
    PacedLimit pace(limit, 1 << 13);
    for (std::uint32_t t = 0; t < triangles_.size() && !pace.over(); ++t) {
      // Beside what is there already, in turn, so that few gaps remain.
      seeds_.assign(1, t);
      for (std::size_t i = 0; i < seeds_.size() && !pace.over(); ++i) {
        if (region_[seeds_[i]] == 0) pace.over(growFrom(seeds_[i]));
      }
    }
    return std::move(regions_);
  }

 private:
  std::uint32_t number() const { return static_cast<std::uint32_t>(regions_.begin.size()); }
  std::size_t size() const { return regions_.triangle.size() - regions_.begin.back(); }
  const std::uint32_t* beside(std::uint32_t t) const { return &neighbours_[3 * std::size_t{t}]; }

  // How many it took.
  std::size_t growFrom(std::uint32_t seed) {
    candidates_.clear();
    order_ = 0;
    sum_ = {};
    centre_ = triangles_[seed].at;
    take(seed);
    std::size_t next_centre = 2;
    while (size() < most_ && !candidates_.empty()) {
      std::pop_heap(candidates_.begin(), candidates_.end(), isLater);
      const std::uint32_t t = candidates_.back().triangle;
      candidates_.pop_back();
      if (region_[t] != 0) continue;
      take(t);
      if (size() == next_centre) {
        moveCentre();
        next_centre *= 2;
      }
    }
    for (const Candidate& c : candidates_) {
      if (region_[c.triangle] == 0) seeds_.push_back(c.triangle);
    }
    const std::size_t taken = size();
    regions_.begin.push_back(static_cast<std::uint32_t>(regions_.triangle.size()));
    return taken;
  }

  void take(std::uint32_t t) {
    region_[t] = number();
    regions_.triangle.push_back(t);
    for (int k = 0; k < 3; ++k) sum_[static_cast<std::size_t>(k)] += triangles_[t].at[k];
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t n = beside(t)[k];
      if (region_[n] != 0) continue;
      candidates_.push_back({keyOf(n), order_++, n});
      std::push_heap(candidates_.begin(), candidates_.end(), isLater);
    }
  }

  // Near the centre first, and notches before they become holes.
  float keyOf(std::uint32_t t) const {
    const Vec3f off = triangles_[t].at - centre_;
    int touched = 0;
    for (int k = 0; k < 3; ++k) touched += region_[beside(t)[k]] == number();
    touched = std::max(touched, 1);  // of an edge of many triangles it may not see the region
    return dot(off, off) / static_cast<float>(touched * touched);
  }

  void moveCentre() {
    const auto n = static_cast<double>(size());
    centre_ = {static_cast<float>(sum_[0] / n), static_cast<float>(sum_[1] / n),
               static_cast<float>(sum_[2] / n)};
    const auto gone = [this](const Candidate& c) { return region_[c.triangle] != 0; };
    candidates_.erase(std::remove_if(candidates_.begin(), candidates_.end(), gone),
                      candidates_.end());
    for (Candidate& c : candidates_) c.key = keyOf(c.triangle);
    std::make_heap(candidates_.begin(), candidates_.end(), isLater);
  }

  const std::vector<PlacedTriangle>& triangles_;
  const std::vector<std::uint32_t>& neighbours_;
  std::size_t most_;
  std::vector<std::uint32_t> region_;  // its number, from 1; 0: none yet
  SurfaceRegions regions_;
  std::vector<std::uint32_t> seeds_;
  // Of the region that grows.
  std::vector<Candidate> candidates_;  // a heap
  std::uint32_t order_ = 0;
  std::array<double, 3> sum_{};
  Vec3f centre_;
};

}  // namespace

SurfaceRegions surfaceRegions(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                              const std::vector<std::uint32_t>& neighbours, std::size_t most) {
  return Grower(triangles, neighbours, most).grow(limit);
}

}  // namespace deformable_contact_monitor
