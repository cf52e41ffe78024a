// Scenes where numbers get hard, on every backend, against the exact oracle.
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "detector_suite.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kSubnormal = std::numeric_limits<float>::denorm_min();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// Both bodies with themselves and with each other.
Scene allPairs(TriangleMesh a, TriangleMesh b) {
  Scene scene = pairScene(std::move(a), std::move(b));
  scene.setPairEnabled(0, 0, true);
  scene.setPairEnabled(1, 1, true);
  return scene;
}

TriangleMesh mapped(TriangleMesh mesh, const std::function<float(float, int)>& map) {
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    mesh.vertices[i] = map(mesh.vertices[i], static_cast<int>(i % 3));
  }
  return mesh;
}

// [0, 1]^3 + corner, 12 triangles.
TriangleMesh box(float x, float y, float z) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.insert(mesh.vertices.end(),
                         {x + static_cast<float>(i & 1), y + static_cast<float>(i >> 1 & 1),
                          z + static_cast<float>(i >> 2 & 1)});
  }
  mesh.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

// Small cloths through each other, on integers from 0 to 24, so that scaling keeps them exact.
Scene crossingCloths(float scale, float offset) {
  const auto place = [=](float x, int) { return (x + offset) * scale; };
  TriangleMesh flat = mapped(clothGrid(8, 8, 0, 0), [](float x, int axis) {
    return axis == 2 ? 2.0F : std::round(x) * 3;
  });
  TriangleMesh upright = flat;
  for (std::size_t i = 0; i < upright.vertices.size(); i += 3) {
    const float x = upright.vertices[i], y = upright.vertices[i + 1];
    upright.vertices[i] = x;
    upright.vertices[i + 1] = 7;
    upright.vertices[i + 2] = y - 9;
  }
  return allPairs(mapped(flat, place), mapped(upright, place));
}

Scene degenerateTriangles() {
  const Vec3f o{0, 0, 0}, x{1, 0, 0}, y{0, 1, 0}, m{0.5F, 0, 0}, c{0.25F, 0.25F, 0};
  const Vec3f up{0.25F, 0.25F, 1}, down{0.25F, 0.25F, -1};
  const std::vector<Triangle> kinds = {
      {{o, x, y}},      {{o, o, o}},     {{c, c, c}}, {{o, x, x}},    {{o, m, x}},  {{x, o, m}},
      {{up, down, up}}, {{up, c, down}}, {{m, m, y}}, {{up, up, up}}, {{o, x, up}}, {{o, y, down}}};
  return allPairs(meshOf(kinds), meshOf(kinds));
}

Scene needles() {
  std::vector<Triangle> thin, across;
  for (int i = 0; i < 40; ++i) {
    const float s = static_cast<float>(i) * 0.02F;
    thin.push_back({{{-1, s, 0}, {1, s, 0}, {1, s + 2e-8F, 1e-8F}}});
    across.push_back({{{s, -1, 1e-9F}, {s, 1, -1e-9F}, {s + 1e-8F, 1, 0}}});
  }
  return allPairs(meshOf(thin), meshOf(across));
}

Scene hugeAmongSmall() {
  TriangleMesh cloth = clothGrid(20, 1, 0.01F, 0.05F);
  const std::vector<Triangle> huge = {
      {{{-1e6F, -1e6F, 0}, {1e6F, -1e6F, 0}, {0, 2e6F, 0.02F}}},
      {{{-1e6F, 0.3F, -1e6F}, {1e6F, 0.3F, -1e6F}, {0, 0.3F, 1e6F}}}};
  return allPairs(std::move(cloth), meshOf(huge));
}

Scene identicalPoints() {
  const Vec3f p{0.1F, -0.2F, 0.3F};
  return allPairs(meshOf(std::vector<Triangle>(50, {{p, p, p}})),
                  meshOf(std::vector<Triangle>(20, {{p, p, p}})));
}

Scene duplicates() {
  const Triangle t{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}};
  const Triangle through{{{0.2F, 0.2F, -1}, {0.2F, 0.3F, 1}, {0.3F, 0.2F, 1}}};
  return allPairs(meshOf(std::vector<Triangle>(1500, t)),
                  meshOf(std::vector<Triangle>(8, through)));
}

Scene coplanarSquares() {
  TriangleMesh even = clothGrid(16, 16, 0, 0);
  return allPairs(even, mapped(even, [](float x, int axis) { return axis == 2 ? x : x + 0.5F; }));
}

Scene onALine() {
  std::vector<Triangle> a, b;
  for (int i = 0; i < 700; ++i) {
    const auto x = static_cast<float>(i);
    a.push_back({{{x, 0, 0}, {x + 0.5F, 0, 0}, {x + 1.25F, 0, 0}}});
    b.push_back({{{x + 0.5F, 0, 0}, {x + 0.75F, 0, 0}, {x + 0.6F, 0, 0}}});
  }
  return allPairs(meshOf(a), meshOf(b));
}

// A shell with the same spread in every direction.
Scene isotropic() {
  std::vector<Triangle> triangles;
  for (int i = 0; i < 900; ++i) {
    const float z = -1 + 2 * (static_cast<float>(i) + 0.5F) / 900;
    const float r = std::sqrt(1 - z * z), turn = 2.3999632F * static_cast<float>(i);
    const Vec3f p{r * std::cos(turn), r * std::sin(turn), z};
    triangles.push_back({{p, p * 0.93F + Vec3f{0.02F, 0, 0.05F}, p * 1.04F + Vec3f{0, 0.06F, 0}}});
  }
  return allPairs(meshOf(triangles), box(-0.5F, -0.5F, 0.2F));
}

Scene badAmongGood() {
  Scene scene = crossingCloths(1, 0);
  TriangleMesh mesh = scene.body(0).mesh;
  const float bad[] = {kNan, kInfinity, -kInfinity, -kNan};
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 29) mesh.vertices[i] = bad[i % 4];
  scene.setMesh(0, mesh);
  return scene;
}

Scene negativeZeros() {
  Scene scene = crossingCloths(1, 0);
  for (BodyId id = 0; id < 2; ++id) {
    TriangleMesh mesh = soupOf(scene.body(id).mesh);
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 2) {
      if (mesh.vertices[i] == 0) mesh.vertices[i] = -0.0F;
    }
    scene.setMesh(id, mesh);
  }
  return scene;
}

// Body 1 is posed; far off, the poses round the vertices, alike for detector and oracle.
Scene farFromTheOrigin(double metres) {
  Scene scene = pairScene(clothGrid(20, 1, 0, 0.05F), clothGrid(20, 1, 0.01F, 0));
  for (BodyId id = 0; id < 2; ++id) {
    RigidTransform pose;
    const double c = std::cos(0.3 * id), s = std::sin(0.3 * id);
    const double turned[9] = {c, -s, 0, s, c, 0, 0, 0, 1};
    std::copy(std::begin(turned), std::end(turned), pose.rotation);
    for (double& t : pose.translation) t = metres;
    scene.setPose(id, pose);
  }
  return scene;
}

// Body 0 is a triangle in the plane x = 0, which the pose leaves where it is, and another one that
// the pose sends so far that its box cannot be computed in double.
Scene sentBeyondDoubles() {
  Scene scene = pairScene(meshOf({{{{0, -1, -1}, {0, 1, -1}, {0, 0, 1}}},
                                  {{{1e30F, 0, 0}, {1e30F, 1, 0}, {1e30F, 0, 1}}}}),
                          meshOf({{{{-1, 0, 0}, {1, 0, 0}, {1, 0.2F, 0.1F}}}}));
  RigidTransform pose;
  pose.rotation[0] = 1e300;
  scene.setPose(0, pose);
  return scene;
}

struct Extreme {
  const char* name;
  std::function<Scene()> make;
};

const std::vector<Extreme>& extremes() {
  static const std::vector<Extreme> kScenes = {
      {"stacked_boxes", [] { return pairScene(box(0, 0, 0), box(0, 0, 1)); }},
      {"boxes_edge_to_edge", [] { return pairScene(box(0, 0, 0), box(1, 0, 1)); }},
      {"boxes_corner_to_corner", [] { return pairScene(box(0, 0, 0), box(1, 1, 1)); }},
      {"unit_scale", [] { return crossingCloths(1, 0); }},
      {"scale_1e_minus_30", [] { return crossingCloths(1e-30F, 0); }},
      {"scale_1e30", [] { return crossingCloths(1e30F, 0); }},
      {"subnormal", [] { return crossingCloths(kSubnormal, 0); }},
      {"nearly_subnormal", [] { return crossingCloths(0x1p-140F, 0); }},
      {"nearly_overflowing", [] { return crossingCloths(0x1p123F, 0); }},
      {"offset_1e5", [] { return crossingCloths(1, 100000); }},
      {"offset_1e7_rounded", [] { return crossingCloths(0.1F, 100000000); }},
      {"degenerate_triangles", degenerateTriangles},
      {"needles", needles},
      {"huge_among_small", hugeAmongSmall},
      {"identical_points", identicalPoints},
      {"duplicates", duplicates},
      {"coplanar_squares", coplanarSquares},
      {"on_a_line", onALine},
      {"isotropic", isotropic},
      {"nan_and_infinity", badAmongGood},
      {"negative_zeros", negativeZeros},
      {"near_the_origin", [] { return farFromTheOrigin(1); }},
      {"a_thousand_kilometres_off", [] { return farFromTheOrigin(1e6); }},
      {"sent_beyond_doubles", sentBeyondDoubles},
      {"one_triangle",
       [] {
         return selfScene(meshOf({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}}));
       }},
      {"no_triangle", [] { return selfScene(TriangleMesh()); }}};
  return kScenes;
}

class Extremes : public ::testing::TestWithParam<std::tuple<Backend, Extreme>> {};

TEST_P(Extremes, EqualsTheOracle) {
  const auto& [backend, extreme] = GetParam();
  const std::unique_ptr<Detector> detector = backend.make();
  const Scene scene = extreme.make();
  for (const AdjacentPairs adjacent : kBothAdjacent) {
    const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
    Options options = withAdjacent(adjacent);
    for (const int clusters : {0, 1, 5, 300}) {
      for (const float fuzzifier : {1.05F, 2.0F, 4.0F}) {
        options.clusters = clusters;
        options.fuzzifier = fuzzifier;
        const DetectionResult& result = detector->detect(scene, options);
        EXPECT_TRUE(samePairs(expected, result.contacts))
            << "clusters " << clusters << ", fuzzifier " << fuzzifier;
        EXPECT_TRUE(result.guaranteed);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Extremes,
                         ::testing::Combine(::testing::ValuesIn(productBackends()),
                                            ::testing::ValuesIn(extremes())),
                         [](const auto& info) {
                           return std::string(std::get<0>(info.param).name) + "_" +
                                  std::get<1>(info.param).name;
                         });

// The scenes above are only worth something if there is something to find in them.
TEST(ExtremeScenes, HaveContacts) {
  for (const Extreme& extreme : extremes()) {
    const std::size_t found = oracleContacts(extreme.make(), AdjacentPairs::kBeyondShared).size();
    const std::string name = extreme.name;
    if (name == "stacked_boxes") {
      EXPECT_EQ(found, 62U);
    } else if (name == "one_triangle" || name == "no_triangle") {
      EXPECT_EQ(found, 0U);
    } else {
      EXPECT_GT(found, 0U) << name;
    }
  }
}

class HardMeshes : public DetectorSuite {};

TEST_P(HardMeshes, EqualTheOracle) {
  DCM_REQUIRE_TEST_DATA();
  std::size_t found = 0;
  for (const char* file :
       {"40509.stl", "aatbase_3_binary.stl", "boxedSphere.stl", "cap.stl", "fin0.stl", "fin1.stl",
        "fin2.stl", "flat_eight_point_star.stl", "naca0012.stl", "self_intersectA.obj",
        "self_intersectB.obj", "sphere.stl", "sphere_binary.stl", "tetrahedron.stl",
        "three_cubes.stl", "two_spheres.stl", "unit_cube.stl", "unit_sphere.stl"}) {
    const Scene scene = selfScene(readMeshFile(testDataFile(std::string("hard-meshes/") + file)));
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const std::vector<TrianglePair> expected = oracleContacts(scene, adjacent);
      EXPECT_TRUE(samePairs(expected, contacts(scene, withAdjacent(adjacent)))) << file;
      found += expected.size();
    }
  }
  EXPECT_GT(found, 100U);
}

INSTANTIATE_TEST_SUITE_P(, HardMeshes, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
