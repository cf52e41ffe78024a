// Margins where numbers get hard: vertices and margins from 1e-45 to 3e38 m. The set and every
// separation, bit by bit, on every backend; against the verdict alone, pair by pair, and against
// exact distances.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <random>
#include <set>

#include "cgal_oracle.h"
#include "core/predicates/narrow_phase.h"
#include "core/rules/margins.h"
#include "detector_suite.h"
#include "exact_distance.h"
#include "random_scenes.h"
#include "reference/posed_triangles.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

struct Expected {
  std::vector<TrianglePair> contacts;
  std::vector<float> separations_m;
};

// Calls visit(pair, a, b, shared, margin) for each pair of finite triangles that is looked at.
template <class Visit>
void forEachPair(const Scene& scene, const Visit& visit) {
  std::vector<std::vector<PosedTriangle>> bodies;
  for (const Body& body : scene.bodies()) bodies.push_back(finiteTriangles(body, noLimit()));
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (std::size_t i = 0; i < bodies[a].size(); ++i) {
      for (BodyId b = a; b < scene.bodyCount(); ++b) {
        if (!scene.pairEnabled(a, b)) continue;
        const float margin_m = pairMargin(scene.body(a).margin_m, scene.body(b).margin_m);
        for (std::size_t j = a == b ? i + 1 : 0; j < bodies[b].size(); ++j) {
          const PosedTriangle &s = bodies[a][i], &t = bodies[b][j];
          SharedVertices shared;
          if (a == b) shared = sharedVertices(s.received, t.received);
          visit(TrianglePair{a, s.index, b, t.index}, s.posed, t.posed, shared, margin_m);
        }
      }
    }
  }
}

// Without broad phase or filters, and with the triangles now in this order, now in that.
Expected byVerdictsAlone(const Scene& scene) {
  Expected expected;
  bool turn = false;
  forEachPair(scene, [&](const TrianglePair& pair, const Triangle& a, const Triangle& b,
                         const SharedVertices& shared, float margin_m) {
    PredicateState state;
    Verdict verdict;
    turn = !turn;
    if (shared.any) {
      verdict.contact = meetBeyondShared(a, b, shared, state);
    } else if (trianglesIntersect(a, b, state)) {
      verdict.contact = true;
    } else {
      verdict = turn ? nearVerdict(b, a, margin_m) : nearVerdict(a, b, margin_m);
    }
    if (!verdict.contact) return;
    expected.contacts.push_back(pair);
    expected.separations_m.push_back(verdict.separation_m);
  });
  if (!scene.anyMargin()) expected.separations_m.clear();
  return expected;
}

// Two waving cloths of 2 n n triangles each, 1 m wide, one over the other, with themselves too.
Scene twoCloths(int n, float margin_m) {
  Scene scene = pairScene(clothGrid(n, 1, 0, 0.05F), clothGrid(n - 1, 1, 0.02F, -0.05F));
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(1, 1, true);
  scene.setMargin(0, margin_m);
  scene.setMargin(1, margin_m / 4);
  return scene;
}

void moveVertex(Scene* scene, BodyId body, std::size_t vertex, const Vec3f& to) {
  std::vector<float> vertices = scene->body(body).mesh.vertices;
  const float xyz[3] = {to.x, to.y, to.z};
  std::copy(xyz, xyz + 3, vertices.begin() + static_cast<std::ptrdiff_t>(3 * vertex));
  scene->setVertices(body, vertices.data(), vertices.size() / 3);
}

// Cloths with far vertices; kinds 0 to 5.
Scene farScene(int kind, int n, float far, float margin_m) {
  Scene scene = twoCloths(n, margin_m);
  const auto middle = static_cast<std::size_t>((n + 1) * (n / 2) + n / 2);
  if (kind == 0) {
    moveVertex(&scene, 0, middle, {far, far / 3, far / 7});
  } else if (kind == 1) {
    moveVertex(&scene, 1, 0, {-far, 0.5F, 0});
  } else if (kind == 2) {  // triangles of which two vertices are far, through the cloth
    moveVertex(&scene, 0, middle, {far, far, far});
    moveVertex(&scene, 0, middle + 1, {-far, -far, -far});
  } else if (kind == 3) {  // ground a little below
    scene.addBody("ground", meshOf({{{{-far, -far, -0.06F}, {far, -far, -0.06F}, {0, far, -0.06F}}},
                                    {{{-far, far, -0.07F}, {far, far, -0.07F}, {0, -far, 9}}}}));
  } else if (kind == 4) {  // planes and edges through the origin
    scene.addBody("slope", meshOf({{{{far, 0, far}, {-far, far, -far}, {-far, -far, -far}}},
                                   {{{far, far, 0}, {-far, -far, 0}, {0, 0, -1}}}}));
  } else {
    moveVertex(&scene, 0, middle, {far, far / 3, far / 7});
    moveVertex(&scene, 1, 3, {far, far / 3, far / 7});
  }
  for (BodyId body = 0; body < 2 && scene.bodyCount() > 2; ++body) {
    scene.setPairEnabled(body, 2, true);
  }
  return scene;
}

constexpr int kKinds = 6;

class MarginExtremes : public DetectorSuite {
 protected:
  void expectVerdicts(const Scene& scene, const std::string& what) {
    expectFound(scene, byVerdictsAlone(scene), what);
  }

  void expectFound(const Scene& scene, const Expected& expected, const std::string& what) {
    found_ += expected.contacts.size();
    near_ += static_cast<std::size_t>(
        std::count_if(expected.separations_m.begin(), expected.separations_m.end(),
                      [](float separation_m) { return separation_m > 0; }));
    for (const int clusters : {0, 1, 13}) {
      Options options;
      options.clusters = clusters;
      const DetectionResult& result = detector_->detect(scene, options);
      ASSERT_TRUE(samePairs(expected.contacts, result.contacts)) << what << ", " << clusters;
      ASSERT_TRUE(sameBits(expected.separations_m, result.separations_m)) << what;
      if (GetParam().name == std::string("brute_force")) break;
    }
  }

  std::size_t found_ = 0, near_ = 0;
};

TEST_P(MarginExtremes, FarVertices) {
  for (int kind = 0; kind < kKinds; ++kind) {
    for (const float far : {1e3F, 1e9F, 1e30F, FLT_MAX}) {
      for (const float margin_m : {0.003F, 0.05F}) {
        expectVerdicts(farScene(kind, 12, far, margin_m),
                       "kind " + std::to_string(kind) + " at " + std::to_string(far));
        if (HasFatalFailure()) return;
      }
    }
  }
  EXPECT_GT(near_, 10000U);
}

TEST_P(MarginExtremes, MarginsOfAnySize) {
  for (const float margin_m : {1e-45F, 1e-38F, 1e-30F, 1e-9F, 1.0F, 10.0F, 1e9F, 1e30F, FLT_MAX}) {
    for (const int kind : {0, 3}) {
      expectVerdicts(farScene(kind, 6, 1e30F, margin_m), std::to_string(margin_m));
      if (HasFatalFailure()) return;
    }
  }
}

// Adds a body of points, each a triangle. Their coordinates are multiples of the least float32.
BodyId addPoints(const std::vector<std::array<int, 3>>& points, Scene* scene) {
  std::vector<Triangle> triangles;
  for (const auto& [x, y, z] : points) {
    const auto at = [](int k) { return std::ldexp(static_cast<float>(k), -149); };
    const Vec3f v{at(x), at(y), at(z)};
    triangles.push_back({{v, v, v}});
  }
  return scene->addBody("points", meshOf(triangles));
}

// Distances of points at whole multiples of the least float32, where rounding to float32 changes
// up to half of a distance. Integers say which are near.
TEST_P(MarginExtremes, PointsAtMultiplesOfTheLeastFloat) {
  std::mt19937 random(5);
  for (int i = 0; i < 40; ++i) {
    std::vector<std::array<int, 3>> points[2] = {{{0, 0, 0}}, {{1, 1, 0}}};
    const int margin = i == 0 ? 1 : 1 + static_cast<int>(random() % 5);
    const auto coordinate = [&] { return static_cast<int>(random() % 24); };
    for (int k = 0; k < 60 && i > 0; ++k) {
      for (auto& list : points) list.push_back({coordinate(), coordinate(), coordinate()});
    }
    Scene scene;
    for (const auto& list : points) addPoints(list, &scene);
    scene.setPairEnabled(0, 1, true);
    scene.setMargin(i % 2, std::ldexp(static_cast<float>(margin), -149));
    Expected expected;
    for (std::uint32_t a = 0; a < points[0].size(); ++a) {
      for (std::uint32_t b = 0; b < points[1].size(); ++b) {
        int squared = 0, most = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          const int gap = std::abs(points[0][a][k] - points[1][b][k]);
          squared += gap * gap;
          most = std::max(most, gap);
        }
        // A square root of an integer is never half of an odd number.
        if (most > margin || 4 * squared > (2 * margin + 1) * (2 * margin + 1)) continue;
        expected.contacts.push_back({0, a, 1, b});
        const double nearest = std::round(std::sqrt(static_cast<double>(squared)));
        expected.separations_m.push_back(static_cast<float>(std::ldexp(nearest, -149)));
      }
    }
    ASSERT_FALSE(i == 0 && expected.contacts.empty());
    expectFound(scene, expected, "scene " + std::to_string(i));
    if (HasFatalFailure()) return;
  }
}

// Layers at a distance that is their margin, at all scales.
TEST_P(MarginExtremes, ScenesOfAnyScale) {
  for (const int exponent : {-149, -130, -100, -40, 0, 40, 100, 122}) {
    const auto at = [exponent](float x) { return std::ldexp(std::round(x), exponent); };
    Scene scene;
    for (int layer = 0; layer < 3; ++layer) {
      TriangleMesh mesh = clothGrid(8, 8, 0, 0);
      for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        mesh.vertices[i] = at(i % 3 == 2 ? static_cast<float>(3 * layer) : mesh.vertices[i]);
      }
      scene.addBody("layer", mesh);
      scene.setMargin(scene.bodyCount() - 1, layer == 1 ? 0 : at(3));
    }
    for (const auto& [a, b] : {std::pair<BodyId, BodyId>(0, 1), {1, 2}, {0, 2}}) {
      scene.setPairEnabled(a, b, true);
    }
    near_ = 0;
    expectVerdicts(scene, "2^" + std::to_string(exponent));
    if (HasFatalFailure()) return;
    EXPECT_GT(near_, 1000U) << exponent;
  }
}

TEST_P(MarginExtremes, RandomScenes) {
  std::mt19937 random(11);
  for (std::uint32_t seed = 0; seed < 1500; ++seed) {
    Scene scene = randomScene(seed);
    float size = 0;  // of some triangle
    for (const Body& body : scene.bodies()) {
      for (const PosedTriangle& t : finiteTriangles(body, noLimit())) {
        size = std::max(size, std::abs(t.posed.v[1].x - t.posed.v[0].x));
        if (size > 0) break;
      }
    }
    const float choice[] = {0, 0, 0.01F * size, 0.3F * size, size, 3 * size, 1e-45F, 1e-30F, 1e30F};
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      scene.setMargin(id, std::min(choice[random() % 9], FLT_MAX));
    }
    expectVerdicts(scene, "seed " + std::to_string(seed));
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(near_, 50000U);
  EXPECT_GT(found_, near_ + 10000U);
}

TEST_P(MarginExtremes, LargerRandomScenes) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    Scene scene = largeRandomScene(seed);
    const float unit = seed == 0 ? 1 : (seed == 1 ? 1e-25F : 1e25F);
    scene.setMargin(0, unit);
    scene.setMargin(1, 0.5F * unit);
    expectVerdicts(scene, "seed " + std::to_string(seed));
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(near_, 10000U);
}

// The definition, by a distance that shares nothing with the verdict's.
TEST_P(MarginExtremes, FarVerticesByExactDistances) {
  for (int kind = 0; kind < kKinds; ++kind) {
    const Scene scene = farScene(kind, 5, 1e30F, 0.05F);
    const DetectionResult& result = detector_->detect(scene, Options());
    const auto touching = oracleContacts(scene, AdjacentPairs::kBeyondShared);
    ASSERT_EQ(result.contacts.size(), result.separations_m.size());
    std::size_t near = 0;
    forEachPair(scene, [&](const TrianglePair& pair, const Triangle& a, const Triangle& b,
                           const SharedVertices& shared, float margin_m) {
      const auto found = std::lower_bound(result.contacts.begin(), result.contacts.end(), pair);
      const bool reported = found != result.contacts.end() && *found == pair;
      const float separation_m =
          reported ? result.separations_m[found - result.contacts.begin()] : 0;
      const bool touches = std::binary_search(touching.begin(), touching.end(), pair);
      if (touches || shared.any) {
        EXPECT_EQ(touches, reported) << pair;
        EXPECT_EQ(0, separation_m) << pair;
        return;
      }
      const double distance = exactDistance(a, b);
      EXPECT_EQ(distance < margin_m, reported) << pair << " at " << distance << ", kind " << kind;
      if (!reported) return;
      EXPECT_NEAR(distance, separation_m, distance * 1.2e-7) << pair << ", kind " << kind;
      ++near;
    });
    EXPECT_GT(near, 100U) << kind;
  }
}

// The result has separations depending on the bodies that take part, not on others.
TEST_P(MarginExtremes, SeparationsAreThereByOneRule) {
  Scene scene = twoCloths(6, 0);
  EXPECT_TRUE(detector_->detect(scene, Options()).separations_m.empty());
  const BodyId idle = scene.addBody("idle", clothGrid(2, 1, 0, 0));
  scene.setMargin(idle, 0.1F);
  const DetectionResult& without = detector_->detect(scene, Options());
  EXPECT_GT(without.contacts.size(), 0U);
  EXPECT_TRUE(without.separations_m.empty()) << "the body with the margin takes no part";
  scene.setPairEnabled(idle, idle, true);
  const DetectionResult& with = detector_->detect(scene, Options());
  EXPECT_EQ(with.contacts.size(), with.separations_m.size());
  scene.setPairEnabled(idle, idle, false);
  scene.setMargin(1, 1e-45F);
  const DetectionResult& tiny = detector_->detect(scene, Options());
  EXPECT_EQ(tiny.contacts.size(), tiny.separations_m.size());
}

INSTANTIATE_TEST_SUITE_P(, MarginExtremes, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
