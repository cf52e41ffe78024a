// Finds layers in four steps: copies of triangles become one piece, pieces become patches, patches
// with the same outline and vertices become one class, and sets of classes are tested for edges
// that an odd number of their patches has.
#include "core/analysis/surface_layers.h"

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>
#include <utility>

#include "core/analysis/union_find.h"

namespace deformable_contact_monitor {
namespace {

using EdgeKey = std::pair<std::uint32_t, std::uint32_t>;  // two vertices, ascending

constexpr int kCopyBits = 30;  // a bit for each power of two that numbers of copies can have
constexpr std::uint32_t kOnce = 1U << 30U, kAsCounted = 1U << 31U;

// All copies of a triangle.
struct Piece {
  std::array<std::uint32_t, 3> corners{};  // ascending
  std::uint32_t place = 0;                 // of a copy, in the list of triangles
  std::uint32_t count = 0;

  bool operator<(const Piece& o) const {
    return std::tie(corners, place) < std::tie(o.corners, o.place);
  }
};

// A piece at one of its edges.
struct Side {
  EdgeKey edge;
  std::uint32_t piece;

  bool operator<(const Side& o) const { return std::tie(edge, piece) < std::tie(o.edge, o.piece); }
};

// The patches that are copies of each other.
struct PatchClass {
  std::uint32_t patch = 0;  // one of them
  std::uint32_t count = 0;  // how many copies there are
};

template <class T>
void sort(const CycleLimit& limit, std::vector<T>* list) {
  sortWithin(limit, list->size(), std::less<>(),
             [list](const auto& order) { std::sort(list->begin(), list->end(), order); });
}

class LayerFinder {
 public:
  LayerFinder(const std::vector<SurfaceTriangle>& triangles, const CycleLimit& limit)
      : limit_(limit), triangle_count_(triangles.size()) {
    makePieces(triangles);
    if (!limit_.over()) makeSides();
    if (!limit_.over()) makePatches();
    if (!limit_.over()) makeClasses();
  }

  SurfaceLayers find();

 private:
  void makePieces(const std::vector<SurfaceTriangle>& triangles);
  void makeSides();
  void makePatches();
  void makeClasses();
  bool isClosedAsCounted() const;
  template <class Chosen>
  bool isClosed(const Chosen& chosen) const;
  template <class Visit>
  void forEdges(const Visit& visit) const;

  const CycleLimit& limit_;
  std::size_t triangle_count_;
  std::vector<Piece> pieces_;
  std::vector<Side> sides_;                     // sorted by edge
  std::vector<std::uint32_t> patch_of_;         // per piece
  std::vector<std::vector<EdgeKey>> outlines_;  // per patch, ascending
  std::vector<PatchClass> classes_;
  std::vector<std::uint32_t> class_of_;  // per patch
};

void LayerFinder::makePieces(const std::vector<SurfaceTriangle>& triangles) {
  std::vector<Piece> all;
  all.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Piece piece{triangles[i].corners, static_cast<std::uint32_t>(i), 1};
    std::sort(piece.corners.begin(), piece.corners.end());
    all.push_back(piece);
  }
  sort(limit_, &all);
  for (const Piece& piece : all) {
    if (!pieces_.empty() && pieces_.back().corners == piece.corners) {
      ++pieces_.back().count;
    } else {
      pieces_.push_back(piece);
    }
  }
}

void LayerFinder::makeSides() {
  sides_.reserve(3 * pieces_.size());
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    const auto& c = pieces_[i].corners;
    sides_.push_back({{c[0], c[1]}, i});
    sides_.push_back({{c[1], c[2]}, i});
    sides_.push_back({{c[0], c[2]}, i});
  }
  sort(limit_, &sides_);
}

// Calls visit(begin, end) with the sides of each edge.
template <class Visit>
void LayerFinder::forEdges(const Visit& visit) const {
  for (auto begin = sides_.begin(); begin != sides_.end();) {
    auto end = begin;
    while (end != sides_.end() && end->edge == begin->edge) ++end;
    visit(begin, end);
    begin = end;
  }
}

// Numbers the patches. The outline of a patch consists of the edges that an odd number of its
// pieces has.
void LayerFinder::makePatches() {
  UnionFind joined(pieces_.size());
  forEdges([&joined](auto begin, auto end) {
    if (end - begin == 2) joined.join(begin[0].piece, begin[1].piece);
  });
  patch_of_.resize(pieces_.size());
  std::uint32_t count = 0;
  for (std::uint32_t i = 0; i < pieces_.size(); ++i) {
    const std::uint32_t root = joined.find(i);
    patch_of_[i] = root == i ? count++ : patch_of_[root];
  }
  outlines_.resize(count);
  std::vector<std::uint32_t> patches;
  forEdges([&](auto begin, auto end) {
    if (end - begin == 2) return;
    patches.clear();
    for (auto side = begin; side != end; ++side) patches.push_back(patch_of_[side->piece]);
    std::sort(patches.begin(), patches.end());
    for (std::size_t i = 0; i < patches.size();) {
      const std::size_t first = i;
      while (i < patches.size() && patches[i] == patches[first]) ++i;
      if ((i - first) % 2 != 0) outlines_[patches[first]].push_back(begin->edge);
    }
  });
}

// Groups patches that are copies of each other. A patch without an outline is closed by itself.
void LayerFinder::makeClasses() {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> corners;  // patch, vertex
  std::vector<std::uint32_t> copies(outlines_.size(), ~std::uint32_t{0});
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    copies[patch_of_[i]] = std::min(copies[patch_of_[i]], pieces_[i].count);
    for (const std::uint32_t v : pieces_[i].corners) corners.emplace_back(patch_of_[i], v);
  }
  sort(limit_, &corners);
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  if (limit_.over()) return;
  std::map<std::pair<std::vector<EdgeKey>, std::vector<std::uint32_t>>, std::uint32_t> known;
  auto corner = corners.begin();
  for (std::uint32_t p = 0; p < outlines_.size(); ++p) {
    std::vector<std::uint32_t> vertices;
    for (; corner != corners.end() && corner->first == p; ++corner) {
      vertices.push_back(corner->second);
    }
    auto number = static_cast<std::uint32_t>(classes_.size());
    if (!outlines_[p].empty()) {
      number = known.emplace(std::pair(outlines_[p], std::move(vertices)), number).first->second;
    }
    if (number == classes_.size()) classes_.push_back({p, 0});
    classes_[number].count += copies[p];
    class_of_.push_back(number);
  }
}

bool LayerFinder::isClosedAsCounted() const {
  bool closed = true;
  forEdges([&](auto begin, auto end) {
    std::uint32_t count = 0;
    for (auto side = begin; side != end; ++side) count += pieces_[side->piece].count;
    closed = closed && count % 2 == 0;
  });
  return closed;
}

// Returns whether each edge has an even number of the patches of the chosen classes.
template <class Chosen>
bool LayerFinder::isClosed(const Chosen& chosen) const {
  std::vector<EdgeKey> edges;
  for (const PatchClass& of : classes_) {
    if (!chosen(of.count)) continue;
    edges.insert(edges.end(), outlines_[of.patch].begin(), outlines_[of.patch].end());
  }
  sort(limit_, &edges);
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    if (i + 1 == edges.size() || edges[i] != edges[i + 1]) return false;
  }
  return true;
}

SurfaceLayers LayerFinder::find() {
  std::uint32_t layers = isClosedAsCounted() ? kAsCounted : 0;
  if (isClosed([](std::uint32_t) { return true; })) layers |= kOnce;
  for (int k = 0; k < kCopyBits; ++k) {
    const std::uint32_t bit = 1U << static_cast<unsigned>(k);
    const auto has_bit = [bit](std::uint32_t count) { return (count & bit) != 0; };
    const bool any = std::any_of(classes_.begin(), classes_.end(),
                                 [&](const PatchClass& c) { return has_bit(c.count); });
    if (any && isClosed(has_bit)) layers |= bit;
  }
  SurfaceLayers result;
  result.of.assign(triangle_count_, 0);
  bool any = false, all_odd = true;
  for (std::size_t i = 0; i < pieces_.size(); ++i) {
    const PatchClass& of = classes_[class_of_[patch_of_[i]]];
    const bool is_first = of.patch == patch_of_[i];
    std::uint32_t in = pieces_[i].count % 2 != 0 ? kAsCounted : 0;
    if (is_first) in |= kOnce | (of.count & (kOnce - 1));
    in &= layers;
    result.of[pieces_[i].place] = in;
    any = any || in != 0;
    all_odd = all_odd && (in != 0 || !is_first || of.count % 2 == 0);
  }
  result.closed = any && all_odd;
  return result;
}

}  // namespace

SurfaceLayers findLayers(const std::vector<SurfaceTriangle>& triangles, const CycleLimit& limit) {
  LayerFinder finder(triangles, limit);
  if (limit.over()) return {};
  return finder.find();
}

}  // namespace deformable_contact_monitor
