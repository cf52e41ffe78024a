// Scenes in two states: of the bodies' earlier states, and seeded random ones.
#include "swept_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

TriangleMesh earlierMesh(const Body& body) {
  TriangleMesh mesh = body.mesh;
  if (body.earlier && !body.earlier->vertices.empty()) mesh.vertices = body.earlier->vertices;
  return mesh;
}

RigidTransform earlierPose(const Body& body) {
  return body.earlier ? body.earlier->pose : body.pose;
}

void copyPairs(const Scene& from, Scene* to) {
  for (const auto& [a, b] : from.enabledPairs()) to->setPairEnabled(a, b, true);
}

void addMoving(const std::string& name, const std::vector<MovingTriangle>& triangles,
               Scene* scene) {
  std::vector<Triangle> from, to;
  for (const MovingTriangle& t : triangles) {
    from.push_back(t.from);
    to.push_back(t.to);
  }
  const BodyId id = scene->addBody(name, meshOf(to));
  scene->setEarlier(id, RigidTransform(), meshOf(from).vertices);
}

}  // namespace

Scene earlierScene(const Scene& scene) {
  Scene out;
  for (const Body& body : scene.bodies()) {
    out.setPose(out.addBody(body.name, earlierMesh(body)), earlierPose(body));
  }
  copyPairs(scene, &out);
  return out;
}

Scene laterScene(const Scene& scene) {
  Scene out;
  for (const Body& body : scene.bodies()) out.setPose(out.addBody(body.name, body.mesh), body.pose);
  copyPairs(scene, &out);
  return out;
}

Scene reversedScene(const Scene& scene) {
  Scene out = scene;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    if (!body.earlier) continue;
    out.setMesh(id, earlierMesh(body));
    out.setPose(id, body.earlier->pose);
    out.setEarlier(id, body.pose, body.mesh.vertices);
  }
  return out;
}

Scene stepScene(const Scene& from, const Scene& to) {
  if (from.bodyCount() != to.bodyCount()) throw std::invalid_argument("not the same bodies");
  Scene out = to;
  for (BodyId id = 0; id < to.bodyCount(); ++id) {
    out.setEarlier(id, from.body(id).pose, from.body(id).mesh.vertices);
  }
  return out;
}

Scene movingSelfScene(const std::vector<MovingTriangle>& triangles) {
  Scene scene;
  addMoving("body", triangles, &scene);
  scene.setPairEnabled(0, 0, true);
  return scene;
}

Scene movingPairScene(const std::vector<MovingTriangle>& a, const std::vector<MovingTriangle>& b) {
  Scene scene;
  addMoving("a", a, &scene);
  addMoving("b", b, &scene);
  scene.setPairEnabled(0, 1, true);
  return scene;
}

namespace {

// mt19937 alone is the same everywhere; the standard distributions are not.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : generator_(seed) {}

  int below(int n) { return static_cast<int>(generator_() % static_cast<std::uint32_t>(n)); }
  bool oneIn(int n) { return below(n) == 0; }
  float signedUnit() { return static_cast<float>(generator_() >> 8) * 0x1p-23F - 1; }

 private:
  std::mt19937 generator_;
};

enum class Steps { kAny, kSmall, kCommon, kNone };

// Describes what all coordinates of one scene have in common.
struct Style {
  int grid = 4;       // integers 0..grid-1 on each axis; 0: off any grid
  bool flat = false;  // all in one plane of constant z, which may move
  float flat_from = 0, flat_to = 0;
  int power = 0;  // all coordinates times 2^power
  bool extreme = false;
  Steps steps = Steps::kAny;
  Vec3f common;  // step
};

class SceneMaker {
 public:
  SceneMaker(std::uint32_t seed, bool integers_alone)
      : dice_(seed), integers_alone_(integers_alone) {
    constexpr std::array<int, 5> kGrids{2, 3, 4, 6, 9};
    style_.grid = kGrids[static_cast<std::size_t>(dice_.below(5))];
    if (!integers_alone && dice_.oneIn(4)) style_.grid = 0;
    style_.flat = dice_.oneIn(5);
    style_.flat_from = coordinate();
    style_.flat_to = coordinate();
    constexpr std::array<int, 6> kPowers{-140, -126, -40, -3, 20, 100};
    if (!integers_alone && dice_.oneIn(3)) {
      style_.power = kPowers[static_cast<std::size_t>(dice_.below(6))];
    }
    style_.extreme = !integers_alone && dice_.oneIn(4);
    style_.common = point();
  }

  Scene make() {
    Scene scene;
    const int bodies = 1 + dice_.below(integers_alone_ ? 2 : 3);
    for (int b = 0; b < bodies; ++b) {
      addBody("body " + std::to_string(b), 1 + dice_.below(14 / bodies), &scene);
    }
    for (BodyId a = 0; a < scene.bodyCount(); ++a) {
      for (BodyId b = a; b < scene.bodyCount(); ++b) {
        scene.setPairEnabled(a, b, bodies == 1 || !dice_.oneIn(4));
      }
    }
    return scene;
  }

 private:
  float coordinate() {
    return style_.grid > 0 ? static_cast<float>(dice_.below(style_.grid)) : 3 * dice_.signedUnit();
  }
  Vec3f point() { return {coordinate(), coordinate(), coordinate()}; }

  void addBody(const std::string& name, int count, Scene* scene) {
    constexpr std::array<Steps, 6> kSteps{Steps::kAny,   Steps::kAny,    Steps::kAny,
                                          Steps::kSmall, Steps::kCommon, Steps::kNone};
    style_.steps = kSteps[static_cast<std::size_t>(dice_.below(6))];
    std::vector<MovingTriangle> triangles;
    for (int i = 0; i < count; ++i) triangles.push_back(triangle(triangles));
    std::vector<Triangle> from, to;
    for (MovingTriangle& t : triangles) {
      finish(&t);
      from.push_back(t.from);
      to.push_back(t.to);
    }
    TriangleMesh before = meshOf(from), after = meshOf(to);
    if (dice_.oneIn(2)) weld(before, &after);
    const BodyId id = scene->addBody(name, after);
    if (!integers_alone_ && dice_.oneIn(3)) scene->setPose(id, pose());
    switch (integers_alone_ ? 3 : dice_.below(8)) {
      case 0:  // stands still
        break;
      case 1:  // a link: another pose alone
        scene->setEarlier(id, pose());
        break;
      case 2:
        scene->setEarlier(id, pose(), before.vertices);
        break;
      default:
        scene->setEarlier(id, scene->body(id).pose, before.vertices);
    }
  }

  MovingTriangle triangle(const std::vector<MovingTriangle>& others) {
    MovingTriangle t;
    for (int i = 0; i < 3; ++i) {
      t.from.v[i] = point();
      t.to.v[i] = step(t.from.v[i]);
    }
    degenerate(&t);
    if (dice_.oneIn(6)) t.to = t.from;
    if (!others.empty() && dice_.oneIn(2)) {
      const MovingTriangle& old =
          others[static_cast<std::size_t>(dice_.below(static_cast<int>(others.size())))];
      const int turn = dice_.below(3);
      for (int k = dice_.below(4); k > 0; --k) {
        const int i = k - 1, j = (i + turn) % 3;
        const int states = dice_.oneIn(3) ? 1 + dice_.below(2) : 3;
        if ((states & 1) != 0) t.from.v[i] = old.from.v[j];
        if ((states & 2) != 0) t.to.v[i] = old.to.v[j];
      }
    }
    return t;
  }

  Vec3f step(const Vec3f& start) {
    switch (style_.steps) {
      case Steps::kSmall: {
        const Vec3f way = style_.grid > 0 ? Vec3f{static_cast<float>(dice_.below(3) - 1),
                                                  static_cast<float>(dice_.below(3) - 1),
                                                  static_cast<float>(dice_.below(3) - 1)}
                                          : point() * 0.25F;
        return start + way;
      }
      case Steps::kCommon:
        return start + style_.common;
      case Steps::kNone:
        return start;
      default:
        return point();
    }
  }

  void degenerate(MovingTriangle* t) {
    if (!dice_.oneIn(5)) return;
    const int points = 1 + dice_.below(2);  // of the first vertices: a segment, or a point
    const int states = 1 + dice_.below(3);
    for (int i = points; i < 3; ++i) {
      if ((states & 1) != 0) t->from.v[i] = t->from.v[dice_.below(points)];
      if ((states & 2) != 0) t->to.v[i] = t->to.v[dice_.below(points)];
    }
  }

  // Into the plane, the scale and, sometimes, out of all bounds.
  void finish(MovingTriangle* t) {
    for (int i = 0; i < 3; ++i) {
      for (const bool end : {false, true}) {
        Vec3f& v = end ? t->to.v[i] : t->from.v[i];
        if (style_.flat) v.z = end ? style_.flat_to : style_.flat_from;
        if (v.x == 0 && dice_.oneIn(4)) v.x = -v.x;
        for (float* x : {&v.x, &v.y, &v.z}) *x = std::ldexp(*x, style_.power);
      }
    }
    if (!style_.extreme || !dice_.oneIn(6)) return;
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr std::array<float, 5> kExtremes{1e30F, -1e30F, 3e38F, kInfinity,
                                             std::numeric_limits<float>::quiet_NaN()};
    const float extreme = kExtremes[static_cast<std::size_t>(dice_.below(5))];
    (dice_.oneIn(2) ? t->from : t->to).v[dice_.below(3)].y = extreme;
  }

  // Vertices that are equal in both states by one index, of the triangles alone.
  static void weld(const TriangleMesh& before, TriangleMesh* after) {
    const auto equal = [](const Vec3f& a, const Vec3f& b) { return a == b; };
    for (std::uint32_t& index : after->triangles) {
      for (std::uint32_t other = 0; other < index; ++other) {
        if (!equal(before.vertex(other), before.vertex(index))) continue;
        if (!equal(after->vertex(other), after->vertex(index))) continue;
        index = other;
        break;
      }
    }
  }

  RigidTransform pose() {
    RigidTransform out;
    const bool is_turned = dice_.oneIn(2);
    if (is_turned && dice_.oneIn(2)) {  // keeps grids on grids
      const double turned[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
      std::copy(std::begin(turned), std::end(turned), out.rotation);
    } else if (is_turned) {
      const double angle = 3 * static_cast<double>(dice_.signedUnit());
      const double c = std::cos(angle), s = std::sin(angle);
      const double turned[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
      std::copy(std::begin(turned), std::end(turned), out.rotation);
    }
    for (double& t : out.translation) {
      t = std::ldexp(static_cast<double>(dice_.below(3)), style_.power);
    }
    return out;
  }

  Dice dice_;
  bool integers_alone_;
  Style style_;
};

std::vector<MovingTriangle> manyTriangles(bool on_grid, float longest_step, Dice* dice) {
  const auto coordinate = [&](float extent) {
    const float x = extent * (dice->signedUnit() + 1) / 2;
    return on_grid ? std::floor(x) : x;
  };
  const auto point = [&](float extent) {
    return Vec3f{coordinate(extent), coordinate(extent), coordinate(extent)};
  };
  const Vec3f common = point(40);
  std::vector<MovingTriangle> triangles;
  for (int i = 0; i < 300; ++i) {
    const float size = dice->oneIn(150) ? 200.0F : 3.0F;
    const float step = dice->oneIn(60) ? 100.0F : longest_step;
    const Vec3f corner{coordinate(40), coordinate(40), coordinate(20)};
    MovingTriangle t;
    for (int k = 0; k < 3; ++k) {
      t.from.v[k] = corner + point(size);
      t.to.v[k] = t.from.v[k] + common + point(step);
    }
    if (i > 0 && dice->oneIn(3)) {  // on the one before, through a vertex or an edge
      for (int k = dice->below(2); k >= 0; --k) {
        t.from.v[k] = triangles.back().from.v[k + 1];
        t.to.v[k] = triangles.back().to.v[k + 1];
      }
    }
    if (dice->oneIn(150)) (dice->oneIn(2) ? t.from : t.to).v[0].z = 1e37F;
    triangles.push_back(t);
  }
  return triangles;
}

}  // namespace

Scene randomSweptScene(std::uint32_t seed) { return SceneMaker(seed, false).make(); }

Scene integerSweptScene(std::uint32_t seed) { return SceneMaker(seed, true).make(); }

Scene largeSweptScene(std::uint32_t seed) {
  Dice dice(seed);
  const bool on_grid = dice.oneIn(2);
  const float longest_step = seed % 3 == 0 ? 4 : 1;
  const std::vector<MovingTriangle> a = manyTriangles(on_grid, longest_step, &dice);
  Scene scene = movingPairScene(a, manyTriangles(on_grid, longest_step, &dice));
  for (const BodyId b : {0U, 1U}) scene.setPairEnabled(b, b, true);
  return scene;
}

}  // namespace deformable_contact_monitor
