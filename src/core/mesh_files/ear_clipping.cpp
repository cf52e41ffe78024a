// Triangulates a polygon by cutting off ears (Meisters, "Polygons have ears", 1975). An ear is a
// corner whose triangle with its two neighbours lies within the polygon. Each cut may make ears of
// the two neighbours only, so few corners are tested twice (O'Rourke, "Computational Geometry in
// C", 1998). A polygon that touches itself nowhere always has an ear. For others, the result is
// checked: triangles that turn left and do not overlap cover what the polygon winds around.
#include "core/mesh_files/ear_clipping.h"

#include <algorithm>
#include <cstddef>
#include <deque>
#include <numeric>

#include "core/mesh_files/box_tree.h"

namespace deformable_contact_monitor {
namespace {

bool isSame(const Vec3f& a, const Vec3f& b) { return a.x == b.x && a.y == b.y; }
bool isBefore(const Vec3f& a, const Vec3f& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; }

// Returns whether b, on one line with a and c, is strictly between them.
bool isBetween(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  return (isBefore(a, b) && isBefore(b, c)) || (isBefore(c, b) && isBefore(b, a));
}

// Returns whether there are more sides than a polygon without crossings can have: its corners are
// those of a plane graph, which has less than three edges for each, and a side leads along each
// edge in each direction once. Nothing else would end soon where many sides lie on each other.
bool hasTooManySides(std::vector<Vec3f> corners) {
  corners.erase(std::unique(corners.begin(), corners.end(), isSame), corners.end());
  const std::size_t sides = corners.size();
  std::sort(corners.begin(), corners.end(), isBefore);
  const auto end = std::unique(corners.begin(), corners.end(), isSame);
  return sides > 6 * static_cast<std::size_t>(end - corners.begin());
}

enum class Contact { kNone, kTouch, kCross };

// Tells how the segments a b and c d meet.
Contact contactOf(const Vec3f& a, const Vec3f& b, const Vec3f& c, const Vec3f& d) {
  const int at_ab = turn(a, b, c) * turn(a, b, d);
  if (at_ab > 0) return Contact::kNone;
  const int at_cd = turn(c, d, a) * turn(c, d, b);
  if (at_cd > 0) return Contact::kNone;
  // Segments on one line, whose boxes meet, touch.
  return at_ab < 0 && at_cd < 0 ? Contact::kCross : Contact::kTouch;
}

// Tells whether sides of the polygon meet other than in the corner that two neighbours share.
Contact selfContact(const std::vector<Vec3f>& corners, std::uint64_t* work) {
  const std::size_t size = corners.size();
  std::vector<PlaneBox> boxes(size);
  for (std::size_t i = 0; i < size; ++i) {
    boxes[i].add(corners[i]);
    boxes[i].add(corners[(i + 1) % size]);
  }
  const PlaneBoxTree sides(boxes, work);
  Contact worst = Contact::kNone;
  for (std::size_t i = 0; i < size && worst != Contact::kCross; ++i) {
    const Vec3f &a = corners[i], &b = corners[(i + 1) % size];
    sides.anyOf(PlaneTriangle(a, b, b), [&](std::size_t j) {
      if (j <= i) return false;
      const Vec3f &c = corners[j], &d = corners[(j + 1) % size];
      Contact contact = contactOf(a, b, c, d);
      if (j == i + 1 || j + 1 - i == size) {
        const Vec3f &from = j == i + 1 ? a : c, &middle = j == i + 1 ? b : a,
                    &to = j == i + 1 ? d : b;
        const bool is_straight = turn(from, middle, to) != 0 || isBetween(from, middle, to);
        contact = is_straight ? Contact::kNone : Contact::kTouch;
      }
      worst = std::max(worst, contact);
      return worst == Contact::kCross;
    });
  }
  return worst;
}

// Cuts the ears of one polygon. run() may be called once.
class EarClipper {
 public:
  EarClipper(const std::vector<Vec3f>& corners, std::uint64_t* work)
      : corners_(corners),
        work_(work),
        previous_(corners.size()),
        next_(corners.size()),
        is_queued_(corners.size(), 1),
        has_twin_(corners.size(), 0),
        queue_(corners.size()),
        blockers_(std::vector<PlaneBox>(corners.size()), work) {
    const auto size = static_cast<std::uint32_t>(corners.size());
    for (std::uint32_t i = 0; i < size; ++i) {
      previous_[i] = i == 0 ? size - 1 : i - 1;
      next_[i] = i + 1 == size ? 0 : i + 1;
    }
    std::iota(queue_.begin(), queue_.end(), 0U);
    findTwins();
    for (std::uint32_t i = 0; i < size; ++i) updateBlocker(i);
  }

  std::optional<std::vector<PolygonTriangle>> run() {
    bool is_strict = true, any_cut = true;
    std::size_t left = corners_.size();
    while (left > 3) {
      if (queue_.empty()) {
        if (!any_cut) return std::nullopt;
        is_strict = any_cut = false;
        for (std::uint32_t i = 0; i < corners_.size(); ++i) enqueue(i);
      }
      const std::uint32_t tip = queue_.front();
      queue_.pop_front();
      is_queued_[tip] = 0;
      if (*work_ == 0) return std::nullopt;
      --*work_;
      if (isCut(tip) || !isEar(tip, is_strict)) continue;
      cut(tip);
      any_cut = true;
      --left;
    }
    std::uint32_t last = 0;
    while (isCut(last)) ++last;
    if (turnAt(last) < 0) return std::nullopt;
    triangles_.push_back({previous_[last], last, next_[last]});
    return std::move(triangles_);
  }

 private:
  // Marks corners that another corner is at the same place as.
  void findTwins() {
    std::vector<std::uint32_t> order(corners_.size());
    std::iota(order.begin(), order.end(), 0U);
    std::sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return isBefore(corners_[a], corners_[b]);
    });
    for (std::size_t i = 1; i < order.size(); ++i) {
      if (!isSame(corners_[order[i - 1]], corners_[order[i]])) continue;
      has_twin_[order[i - 1]] = has_twin_[order[i]] = 1;
    }
  }

  bool isCut(std::uint32_t corner) const { return next_[corner] == corner; }
  int turnAt(std::uint32_t corner) const {
    return turn(corners_[previous_[corner]], corners_[corner], corners_[next_[corner]]);
  }

  void enqueue(std::uint32_t corner) {
    if (isCut(corner) || is_queued_[corner] != 0) return;
    is_queued_[corner] = 1;
    queue_.push_back(corner);
  }

  // Only corners that do not turn left, and those with a twin, can be in the way of an ear: of all
  // others in its triangle, one that turns right is nearer to the tip.
  void updateBlocker(std::uint32_t corner) {
    PlaneBox box;
    if (has_twin_[corner] != 0 || turnAt(corner) <= 0) box.add(corners_[corner]);
    blockers_.set(corner, box);
  }

  // Returns whether a side at this corner leads to the left of the line from a to b.
  bool leadsLeft(std::uint32_t corner, const Vec3f& a, const Vec3f& b) const {
    return turn(a, b, corners_[previous_[corner]]) > 0 || turn(a, b, corners_[next_[corner]]) > 0;
  }

  // Returns whether a side of `corner`, which is at the triangle's corner i, leads into it.
  bool leadsInto(std::uint32_t corner, const PlaneTriangle& triangle, std::size_t i) const {
    const Vec3f &at = triangle.corner(i), &right = triangle.corner((i + 1) % 3),
                &left = triangle.corner((i + 2) % 3);
    const auto is_inside = [&](const Vec3f& p) {
      return turn(at, right, p) > 0 && turn(at, left, p) < 0;
    };
    return is_inside(corners_[previous_[corner]]) || is_inside(corners_[next_[corner]]);
  }

  // Returns whether a corner keeps the triangle from being an ear: it is within, or on a side. If
  // it is on a side, it may be that the polygon only touches the triangle there.
  bool blocks(std::uint32_t corner, const PlaneTriangle& triangle, bool is_strict) const {
    const Vec3f& p = corners_[corner];
    for (std::size_t i = 0; i < 3; ++i) {
      if (isSame(p, triangle.corner(i))) return leadsInto(corner, triangle, i);
    }
    bool is_within = true, leads_in = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3f &from = triangle.corner(i), &to = triangle.corner((i + 1) % 3);
      const int side = turn(from, to, p);
      if (side < 0) return false;
      if (side > 0) continue;
      is_within = false;
      leads_in = leadsLeft(corner, from, to);
    }
    return is_within || is_strict || leads_in;
  }

  // A tip without area is cut off at once if the polygon goes there and back, or stays there. A tip
  // on the line between its neighbours is kept as long as there are others.
  bool isEar(std::uint32_t tip, bool is_strict) const {
    const std::uint32_t before = previous_[tip], after = next_[tip];
    const Vec3f &a = corners_[before], &b = corners_[tip], &c = corners_[after];
    const int sense = turn(a, b, c);
    if (sense < 0) return false;
    if (sense == 0) return !is_strict || !isBetween(a, b, c);
    const PlaneTriangle triangle(a, b, c);
    return !blockers_.anyOf(triangle, [&](std::size_t item) {
      const auto corner = static_cast<std::uint32_t>(item);
      return corner != before && corner != tip && corner != after &&
             blocks(corner, triangle, is_strict);
    });
  }

  void cut(std::uint32_t tip) {
    const std::uint32_t before = previous_[tip], after = next_[tip];
    triangles_.push_back({before, tip, after});
    next_[before] = after;
    previous_[after] = before;
    next_[tip] = tip;
    blockers_.set(tip, PlaneBox());
    for (const std::uint32_t neighbour : {before, after}) {
      updateBlocker(neighbour);
      enqueue(neighbour);
    }
  }

  const std::vector<Vec3f>& corners_;
  std::uint64_t* work_;
  std::vector<std::uint32_t> previous_, next_;  // of corners that are not cut off
  std::vector<char> is_queued_, has_twin_;
  std::deque<std::uint32_t> queue_;  // corners to test
  PlaneBoxTree blockers_;
  std::vector<PolygonTriangle> triangles_;
};

// Returns whether all corners of b are on the right of one side of a, or on it.
bool isBeyondASide(const PlaneTriangle& a, const PlaneTriangle& b) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3f &from = a.corner(i), &to = a.corner((i + 1) % 3);
    if (turn(from, to, b.corner(0)) <= 0 && turn(from, to, b.corner(1)) <= 0 &&
        turn(from, to, b.corner(2)) <= 0) {
      return true;
    }
  }
  return false;
}

// Returns whether the interiors of two of the triangles meet. Also true if there is no more work
// allowed.
bool overlap(const std::vector<Vec3f>& corners, const std::vector<PolygonTriangle>& triangles,
             std::uint64_t* work) {
  std::vector<PlaneTriangle> solid;
  std::vector<PlaneBox> boxes;
  for (const auto& [a, b, c] : triangles) {
    if (turn(corners[a], corners[b], corners[c]) == 0) continue;
    solid.emplace_back(corners[a], corners[b], corners[c]);
    boxes.push_back(solid.back().box());
  }
  const PlaneBoxTree tree(boxes, work);
  for (std::size_t i = 0; i < solid.size(); ++i) {
    const bool any = tree.anyOf(solid[i], [&](std::size_t j) {
      return j > i && !isBeyondASide(solid[i], solid[j]) && !isBeyondASide(solid[j], solid[i]);
    });
    if (any) return true;
  }
  return false;
}

}  // namespace

std::optional<std::vector<PolygonTriangle>> clipEars(const std::vector<Vec3f>& corners,
                                                     std::uint64_t* work) {
  if (hasTooManySides(corners)) return std::nullopt;
  const Contact contact = selfContact(corners, work);
  if (contact == Contact::kCross || *work == 0) return std::nullopt;
  std::optional<std::vector<PolygonTriangle>> triangles = EarClipper(corners, work).run();
  if (triangles && contact == Contact::kTouch && overlap(corners, *triangles, work)) {
    return std::nullopt;
  }
  return triangles;
}

}  // namespace deformable_contact_monitor
