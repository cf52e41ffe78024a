// Prints how often verdicts on hard pairs of triangles are wrong, class by class: this package's
// predicates, FCL's and a plain float32 Moeller test, against CGAL's exact predicates.
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "cgal_oracle.h"
#include "core/narrow_phase.h"
#include "moller.h"
#include "scenes.h"
#ifdef DCM_HAVE_FCL
#include "reference/fcl_detector.h"
#endif

namespace deformable_contact_monitor {
namespace {

constexpr int kPairs = 4000;

// Coordinates are multiples of 2^-20 m of a few decimetres: sums of some, and eighths of
// differences, are exact in float32.
class Dice {
 public:
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  float metres(int most) { return static_cast<float>(within(-most, most)) * 0x1p-20F; }
  Vec3f point(int most) { return {metres(most), metres(most), metres(most)}; }
  Triangle triangle(int most) { return {{point(most), point(most), point(most)}}; }
  float eighths() { return static_cast<float>(within(0, 4)) / 8; }

 private:
  std::mt19937 random_{1};
};

struct Pair {
  Triangle a, b;
};

constexpr int kDecimetre = 0x20000;  // an eighth of a metre, in steps; a multiple of 8

Triangle steps(Triangle t) {  // whole multiples of 8 steps, so that eighths stay on the grid
  for (Vec3f& v : t.v) {
    v = {std::round(v.x * 0x1p17F) * 0x1p-17F, std::round(v.y * 0x1p17F) * 0x1p-17F,
         std::round(v.z * 0x1p17F) * 0x1p-17F};
  }
  return t;
}

Vec3f onFace(const Triangle& t, float s, float r) {
  return t.v[0] + (t.v[1] - t.v[0]) * s + (t.v[2] - t.v[0]) * r;
}

Pair vertexOnFace(Dice* dice) {
  const Triangle a = steps(dice->triangle(kDecimetre));
  const Vec3f p = onFace(a, dice->eighths(), dice->eighths());
  // The others on one side, so that only the vertex touches.
  const Vec3f u = a.v[1] - a.v[0], w = a.v[2] - a.v[0];
  Vec3f n{u.y * w.z - u.z * w.y, u.z * w.x - u.x * w.z, u.x * w.y - u.y * w.x};
  n = n * (1 / std::sqrt(dot(n, n) + 1e-30F));
  Triangle b{{p, p + n * 0.05F + dice->point(9000), p + n * 0.05F + dice->point(9000)}};
  return {a, b};
}

Pair vertexOnEdge(Dice* dice) {
  Pair pair = vertexOnFace(dice);
  const Vec3f shift = onFace(pair.a, dice->eighths(), 0) - pair.b.v[0];
  for (Vec3f& v : pair.b.v) v = v + shift;
  return pair;
}

Pair aMicrometreOff(Dice* dice) {
  Pair pair = vertexOnFace(dice);
  const Vec3f d = (pair.b.v[1] - pair.b.v[0]) * 1e-5F;  // about a micrometre off the face
  for (Vec3f& v : pair.b.v) v = v + d;
  return pair;
}

Pair coplanar(Dice* dice) {
  const Triangle plane = steps(dice->triangle(kDecimetre));
  Pair pair;
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = onFace(plane, dice->eighths(), dice->eighths());
  }
  return pair;
}

Pair millimetres(Dice* dice) {
  const auto place = dice->point(kDecimetre);
  Pair pair{dice->triangle(700), dice->triangle(700)};
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = v + place;
  }
  return pair;
}

Pair parallelMillimetres(Dice* dice) {
  Pair pair = millimetres(dice);
  pair.b = pair.a;
  const Vec3f up{0, 0, 0x1p-20F * static_cast<float>(dice->within(1, 500))};
  for (Vec3f& v : pair.b.v) v = v + up;
  return pair;
}

Pair general(Dice* dice) { return {dice->triangle(kDecimetre), dice->triangle(kDecimetre)}; }

struct Method {
  std::string name;
  std::function<bool(const Triangle&, const Triangle&)> intersects;
};

std::function<bool(const Triangle&, const Triangle&)> ours(Predicates mode) {
  return [mode](const Triangle& a, const Triangle& b) {
    PredicateState state;
    state.mode = mode;
    return pairVerdict(a, b, false, AdjacentPairs::kSkip, 0, state).contact;
  };
}

int run() {
  std::vector<Method> methods = {{"exact", ours(Predicates::kExact)},
                                 {"conservative", ours(Predicates::kConservative)},
                                 {"fast", ours(Predicates::kFast)}};
#ifdef DCM_HAVE_FCL
  const auto fcl = makeFclDetector();
  methods.push_back({"FCL", [&fcl](const Triangle& a, const Triangle& b) {
                       const Scene scene = pairScene(meshOf({a}), meshOf({b}));
                       return !fcl->detect(scene, Options()).contacts.empty();
                     }});
#endif
  methods.push_back({"Moeller float32", mollerIntersects});
  const std::vector<std::pair<const char*, Pair (*)(Dice*)>> classes = {
      {"general position", general},          {"vertex on face", vertexOnFace},
      {"vertex on edge", vertexOnEdge},       {"coplanar", coplanar},
      {"1 um off a face", aMicrometreOff},    {"1 mm triangles", millimetres},
      {"1 mm, parallel", parallelMillimetres}};
  std::printf("| %d pairs each, missed / false contacts [%%] | contacts |", kPairs);
  for (const Method& method : methods) std::printf(" %s |", method.name.c_str());
  std::printf("\n|---|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const auto& [name, make] : classes) {
    Dice dice;
    std::vector<int> missed(methods.size()), added(methods.size());
    int contacts = 0;
    for (int i = 0; i < kPairs; ++i) {
      const Pair pair = make(&dice);
      const Triangle &a = pair.a, &b = pair.b;
      const bool truth =
          meetBeyondByConstruction({a.v[0], a.v[1], a.v[2]}, {b.v[0], b.v[1], b.v[2]}, {});
      contacts += truth ? 1 : 0;
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const bool found = methods[m].intersects(a, b);
        missed[m] += truth && !found ? 1 : 0;
        added[m] += !truth && found ? 1 : 0;
      }
    }
    std::printf("| %s | %.1f %% |", name, 100.0 * contacts / kPairs);
    for (std::size_t m = 0; m < methods.size(); ++m) {
      std::printf(" %.2f / %.2f |", 100.0 * missed[m] / kPairs, 100.0 * added[m] / kPairs);
    }
    std::printf("\n");
    if (missed[0] + added[0] + missed[1] > 0) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() { return deformable_contact_monitor::run(); }
