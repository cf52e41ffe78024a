#include "moving_pairs.h"

#include <cmath>

namespace deformable_contact_monitor {
namespace {

Vec3f& vertex(MovingTriangle& t, int state, int i) { return (state == 0 ? t.from : t.to).v[i]; }

template <class Change>
void changeAll(MovingPair& pair, const Change& change) {
  for (MovingTriangle* t : {&pair.a, &pair.b}) {
    for (int state = 0; state < 2; ++state) {
      for (int i = 0; i < 3; ++i) change(vertex(*t, state, i));
    }
  }
}

MovingPair tinyGrid(MotionDice* dice) { return dice->pair(1); }
MovingPair smallGrid(MotionDice* dice) { return dice->pair(3); }
MovingPair largeGrid(MotionDice* dice) { return dice->pair(500); }

MovingPair offTheGrid(MotionDice* dice) {
  MovingPair pair = dice->pair(500);
  changeAll(pair, [dice](Vec3f& v) {
    v = v + dice->point(8388607) * (1.0F / 8388608) + dice->point(8388607) * 1e-10F;
  });
  return pair;
}

// Small steps of small triangles: most of them begin apart.
MovingPair smallSteps(MotionDice* dice) {
  MovingPair pair = dice->pair(12);
  pair.a.to = pair.a.from;
  pair.b.to = pair.b.from;
  for (int i = 0; i < 3; ++i) {
    pair.a.to.v[i] = pair.a.from.v[i] + dice->point(3);
    pair.b.to.v[i] = pair.b.from.v[i] + dice->point(3);
  }
  return pair;
}

// A vertex of b meets a point in a's plane, inside or not, at a time of k / 8.
MovingPair vertexMeetsPlane(MotionDice* dice) {
  MovingPair pair = dice->pair(40);
  const int k = dice->within(1, 7), s = dice->within(-1, 5), r = dice->within(-1, 5);
  const auto inPlane = [s, r](const Triangle& t) {  // times 4
    return t.v[0] * static_cast<float>(4 - s - r) + t.v[1] * static_cast<float>(s) +
           t.v[2] * static_cast<float>(r);
  };
  const Vec3f away = dice->point(20), from = inPlane(pair.a.from), to = inPlane(pair.a.to);
  changeAll(pair, [](Vec3f& v) { v = v * 4.0F; });
  const int i = dice->within(0, 2);
  pair.b.from.v[i] = from + away * static_cast<float>(k);
  pair.b.to.v[i] = to - away * static_cast<float>(8 - k);
  return pair;
}

// A point of an edge of b meets a point of an edge of a, ends included, at a time of k / 6.
MovingPair edgeMeetsEdge(MotionDice* dice) {
  MovingPair pair = dice->pair(40);
  const int k = dice->within(0, 6), s = dice->within(-1, 5), along = dice->within(0, 4);
  const Vec3f away = dice->point(10);
  const auto onEdge = [s](const Triangle& t) {  // times 4
    return t.v[0] * static_cast<float>(4 - s) + t.v[1] * static_cast<float>(s);
  };
  const Vec3f from = onEdge(pair.a.from) + away * static_cast<float>(k);
  const Vec3f to = onEdge(pair.a.to) - away * static_cast<float>(6 - k);
  changeAll(pair, [](Vec3f& v) { v = v * 4.0F; });
  const Vec3f d0 = dice->point(40), d1 = dice->point(40);
  pair.b.from.v[0] = from - d0 * static_cast<float>(along);
  pair.b.from.v[1] = from + d0 * static_cast<float>(4 - along);
  pair.b.to.v[0] = to - d1 * static_cast<float>(along);
  pair.b.to.v[1] = to + d1 * static_cast<float>(4 - along);
  return pair;
}

float& coordinate(Vec3f& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

// A vertex of b comes to the line of an edge of a, and always has one coordinate in common with it.
// The time is a root of a quadratic, mostly not a rational one.
MovingPair levelVertexMeetsEdge(MotionDice* dice) {
  MovingPair pair = dice->pair(20);
  const int axis = dice->within(0, 2), s = dice->within(-1, 5), i = dice->within(0, 2);
  for (int state = 0; state < 2; ++state) {
    const float level = coordinate(vertex(pair.a, state, 0), axis);
    coordinate(vertex(pair.a, state, 1), axis) = level;
    const Vec3f on_edge = vertex(pair.a, state, 0) * static_cast<float>(4 - s) +
                          vertex(pair.a, state, 1) * static_cast<float>(s);
    Vec3f way = dice->point(7);
    coordinate(way, axis) = 0;
    vertex(pair.b, state, i) = (state == 0 ? on_edge + way : on_edge - way) * 0.25F;
  }
  changeAll(pair, [](Vec3f& v) { v = v * 4.0F; });
  return pair;
}

// The two are images of each other, and each may go through the plane of symmetry.
MovingPair mirrored(MotionDice* dice) {
  MovingPair pair = dice->pair(12);
  if (dice->half()) {
    for (int i = 0; i < 3; ++i) {  // begins on one side
      pair.a.from.v[i].y = static_cast<float>(dice->within(0, 9));
      pair.a.to.v[i].y = static_cast<float>(dice->within(-9, 1));
    }
  }
  for (int i = 0; i < 3; ++i) {
    for (int state = 0; state < 2; ++state) {
      const Vec3f& v = vertex(pair.a, state, i);
      vertex(pair.b, state, i) = {v.x, -v.y, v.z};
    }
  }
  return pair;
}

MovingPair inOnePlane(MotionDice* dice) {
  MovingPair pair = dice->pair(dice->half() ? 3 : 9);
  const bool tilted = dice->half();
  changeAll(pair, [tilted](Vec3f& v) { v.z = tilted ? v.x - 2 * v.y : 0.0F; });
  if (dice->half()) {  // a plane that moves
    for (int i = 0; i < 3; ++i) {
      pair.a.to.v[i].z += 5;
      pair.b.to.v[i].z += 5;
    }
  }
  return pair;
}

MovingPair onOneLine(MotionDice* dice) {
  MovingPair pair = dice->pair(12);
  changeAll(pair, [](Vec3f& v) { v = {v.x, 2 * v.x, -v.x}; });
  return pair;
}

// Segments and points, in one state or in both.
MovingPair degenerate(MotionDice* dice) {
  MovingPair pair = dice->pair(dice->half() ? 2 : 6);
  for (MovingTriangle* t : {&pair.a, &pair.b}) {
    for (int state = 0; state < 2; ++state) {
      const int kind = dice->within(0, 3);
      Vec3f &p = vertex(*t, state, 0), &q = vertex(*t, state, 1), &r = vertex(*t, state, 2);
      if (kind == 1) r = p + (q - p) * static_cast<float>(dice->within(-1, 2));
      if (kind == 2) q = p;
      if (kind == 3) q = r = p;
    }
  }
  return pair;
}

MovingPair oneIsStill(MotionDice* dice) {
  MovingPair pair = dice->pair(dice->half() ? 3 : 40);
  pair.a.to = pair.a.from;
  if (dice->within(0, 3) == 0) pair.b.to = pair.b.from;
  return pair;
}

// Both move as one, and a vertex or an edge of b may slide on a.
MovingPair sliding(MotionDice* dice) {
  MovingPair pair = dice->pair(6);
  const Vec3f step = dice->point(6), slide = dice->point(2);
  for (int i = 0; i < 3; ++i) {
    pair.a.to.v[i] = pair.a.from.v[i] + step;
    pair.b.to.v[i] = pair.b.from.v[i] + step + (dice->half() ? slide : Vec3f{0, 0, 0});
  }
  return pair;
}

// A vertex comes near a still face or edge and leaves, or just touches it: its height above the
// plane is a product of two linear functions, or their sum.
MovingPair turningBack(MotionDice* dice) {
  MovingPair pair = dice->pair(6);
  const int k = dice->within(1, 3);
  pair.a.from = {{{-8, -8, 0}, {8, -8, 0}, {0, 8, 0}}};
  pair.a.to = pair.a.from;
  for (int i = 0; i < 3; ++i) {
    pair.a.from.v[i].z = static_cast<float>(dice->within(-1, 1));
    pair.a.to.v[i].z = static_cast<float>(dice->within(-1, 1));
  }
  pair.b.from.v[0] = {static_cast<float>(-4 * k), 0, 1};
  pair.b.to.v[0] = {static_cast<float>(4 * (4 - k)), 0, 1};
  pair.b.from.v[1] = pair.b.from.v[0] + Vec3f{0, 0, 1};
  pair.b.to.v[1] = pair.b.to.v[0] + Vec3f{0, 0, 1};
  pair.b.from.v[2] = pair.b.from.v[0] + Vec3f{0, 1, 1};
  pair.b.to.v[2] = pair.b.to.v[0] + Vec3f{1, 0, 1};
  return pair;
}

// Exponents so far apart that fixed integers do not do.
MovingPair farApartExponents(MotionDice* dice) {
  MovingPair pair = dice->half() ? vertexMeetsPlane(dice) : smallGrid(dice);
  const int axis = dice->within(0, 2), power = dice->within(-70, 70);
  changeAll(pair, [axis, power](Vec3f& v) { coordinate(v, axis) = std::ldexp(v[axis], power); });
  const int i = dice->within(0, 2);
  if (dice->half()) pair.b.to.v[i].x = std::ldexp(static_cast<float>(dice->within(-9, 9)), 60);
  return pair;
}

MovingPair sharing(MotionDice* dice, MovingPair pair, int count) {
  const int turn = dice->within(0, 2);
  for (int i = 0; i < count; ++i) {
    const int j = (i + turn) % 3;
    pair.b.from.v[j] = pair.a.from.v[i];
    pair.b.to.v[j] = pair.a.to.v[i];
  }
  return pair;
}

MovingPair sharedVertex(MotionDice* dice) {
  return sharing(dice, dice->pair(dice->half() ? 2 : 8), 1);
}
MovingPair sharedVertexSmallSteps(MotionDice* dice) { return sharing(dice, smallSteps(dice), 1); }
MovingPair sharedVertexInOnePlane(MotionDice* dice) { return sharing(dice, inOnePlane(dice), 1); }
MovingPair sharedVertexLevelEdge(MotionDice* dice) {
  MovingPair pair = levelVertexMeetsEdge(dice);
  const int i = dice->within(0, 2), j = dice->within(0, 2);
  pair.b.from.v[j] = pair.a.from.v[i];
  pair.b.to.v[j] = pair.a.to.v[i];
  return pair;
}
MovingPair sharedVertexMirrored(MotionDice* dice) {
  MovingPair pair = mirrored(dice);
  for (MovingTriangle* t : {&pair.a, &pair.b}) t->from.v[0].y = t->to.v[0].y = 0;
  return pair;
}
MovingPair sharedVertexDegenerate(MotionDice* dice) { return sharing(dice, degenerate(dice), 1); }
MovingPair sharedVertexOnOneLine(MotionDice* dice) { return sharing(dice, onOneLine(dice), 1); }
MovingPair sharedEdge(MotionDice* dice) {
  return sharing(dice, dice->pair(dice->half() ? 2 : 8), 2);
}
MovingPair sharedEdgeInOnePlane(MotionDice* dice) { return sharing(dice, inOnePlane(dice), 2); }
MovingPair sharedEdgeDegenerate(MotionDice* dice) { return sharing(dice, degenerate(dice), 2); }
MovingPair sharedEdgeOnOneLine(MotionDice* dice) { return sharing(dice, onOneLine(dice), 2); }

// In one state or in both a is folded into the shared vertex, or so that its edge runs through it.
MovingPair foldedIntoVertex(MotionDice* dice) {
  MovingPair pair = dice->pair(4);
  for (int state = 0; state < 2; ++state) {
    Vec3f &p = vertex(pair.a, state, 0), &q = vertex(pair.a, state, 1),
          &r = vertex(pair.a, state, 2);
    const int kind = dice->within(0, 3);
    if (kind == 0) q = r = p;
    if (kind == 1) r = p + p - q;
    if (kind == 2) q = p;
  }
  const bool flat = dice->half();
  if (flat) changeAll(pair, [](Vec3f& v) { v.z = 0; });
  return sharing(dice, pair, 1);
}

// The edge of a runs through the shared vertex at t = 0 and at t = 1, not between: in contact only
// in an open interval.
MovingPair openInterval(MotionDice* dice) {
  MovingPair pair;
  pair.a.from = {{{0, 0, 0}, {1, 0, 0}, {-1, 0, 0}}};
  pair.a.to = {{{0, 0, 0}, {1, 1, 0}, {-2, -2, 0}}};
  const auto down = static_cast<float>(dice->within(1, 3));
  pair.b.from = {{{0, 0, 0},
                  {0, -down, static_cast<float>(dice->within(-1, 1))},
                  {0, -down, static_cast<float>(dice->within(-1, 1))}}};
  pair.b.to = pair.b.from;
  if (dice->half()) pair.b.to.v[1].x += 1;
  const Vec3f step = dice->point(3);
  for (int i = 0; i < 3; ++i) {
    pair.a.to.v[i] = pair.a.to.v[i] + step;
    pair.b.to.v[i] = pair.b.to.v[i] + step;
  }
  return pair;
}

}  // namespace

Vec3f MotionDice::point(int range) {
  const auto coordinate = [this, range] { return static_cast<float>(within(-range, range)); };
  const float x = coordinate(), y = coordinate();
  return {x, y, coordinate()};
}

Triangle MotionDice::triangle(int range) {
  Triangle t;
  for (Vec3f& v : t.v) v = point(range);
  return t;
}

const std::vector<MovingPairClass>& movingPairClasses() {
  static const std::vector<MovingPairClass> classes = {
      {"tiny_grid", tinyGrid},
      {"small_grid", smallGrid},
      {"large_grid", largeGrid},
      {"off_the_grid", offTheGrid},
      {"small_steps", smallSteps},
      {"vertex_meets_plane", vertexMeetsPlane},
      {"edge_meets_edge", edgeMeetsEdge},
      {"level_vertex_meets_edge", levelVertexMeetsEdge},
      {"mirrored", mirrored},
      {"in_one_plane", inOnePlane},
      {"on_one_line", onOneLine},
      {"degenerate", degenerate},
      {"one_is_still", oneIsStill},
      {"sliding", sliding},
      {"turning_back", turningBack},
      {"far_apart_exponents", farApartExponents}};
  return classes;
}

const std::vector<MovingPairClass>& sharingPairClasses() {
  static const std::vector<MovingPairClass> classes = {
      {"shared_vertex", sharedVertex},
      {"shared_vertex_small_steps", sharedVertexSmallSteps},
      {"shared_vertex_in_one_plane", sharedVertexInOnePlane},
      {"shared_vertex_level_edge", sharedVertexLevelEdge},
      {"shared_vertex_mirrored", sharedVertexMirrored},
      {"shared_vertex_degenerate", sharedVertexDegenerate},
      {"shared_vertex_on_one_line", sharedVertexOnOneLine},
      {"shared_edge", sharedEdge},
      {"shared_edge_in_one_plane", sharedEdgeInOnePlane},
      {"shared_edge_degenerate", sharedEdgeDegenerate},
      {"shared_edge_on_one_line", sharedEdgeOnOneLine},
      {"folded_into_vertex", foldedIntoVertex},
      {"open_interval", openInterval}};
  return classes;
}

MovingPair scaled(const MovingPair& pair, int power) {
  MovingPair result = pair;
  changeAll(result, [power](Vec3f& v) {
    v = {std::ldexp(v.x, power), std::ldexp(v.y, power), std::ldexp(v.z, power)};
  });
  return result;
}

}  // namespace deformable_contact_monitor
