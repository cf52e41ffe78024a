// Random pairs of triangles that touch, lie in one plane or are degenerate.
#include "hard_pairs.h"

#include <cmath>

namespace deformable_contact_monitor {
namespace {

Vec3f inPlane(const Triangle& t, float s, float r) {
  return t.v[0] + (t.v[1] - t.v[0]) * s + (t.v[2] - t.v[0]) * r;
}

TrianglesPair vertexOnFace(GridDice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  b.v[dice->within(0, 2)] = inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  return {a, b};
}

TrianglesPair vertexOnEdge(GridDice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  b.v[dice->within(0, 2)] = inPlane(a, dice->eighths(-3, 11), 0);
  return {a, b};
}

TrianglesPair edgeThroughEdge(GridDice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  const Vec3f p = inPlane(a, dice->eighths(-2, 10), 0), d = dice->point(100);
  b.v[0] = p + d * static_cast<float>(dice->within(-1, 2));
  b.v[1] = p - d * static_cast<float>(dice->within(0, 3));
  return {a, b};
}

TrianglesPair edgeInPlane(GridDice* dice) {
  const Triangle a = dice->triangle(500);
  Triangle b = dice->triangle(500);
  const int k = dice->within(0, 2);
  b.v[k] = inPlane(a, dice->eighths(-4, 12), dice->eighths(-4, 12));
  b.v[k == 2 ? 0 : k + 1] = inPlane(a, dice->eighths(-4, 12), dice->eighths(-4, 12));
  return {a, b};
}

TrianglesPair inOnePlane(GridDice* dice) {
  const Triangle plane = dice->triangle(60);
  TrianglesPair pair;
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = inPlane(plane, dice->eighths(-16, 16), dice->eighths(-16, 16));
  }
  return pair;
}

TrianglesPair nearlyInOnePlane(GridDice* dice) {
  TrianglesPair pair = inOnePlane(dice);
  if (dice->half()) {
    float& x = pair.b.v[dice->within(0, 2)].z;
    x = std::nextafter(x, dice->half() ? INFINITY : -INFINITY);
  }
  return pair;
}

TrianglesPair smallGrid(GridDice* dice) { return {dice->triangle(1), dice->triangle(1)}; }

TrianglesPair sharedCorner(GridDice* dice) {
  TrianglesPair pair{dice->triangle(2000), dice->triangle(2000)};
  for (int k = dice->within(1, 3); k > 0; --k) {
    pair.b.v[dice->within(0, 2)] = pair.a.v[dice->within(0, 2)];
  }
  return pair;
}

TrianglesPair degenerate(GridDice* dice) {
  const Triangle a = dice->triangle(100);
  Triangle b = dice->triangle(100);
  b.v[0] = inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  b.v[1] = dice->half() ? b.v[0] : inPlane(a, dice->eighths(-1, 5), dice->eighths(-1, 5));
  b.v[2] =
      dice->half() ? b.v[0] : b.v[0] + (b.v[1] - b.v[0]) * static_cast<float>(dice->within(-1, 2));
  return dice->half() ? TrianglesPair{a, b} : TrianglesPair{b, a};
}

// Exponents so far apart that integers do not do; the plane z = x holds all of a.
TrianglesPair farApartExponents(GridDice* dice) {
  const auto any = [dice] {
    return std::ldexp(static_cast<float>(dice->within(-8388607, 8388607)), dice->within(-70, 0));
  };
  TrianglesPair pair;
  for (Vec3f& v : pair.a.v) {
    v = {any(), any(), 0};
    v.z = v.x;
  }
  for (Vec3f& v : pair.b.v) v = {any(), any(), any()};
  Vec3f& touching = pair.b.v[dice->within(0, 2)];
  if (dice->half()) touching = (pair.a.v[0] + pair.a.v[1] + pair.a.v[2]) * (1.0F / 3);
  touching.z = touching.x;
  return pair;
}

}  // namespace

std::vector<HardPairClass> hardPairClasses() {
  return {{"vertex_on_face", vertexOnFace},
          {"vertex_on_edge", vertexOnEdge},
          {"edge_through_edge", edgeThroughEdge},
          {"edge_in_plane", edgeInPlane},
          {"in_one_plane", inOnePlane},
          {"nearly_in_one_plane", nearlyInOnePlane},
          {"small_grid", smallGrid},
          {"shared_corner", sharedCorner},
          {"degenerate", degenerate},
          {"far_apart_exponents", farApartExponents}};
}

TrianglesPair scaledBy(TrianglesPair pair, int power) {
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) {
      v = {std::ldexp(v.x, power), std::ldexp(v.y, power), std::ldexp(v.z, power)};
    }
  }
  return pair;
}

}  // namespace deformable_contact_monitor
