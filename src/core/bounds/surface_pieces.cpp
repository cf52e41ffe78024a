#include "core/bounds/surface_pieces.h"

#include <algorithm>

namespace deformable_contact_monitor {
namespace {

// A triangle beside the piece; perhaps not for the first time.
struct Candidate {
  float distance2;      // from the seed [m^2]; the least comes in first
  std::uint32_t order;  // in which they were found
  std::uint32_t triangle;
};

bool isLater(const Candidate& a, const Candidate& b) {
  return a.distance2 != b.distance2 ? a.distance2 > b.distance2 : a.order > b.order;
}

class Grower {
 public:
  Grower(const std::vector<PlacedTriangle>& triangles, const std::vector<std::uint32_t>& neighbours,
         std::size_t most)
      : triangles_(triangles), neighbours_(neighbours), most_(most), is_taken_(triangles.size()) {
    pieces_.triangle.reserve(triangles.size());
    pieces_.begin.assign(1, 0);
  }

  SurfacePieces grow(const CycleLimit& limit) {
    PacedLimit pace(limit, 1 << 13);
    for (std::uint32_t t = 0; t < triangles_.size() && !pace.over(); ++t) {
      // Beside what is there already, in turn, so that few gaps remain.
      seeds_.assign(1, t);
      for (std::size_t i = 0; i < seeds_.size() && !pace.over(); ++i) {
        if (!is_taken_[seeds_[i]]) pace.over(growFrom(seeds_[i]));
      }
    }
    return std::move(pieces_);
  }

 private:
  std::size_t size() const { return pieces_.triangle.size() - pieces_.begin.back(); }

  // How many it took.
  std::size_t growFrom(std::uint32_t seed) {
    candidates_.clear();
    order_ = 0;
    seed_ = triangles_[seed].at;
    take(seed);
    while (size() < most_ && !candidates_.empty()) {
      std::pop_heap(candidates_.begin(), candidates_.end(), isLater);
      const std::uint32_t t = candidates_.back().triangle;
      candidates_.pop_back();
      if (!is_taken_[t]) take(t);
    }
    for (const Candidate& c : candidates_) seeds_.push_back(c.triangle);
    const std::size_t taken = size();
    pieces_.begin.push_back(static_cast<std::uint32_t>(pieces_.triangle.size()));
    return taken;
  }

  void take(std::uint32_t t) {
    is_taken_[t] = true;
    pieces_.triangle.push_back(t);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t n = neighbours_[3 * std::size_t{t} + k];
      if (is_taken_[n]) continue;
      const Vec3f off = triangles_[n].at - seed_;
      candidates_.push_back({dot(off, off), order_++, n});
      std::push_heap(candidates_.begin(), candidates_.end(), isLater);
    }
  }

  const std::vector<PlacedTriangle>& triangles_;
  const std::vector<std::uint32_t>& neighbours_;
  std::size_t most_;
  std::vector<bool> is_taken_;
  SurfacePieces pieces_;
  std::vector<std::uint32_t> seeds_;
  // Of the piece that grows.
  std::vector<Candidate> candidates_;  // a heap
  std::uint32_t order_ = 0;
  Vec3f seed_;
};

}  // namespace

SurfacePieces surfacePieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                            const std::vector<std::uint32_t>& neighbours, std::size_t most) {
  return Grower(triangles, neighbours, most).grow(limit);
}

}  // namespace deformable_contact_monitor
