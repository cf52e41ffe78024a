// Bodies with a radius against an oracle: exact distances of all pairs of triangles, minus radii.
#include "core/bounds/radii.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cgal_oracle.h"
#include "core/body_distance.h"
#include "core/common/posed_body.h"
#include "core/detector_pool.h"
#include "core/rules/margins.h"
#include "core/tiling_cache.h"
#include "detector_suite.h"
#include "exact_distance.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

// A polyline: triangle i is the segment from point i to point i + 1.
TriangleMesh ropeOf(const std::vector<Vec3f>& points) {
  TriangleMesh mesh;
  for (const Vec3f& p : points) mesh.vertices.insert(mesh.vertices.end(), {p.x, p.y, p.z});
  for (std::uint32_t i = 0; i + 1 < points.size(); ++i) {
    mesh.triangles.insert(mesh.triangles.end(), {i, i + 1, i + 1});
  }
  return mesh;
}

// Single points.
TriangleMesh grainsOf(const std::vector<Vec3f>& points) {
  std::vector<Triangle> triangles;
  for (const Vec3f& p : points) triangles.push_back({{p, p, p}});
  return meshOf(triangles);
}

class Oracle {
 public:
  explicit Oracle(const Scene& scene) : scene_(scene) {
    for (const TrianglePair& pair : oracleContacts(scene, AdjacentPairs::kBeyondShared)) {
      meet_.insert(pair);
    }
  }

  Triangle triangle(BodyId id, std::uint32_t t) const {
    return PosedBody(scene_.body(id)).triangle(t);
  }

  // The float32 distance of two triangles, 0 if they meet.
  float bareM(const TrianglePair& pair) const {
    if (meet_.count(pair) > 0) return 0;
    const double distance_m = exactDistance(triangle(pair.body_a, pair.triangle_a),
                                            triangle(pair.body_b, pair.triangle_b));
    return static_cast<float>(distance_m);
  }

  double sum(BodyId a, BodyId b) const {
    return double{scene_.body(a).radius_m} + scene_.body(b).radius_m;
  }

  float apartM(BodyId a, BodyId b, float bare_m) const {
    if (bare_m <= sum(a, b)) return 0;
    return std::max(static_cast<float>(bare_m - sum(a, b)), FLT_TRUE_MIN);
  }

 private:
  const Scene& scene_;
  std::set<TrianglePair> meet_;
};

// The length of a rope between two of its segments.
double wayBetween(const TriangleMesh& rope, std::uint32_t a, std::uint32_t b) {
  double way_m = 0;
  for (std::uint32_t i = std::min(a, b) + 1; i < std::max(a, b); ++i) {
    const Vec3f p = rope.vertex(i), q = rope.vertex(i + 1);
    way_m += std::sqrt(std::pow(double{p.x} - q.x, 2) + std::pow(double{p.y} - q.y, 2) +
                       std::pow(double{p.z} - q.z, 2));
  }
  return way_m;
}

struct RandomRopes {
  Scene scene;
  std::array<bool, 4> is_rope{};

  // Divides a body into two parts, of which one or both have margins of their own.
  void giveParts(std::uint32_t seed, BodyId id) {
    std::mt19937 random(seed);
    std::vector<PartId> parts(scene.body(id).mesh.triangleCount());
    for (PartId& part : parts) part = static_cast<PartId>(1 + random() % 2);
    scene.setParts(id, parts);
    std::map<PartId, float> margins_m{{1, 0.01F * static_cast<float>(random() % 20)}};
    if (random() % 2 != 0) margins_m[2] = 0;
    scene.setPartMargins(id, margins_m);
  }

  explicit RandomRopes(std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(0, 1);
    const auto point = [&] { return Vec3f{unit(random), unit(random), unit(random)}; };
    for (BodyId id = 0; id < is_rope.size(); ++id) {
      std::vector<Vec3f> points;
      const std::uint32_t kind = random() % 3;
      Vec3f at = point();
      for (std::uint32_t i = 0, count = 2 + random() % 14; i < count; ++i) {
        points.push_back(kind == 2 ? point() : at);
        const Vec3f step = point();
        at = {at.x + (step.x - 0.5F) / 3, at.y + (step.y - 0.5F) / 3, at.z + (step.z - 0.5F) / 3};
      }
      is_rope[id] = kind == 0;
      if (kind == 2) {
        std::vector<Triangle> triangles;
        for (std::size_t i = 0; i + 2 < points.size(); i += 3) {
          triangles.push_back({{points[i], points[i + 1], points[i + 2]}});
        }
        scene.addBody("mesh", meshOf(triangles));
      } else {
        scene.addBody("rope", kind == 0 ? ropeOf(points) : grainsOf(points));
      }
      if (random() % 4 != 0) scene.setRadius(id, 0.1F * unit(random));
      if (random() % 2 != 0) scene.setMargin(id, 0.2F * unit(random));
      RigidTransform pose;
      for (double& x : pose.translation) x = 0.2 * unit(random);
      if (random() % 2 != 0) scene.setPose(id, pose);
      if (seed % 4 == 1) giveParts(seed + id, id);
    }
    for (BodyId a = 0; a < is_rope.size(); ++a) {
      for (BodyId b = a; b < is_rope.size(); ++b) {
        if (a == b ? is_rope[a] && scene.body(a).pose.isIdentity() : random() % 4 != 0) {
          scene.setPairEnabled(a, b, true);
        }
      }
    }
  }
};

// Returns the margin of a triangle [m].
float marginOf(const Scene& scene, BodyId id, std::uint32_t triangle) {
  const Body& body = scene.body(id);
  if (body.parts.empty()) return body.own_margin_m;
  const auto own = body.part_margins_m.find(body.parts[triangle]);
  return own == body.part_margins_m.end() ? body.own_margin_m : own->second;
}

struct Expected {
  std::map<TrianglePair, float> listed;                                         // [pair, distance]
  std::map<std::pair<BodyId, BodyId>, std::pair<float, TrianglePair>> nearest;  // of the bare ones

  Expected(const RandomRopes& ropes, bool lists_near) {
    const Scene& scene = ropes.scene;
    const Oracle oracle(scene);
    for (const auto& [a, b] : scene.enabledPairs()) {
      const TriangleMesh &of_a = scene.body(a).mesh, &of_b = scene.body(b).mesh;
      for (std::uint32_t i = 0; i < of_a.triangleCount(); ++i) {
        for (std::uint32_t j = a == b ? i + 1 : 0; j < of_b.triangleCount(); ++j) {
          const TrianglePair pair(a, i, b, j);
          const float margin_m = std::max(marginOf(scene, a, i), marginOf(scene, b, j));
          if (a == b && scene.body(a).radius_m > 0 &&
              wayBetween(of_a, i, j) < M_PI * scene.body(a).radius_m) {
            continue;
          }
          if (a == b && j == i + 1) continue;  // without a radius, neighbours only touch
          const float bare_m = oracle.bareM(pair);
          const float apart_m = oracle.apartM(a, b, bare_m);
          if (apart_m <= (lists_near ? margin_m : 0)) listed.emplace(pair, apart_m);
          if (a == b || apart_m > margin_m) continue;
          const auto [place, is_new] =
              nearest.emplace(std::make_pair(a, b), std::make_pair(bare_m, pair));
          if (!is_new && bare_m < place->second.first) place->second = {bare_m, pair};
        }
      }
    }
  }
};

double distanceTo(const Vec3f& p, const Triangle& t) { return exactDistance({{p, p, p}}, t); }

class Radii : public DetectorSuite {};

int sceneCount() {
  const char* const count = std::getenv("DCM_RADIUS_SCENES");
  return count == nullptr ? 200 : std::atoi(count);
}

TEST_P(Radii, EqualExactDistancesMinusRadii) {
  int touching = 0, near = 0, with_itself = 0, parted = 0;
  for (int seed = 0; seed < sceneCount(); ++seed) {
    SCOPED_TRACE(seed);
    const RandomRopes ropes(static_cast<std::uint32_t>(seed));
    const Scene& scene = ropes.scene;
    const Oracle oracle(scene);
    Options options;
    options.nearest = seed % 3 != 0;
    options.near_pairs = seed % 3 == 2;
    options.geometry = seed % 2 == 0;
    const bool lists_near = !options.nearest || options.near_pairs;
    const Expected expected(ropes, lists_near);
    // A pool knows radii and margins of parts, and so do the detectors in it.
    const auto pool = withRadiiAndPartMargins(makeBruteForceDetector());
    const DetectionResult& of_pool = pool->detect(scene, options);
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_TRUE(samePairs(result.contacts, of_pool.contacts));
    ASSERT_TRUE(result.nearest == of_pool.nearest);
    ASSERT_EQ(expected.listed.size(), result.contacts.size());
    EXPECT_TRUE(isOrdered(result.contacts));
    const bool has_separations = lists_near && scene.anyMargin();
    ASSERT_EQ(has_separations ? result.contacts.size() : 0, result.separations_m.size());
    ASSERT_EQ(options.geometry ? result.contacts.size() : 0, result.geometry.size());
    auto next = expected.listed.begin();
    for (std::size_t i = 0; i < result.contacts.size(); ++i, ++next) {
      const TrianglePair& pair = result.contacts[i];
      ASSERT_EQ(next->first, pair);
      ASSERT_EQ(next->second, result.separationM(i)) << pair;
      (result.touches(i) ? touching : near) += 1;
      with_itself += pair.body_a == pair.body_b ? 1 : 0;
      const float bare_m = oracle.bareM(pair);
      const double sum_m = oracle.sum(pair.body_a, pair.body_b);
      if (!options.geometry || bare_m == 0) continue;
      const PairGeometry& geometry = result.geometry[i];
      ASSERT_NEAR(bare_m - sum_m, geometry.separation_m, 1e-6);
      const Triangle a = oracle.triangle(pair.body_a, pair.triangle_a);
      const Triangle b = oracle.triangle(pair.body_b, pair.triangle_b);
      if (scene.body(pair.body_a).radius_m > 0) {
        ASSERT_NEAR(scene.body(pair.body_a).radius_m, distanceTo(geometry.point_a, a), 2e-6);
      }
      if (scene.body(pair.body_b).radius_m > 0) {
        ASSERT_NEAR(scene.body(pair.body_b).radius_m, distanceTo(geometry.point_b, b), 2e-6);
      }
      ++parted;
    }
    if (!options.nearest) continue;
    ASSERT_EQ(expected.nearest.size(), result.nearest.size());
    auto nearest = expected.nearest.begin();
    for (const NearestPair& found : result.nearest) {
      const auto& [bodies, least] = *nearest++;
      ASSERT_EQ(least.second, found.pair);
      ASSERT_EQ(oracle.apartM(bodies.first, bodies.second, least.first), found.distance_m);
      // Points of a body are within its radius of its triangle, or on its surface.
      const Triangle a = oracle.triangle(found.pair.body_a, found.pair.triangle_a);
      const Triangle b = oracle.triangle(found.pair.body_b, found.pair.triangle_b);
      const double to_a = distanceTo(found.point_a, a), to_b = distanceTo(found.point_b, b);
      if (found.distance_m == 0) {
        ASSERT_EQ(found.point_a, found.point_b);
        ASSERT_LE(to_a, scene.body(bodies.first).radius_m + 2e-6);
        ASSERT_LE(to_b, scene.body(bodies.second).radius_m + 2e-6);
      } else {
        ASSERT_NEAR(scene.body(bodies.first).radius_m, to_a, 2e-6);
        ASSERT_NEAR(scene.body(bodies.second).radius_m, to_b, 2e-6);
      }
    }
  }
  EXPECT_GT(touching, sceneCount());
  EXPECT_GT(near, sceneCount() / 3);
  EXPECT_GT(with_itself, sceneCount() / 10);
  EXPECT_GT(parted, sceneCount());
}

// A rope of 45 nodes around a finger: a contact exactly when the exact distance is at most the
// radius.
TEST_P(Radii, ARopeAroundAFingerTouchesWhereItsDistanceIsAtMostTheRadius) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr float kRadius = 0.004F, kHalf = 0.008F;
  std::vector<Vec3f> coil;
  for (int i = 0; i < 45; ++i) {
    const double turn = 4 * M_PI * i / 44;
    coil.push_back({static_cast<float>(0.0175 * std::cos(turn)),
                    static_cast<float>(0.0175 * std::sin(turn)), 0.0006F * (i - 22)});
  }
  TriangleMesh finger;
  for (int i = 0; i < 8; ++i) {
    for (const float x : {i & 1 ? kHalf : -kHalf, i & 2 ? kHalf : -kHalf, i & 4 ? 0.05F : -0.05F}) {
      finger.vertices.push_back(x);
    }
  }
  finger.triangles = {0, 1, 5, 0, 5, 4, 1, 3, 7, 1, 7, 5, 3, 2, 6, 3, 6, 7, 2, 0, 4, 2, 4, 6};
  Scene scene;
  scene.addBody("finger", finger);
  scene.addBody("rope", ropeOf(coil));
  scene.setRadius(1, kRadius);
  scene.setPairEnabled(0, 1, true);
  Options options;
  options.nearest = true;
  int touching = 0, close = 0;
  for (int step = 0; step < 1000; ++step) {
    RigidTransform pose;
    double q[4], length = 0;
    for (double& x : q) x = normal(random) * 0.05;
    q[3] += 1;
    for (const double x : q) length += x * x;
    for (double& x : q) x /= std::sqrt(length);
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double rotation[9] = {
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
        2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    std::copy(std::begin(rotation), std::end(rotation), std::begin(pose.rotation));
    for (double& t : pose.translation) t = (unit(random) - 0.5) * 0.006;
    scene.setPose(1, pose);
    const Oracle oracle(scene);
    float least_m = INFINITY;
    for (std::uint32_t i = 0; i < finger.triangleCount(); ++i) {
      for (std::uint32_t j = 0; j < 44; ++j) {
        const Triangle a = oracle.triangle(0, i), b = oracle.triangle(1, j);
        if (squaredGap(boxOf(a), boxOf(b)) > 0.005 * 0.005) continue;
        least_m = std::min(least_m, oracle.bareM({0, i, 1, j}));
      }
    }
    const DetectionResult& result = detector_->detect(scene, options);
    ASSERT_EQ(least_m <= kRadius, !result.contacts.empty()) << least_m;
    ASSERT_EQ(least_m <= kRadius, !result.nearest.empty()) << least_m;
    touching += result.contacts.empty() ? 0 : 1;
    close += std::abs(least_m - kRadius) < 1e-4F ? 1 : 0;
  }
  EXPECT_GT(touching, 200);
  EXPECT_LT(touching, 800);
  EXPECT_GT(close, 10);
}

// A rope through the hole of a plate touches it only if it is thicker than the hole is wide.
TEST_P(Radii, ARopeThroughAHoleIsFreeUntilItFillsIt) {
  TriangleMesh plate;
  constexpr int kCorners = 64;
  for (int i = 0; i < kCorners; ++i) {
    const double turn = 2 * M_PI * i / kCorners;
    for (const double r : {0.1, 0.3}) {
      plate.vertices.insert(plate.vertices.end(), {static_cast<float>(r * std::cos(turn)),
                                                   static_cast<float>(r * std::sin(turn)), 0});
    }
    const std::uint32_t a = 2U * static_cast<std::uint32_t>(i), b = (a + 2) % (2 * kCorners);
    plate.triangles.insert(plate.triangles.end(), {a, a + 1, b, a + 1, b + 1, b});
  }
  Scene scene = pairScene(plate, ropeOf({{0, 0, -0.5F}, {0, 0, 0.25F}, {0, 0, 0.5F}}));
  const double hole_m = 0.1 * std::cos(M_PI / kCorners);
  for (const double part : {0.0, 0.5, 0.99, 1.01}) {
    scene.setRadius(1, static_cast<float>(part * hole_m));
    EXPECT_EQ(part > 1, !contacts(scene).empty()) << part;
  }
}

// A pair may be hidden within a rope: the way along it is not known there, and not infinite.
TEST_P(Radii, AHiddenNodeMakesNoContactOfARopeWithItself) {
  std::vector<Vec3f> points;
  for (int i = 0; i < 20; ++i) points.push_back({0.01F * static_cast<float>(i), 0, 0});
  points[10].y = NAN;
  Scene scene = selfScene(ropeOf(points));
  scene.setRadius(0, 0.012F);
  EXPECT_TRUE(contacts(scene).empty());
  points[18] = {0.02F, 0.01F, 0};
  points[19] = {0.02F, 0.01F, 0.01F};
  scene.setMesh(0, ropeOf(points));
  EXPECT_FALSE(contacts(scene).empty());
}

// The bounds that a deadline asks for agree with the list, also where rounding decides.
TEST(RadiiOfAPool, BoundsAgreeWithWhatIsListed) {
  for (const float x : {std::nextafter(0.5F, 0.F), 0.5F, std::nextafter(0.5F, 1.F), 0.6F, 0.8F}) {
    for (const float margin_m : {0.F, 0.2F}) {
      for (const bool nearest : {true, false}) {
        Scene scene = pairScene(grainsOf({{0, 0, 0}}), grainsOf({{x, 0, 0}}));
        PoolSettings settings;
        settings.tilings = std::make_shared<TilingCache>();
        settings.cpu = [] { return makeCpuDetector(); };
        const std::shared_ptr<TilingCache> tilings = settings.tilings;
        const auto pool = makeDetectorPool(std::move(settings));
        Options tolerant;
        tolerant.tolerance_m = 1;
        for (std::uint32_t i = 0; i <= TilingCache::kSettledAfter; ++i) {
          pool->detect(scene, tolerant);
        }
        tilings->wait();
        scene.setRadius(1, 0.5F);
        scene.setMargin(0, margin_m);
        Options options;
        options.nearest = nearest;
        options.limits.deadline = Clock::now() + std::chrono::minutes(5);
        const DetectionResult& result = pool->detect(scene, options);
        ASSERT_EQ(1U, result.distances.size());
        const BodyDistance& distance = result.distances[0];
        const PairDecision expected = x <= 0.5F              ? PairDecision::kContact
                                      : x - 0.5F <= margin_m ? PairDecision::kNear
                                                             : PairDecision::kNone;
        EXPECT_EQ(expected, decide(distance, scene, 0)) << x << " " << margin_m << nearest;
        EXPECT_EQ(result.contacts.size(), distance.contact_count);
      }
    }
  }
}

TEST_P(Radii, GoWithParts) {
  Scene scene = pairScene(ropeOf({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}),
                          grainsOf({{0.5F, 0.1F, 0}, {1.5F, 0.1F, 0}}));
  scene.setRadius(0, 0.06F);
  scene.setRadius(1, 0.05F);
  scene.setParts(0, {0, 7});
  const std::vector<TrianglePair> both = {{0, 0, 1, 0}, {0, 1, 1, 1}};
  EXPECT_TRUE(samePairs(both, contacts(scene)));
  scene.setPartPairEnabled(0, 7, 1, 0, false);
  EXPECT_TRUE(samePairs({both[0]}, contacts(scene)));
  Options options;
  options.nearest = options.nearest_by_part = true;
  const DetectionResult& result = detector_->detect(scene, options);
  ASSERT_EQ(1U, result.nearest_parts.size());
  EXPECT_EQ(0U, result.nearest_parts[0].parts.part_a);
  EXPECT_EQ(0, result.nearest_parts[0].nearest.distance_m);
}

// Each says who has the radius, and what to do.
TEST_P(Radii, AreRefusedWhereTheyMeanNothing) {
  Scene scene = pairScene(grainsOf({{0, 0, 0}}), grainsOf({{1, 0, 0}}));
  EXPECT_THROW(scene.setRadius(0, -1), std::invalid_argument);
  EXPECT_THROW(scene.setRadius(0, NAN), std::invalid_argument);
  EXPECT_THROW(scene.setRadius(2, 1), std::invalid_argument);
  const auto refusal = [&](const Options& options) -> std::string {
    try {
      detector_->detect(scene, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  Options swept, tolerant;
  swept.motion = Motion::kSwept;
  tolerant.tolerance_m = 0.1F;
  scene.setRadius(1, 0.5F);
  EXPECT_NE(std::string::npos, refusal(swept).find("b: it has a radius, and motion"))
      << refusal(swept);
  EXPECT_NE(std::string::npos, refusal(tolerant).find("tolerance_m")) << refusal(tolerant);
  EXPECT_EQ("", refusal(Options()));
  scene.setPairEnabled(0, 1, false);
  EXPECT_EQ("", refusal(tolerant)) << "it takes no part";
}

#ifdef DCM_HAVE_FCL

TEST(FclRadii, AreRefused) {
  Scene scene = pairScene(grainsOf({{0, 0, 0}}), grainsOf({{1, 0, 0}}));
  scene.setRadius(1, 0.5F);
  EXPECT_THROW(makeFclDetector()->detect(scene), std::invalid_argument);
}

#endif

// The largest and the smallest radii.
TEST_P(Radii, MayBeExtreme) {
  Scene scene = pairScene(grainsOf({{0, 0, 0}}), grainsOf({{FLT_MAX, 0, 0}}));
  for (const float radius : {0.0F, FLT_TRUE_MIN, FLT_MAX / 2}) {
    scene.setRadius(0, radius);
    scene.setRadius(1, radius);
    EXPECT_EQ(radius > 1 ? 1U : 0U, contacts(scene).size()) << radius;
  }
  scene.setRadius(0, FLT_MAX);
  scene.setMargin(0, FLT_MAX);
  Options options;
  options.geometry = true;
  const DetectionResult& result = detector_->detect(scene, options);
  ASSERT_EQ(1U, result.geometry.size());
  EXPECT_TRUE(std::isfinite(result.geometry[0].separation_m));
  EXPECT_TRUE(std::isfinite(result.geometry[0].point_b.x));
  Scene close = pairScene(grainsOf({{0, 0, 0}}), grainsOf({{2 * FLT_TRUE_MIN, 0, 0}}));
  EXPECT_EQ(0U, contacts(close).size());
  close.setRadius(0, FLT_TRUE_MIN);
  EXPECT_EQ(0U, contacts(close).size());
  close.setRadius(1, FLT_TRUE_MIN);
  EXPECT_EQ(1U, contacts(close).size());
}

INSTANTIATE_TEST_SUITE_P(, Radii, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
