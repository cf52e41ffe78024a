// Seeded random scenes on which touching, coplanar, degenerate and extreme triangles are common.
#include "random_scenes.h"

#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// mt19937 alone is the same everywhere; the standard distributions are not.
class Dice {
 public:
  explicit Dice(std::uint32_t seed) : generator_(seed) {}

  int below(int n) { return static_cast<int>(generator_() % static_cast<std::uint32_t>(n)); }
  bool oneIn(int n) { return below(n) == 0; }
  float unit() { return static_cast<float>(generator_() >> 8) * 0x1p-24F; }
  float signedUnit() { return 2 * unit() - 1; }

 private:
  std::mt19937 generator_;
};

// Describes what all coordinates of one scene have in common.
struct Style {
  int grid = 4;         // integers 0..grid-1 on each axis; 0: off any grid
  float scale = 1;      // a power of ten or of two
  float flatness = 1;   // of the third axis off the grid
  bool flat = false;    // all in one plane
  bool extreme = true;  // huge and non-finite triangles may appear
};

Style randomStyle(Dice* dice) {
  Style style;
  style.grid = dice->oneIn(3) ? 0 : 2 + dice->below(4);
  style.flat = dice->oneIn(6);
  style.flatness = dice->oneIn(4) ? 1e-4F : 1;
  style.extreme = dice->oneIn(2);
  constexpr float kScales[] = {1e-40F, 1e-30F, 1e-20F, 1e-3F, 0.1F, 1e10F, 1e18F, 1e30F};
  if (dice->oneIn(2)) style.scale = kScales[dice->below(8)];
  return style;
}

Vec3f randomPoint(const Style& style, Dice* dice) {
  const auto coordinate = [&] {
    const float x =
        style.grid > 0 ? static_cast<float>(dice->below(style.grid)) : 3 * dice->signedUnit();
    return x == 0 && dice->oneIn(2) ? -0.0F : x * style.scale;
  };
  Vec3f p{coordinate(), coordinate(), coordinate()};
  if (style.flat) p.z = style.scale;
  if (style.grid == 0) p.z *= style.flatness;
  return p;
}

Triangle randomTriangle(const Style& style, Dice* dice) {
  Triangle t{{randomPoint(style, dice), randomPoint(style, dice), randomPoint(style, dice)}};
  if (style.grid == 0) {  // smaller ones, so that not all meet all
    for (int k = 1; k < 3; ++k) t.v[k] = t.v[0] + (t.v[k] - t.v[0]) * 0.4F;
  }
  switch (dice->below(14)) {
    case 0:  // a segment
      t.v[2] = t.v[dice->below(2)];
      break;
    case 1:  // a point
      t.v[1] = t.v[2] = t.v[0];
      break;
    case 2:  // three collinear points, where halving is exact
      t.v[2] = t.v[0] + (t.v[1] - t.v[0]) * 0.5F;
      break;
    case 3:  // a needle
      t.v[2] = t.v[1] + (t.v[2] - t.v[1]) * 1e-5F;
      break;
    default:
      break;
  }
  if (style.extreme && dice->oneIn(12)) {
    const float huge = 1000 * style.scale;
    for (Vec3f& v : t.v) v = {v.x * 1000 - huge, v.y * 1000 - huge, v.z};
  }
  if (style.extreme && dice->oneIn(15)) {
    t.v[dice->below(3)].x = dice->oneIn(2) ? 1e30F : 3e38F;
  }
  if (style.extreme && dice->oneIn(15)) {
    const float bad = dice->oneIn(2) ? std::numeric_limits<float>::quiet_NaN()
                                     : std::numeric_limits<float>::infinity();
    t.v[dice->below(3)].y = dice->oneIn(2) ? bad : -bad;
  }
  return t;
}

// Half of the triangles continue an earlier one: through an edge, through a vertex, or as its copy.
TriangleMesh randomMesh(const Style& style, int count, Dice* dice) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < count; ++i) {
    Triangle t = randomTriangle(style, dice);
    if (i > 0 && dice->oneIn(2)) {
      const Triangle& old = triangles[static_cast<std::size_t>(dice->below(i))];
      const int kept = 1 + dice->below(3), turn = dice->below(3);
      for (int k = 0; k < kept; ++k) t.v[(k + turn) % 3] = old.v[k];
    }
    triangles.push_back(t);
  }
  TriangleMesh mesh = meshOf(triangles);
  if (dice->oneIn(2)) {  // some of the equal vertices by one index
    for (std::uint32_t& index : mesh.triangles) {
      for (std::uint32_t other = 0; other < index; ++other) {
        const float* a = &mesh.vertices[3 * std::size_t{index}];
        const float* b = &mesh.vertices[3 * std::size_t{other}];
        if (a[0] == b[0] && a[1] == b[1] && a[2] == b[2]) {
          index = other;
          break;
        }
      }
    }
  }
  return mesh;
}

RigidTransform randomPose(const Style& style, Dice* dice) {
  RigidTransform pose;
  if (dice->oneIn(2)) {  // an axis permutation keeps grids on grids
    const double turned[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1};
    std::copy(std::begin(turned), std::end(turned), pose.rotation);
  } else {
    const double angle = 3.14159 * dice->signedUnit();
    const double c = std::cos(angle), s = std::sin(angle);
    const double turned[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
    std::copy(std::begin(turned), std::end(turned), pose.rotation);
  }
  for (double& t : pose.translation) t = static_cast<double>(dice->below(3)) * style.scale;
  return pose;
}

}  // namespace

Scene randomScene(std::uint32_t seed) {
  Dice dice(seed);
  const Style style = randomStyle(&dice);
  const int bodies = 1 + dice.below(4);
  Scene scene;
  for (int b = 0; b < bodies; ++b) {
    const int count = dice.oneIn(10) ? 0 : 1 + dice.below(40 / bodies);
    const BodyId id = scene.addBody("body " + std::to_string(b), randomMesh(style, count, &dice));
    if (dice.oneIn(3)) scene.setPose(id, randomPose(style, &dice));
  }
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (BodyId b = a; b < scene.bodyCount(); ++b) {
      scene.setPairEnabled(a, b, bodies == 1 || !dice.oneIn(3));
    }
  }
  return scene;
}

Scene largeRandomScene(std::uint32_t seed) {
  Dice dice(seed);
  const float scale = seed % 3 == 0 ? 1 : (seed % 3 == 1 ? 1e-25F : 1e25F);
  const bool on_grid = dice.oneIn(2);
  const auto coordinate = [&](float extent) {
    const float x = extent * dice.unit();
    return scale * (on_grid ? std::floor(x) : x);
  };
  Scene scene;
  for (int b = 0; b < 2; ++b) {
    std::vector<Triangle> triangles;
    for (int i = 0; i < 1500; ++i) {
      const float size = dice.oneIn(300) ? 1000.0F : 3.0F;
      const Vec3f corner{coordinate(40), coordinate(40), coordinate(20)};
      Triangle t;
      for (Vec3f& v : t.v) v = corner + Vec3f{coordinate(size), coordinate(size), coordinate(size)};
      if (dice.oneIn(500)) t.v[0].z = 1e37F;
      triangles.push_back(t);
    }
    scene.addBody("body " + std::to_string(b), meshOf(triangles));
  }
  for (BodyId a = 0; a < 2; ++a) {
    for (BodyId b = a; b < 2; ++b) scene.setPairEnabled(a, b, true);
  }
  return scene;
}

}  // namespace deformable_contact_monitor
