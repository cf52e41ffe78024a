// The triangles around a vertex: their order, certificates about all of them, and what detectors
// make of those.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "core/cpu/fans.h"
#include "core/predicates/adjacency.h"
#include "core/predicates/vertex_fan.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

struct Fan {
  std::vector<Vec3f> points;

  std::uint32_t size() const { return static_cast<std::uint32_t>(points.size()); }
  Vec3f ring(std::uint32_t k) const { return points[k]; }
  bool closed() const { return points.front() == points.back(); }
};

// A ring point every `degrees`, at these heights in turn; the last one is the first if the turn is
// full.
Fan fanOf(int triangles, double degrees, const std::vector<float>& heights) {
  Fan fan;
  for (int k = 0; k <= triangles; ++k) {
    const double angle = k * degrees * M_PI / 180;
    fan.points.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)),
                          heights[static_cast<std::size_t>(k) % heights.size()]});
  }
  if (std::fmod(triangles * degrees, 360) == 0) fan.points.back() = fan.points.front();
  return fan;
}

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  float real(float size) { return size * static_cast<float>(within(-1000, 1000)) * 1e-3F; }

 private:
  std::mt19937 random_;
};

// Returns whether two triangles of a fan meet beyond the points that they share. Points with equal
// coordinates are shared.
bool anyMeet(const Vec3f& centre, const Fan& fan) {
  for (std::uint32_t i = 0; i + 1 < fan.size(); ++i) {
    for (std::uint32_t j = i + 1; j + 1 < fan.size(); ++j) {
      const Triangle a{{centre, fan.ring(i), fan.ring(i + 1)}};
      const Triangle b{{centre, fan.ring(j), fan.ring(j + 1)}};
      PredicateState state;
      if (meetBeyondShared(a, b, sharedVertices(a, b), state)) return true;
    }
  }
  return false;
}

TEST(VertexFan, NamedFans) {
  const Vec3f centre;
  EXPECT_TRUE(isFanCertified(centre, fanOf(6, 60, {0})));
  EXPECT_TRUE(isFanCertified(centre, fanOf(6, 60, {0.3F, -0.3F})));
  EXPECT_TRUE(isFanCertified(centre, fanOf(3, 120, {0})));
  EXPECT_TRUE(isFanCertified(centre, fanOf(1, 90, {0})));
  EXPECT_TRUE(isFanCertified(centre, fanOf(5, 70, {0}))) << "350 degrees";
  EXPECT_FALSE(isFanCertified(centre, fanOf(6, 70, {0}))) << "420 degrees";
  EXPECT_FALSE(isFanCertified(centre, fanOf(6, 120, {0}))) << "twice around, closed";
  EXPECT_FALSE(isFanCertified(centre, fanOf(5, 144, {0}))) << "a pentagram";
  EXPECT_FALSE(isFanCertified(centre, fanOf(2, 180, {0}))) << "degenerate";
  EXPECT_FALSE(isFanCertified(centre, Fan{{{1, 0, 0}, {0, 1, 0}, {1, 0, 0}}})) << "folded";
  EXPECT_FALSE(isFanCertified(centre, Fan{{centre, {0, 1, 0}, {1, 0, 0}}})) << "no ring";
  EXPECT_FALSE(isFanCertified(centre, Fan{{centre}}));
  for (const float size : {1e-30F, 1e30F, NAN, INFINITY}) {
    EXPECT_FALSE(isFanCertified(centre, Fan{{{size, 0, 0}, {0, size, 0}, {-size, -size, 0}}}));
  }
}

// On coarse grids, where touching and folded ones are common, and off them; some wound twice.
TEST(VertexFan, TrianglesOfCertifiedFansMeetInWhatTheyShare) {
  Dice dice(1);
  int certified = 0, clean = 0;
  constexpr int kFans = 40000;
  for (int n = 0; n < kFans; ++n) {
    const int triangles = dice.within(2, 9), turns = dice.within(1, 8) == 1 ? 2 : 1;
    const float height = dice.within(0, 2) == 0 ? 0.0F : std::ldexp(1.0F, dice.within(-12, 1));
    const bool grid = dice.within(0, 1) == 0, closed = dice.within(0, 1) == 0;
    Fan fan = fanOf(triangles, 360.0 * turns / triangles, {0});
    for (Vec3f& p : fan.points) {
      p = p + Vec3f{dice.real(0.6F), dice.real(0.6F), dice.real(height)};
      if (grid) p = {std::rint(3 * p.x), std::rint(3 * p.y), std::rint(3 * p.z)};
    }
    if (closed) fan.points.back() = fan.points.front();
    const bool meet = anyMeet({}, fan);
    clean += !meet;
    if (!isFanCertified(Vec3f(), fan)) continue;
    ++certified;
    ASSERT_FALSE(meet) << "fan " << n;
  }
  EXPECT_GT(certified, kFans / 10);
  EXPECT_LT(clean, kFans * 9 / 10);
}

TEST(VertexFans, RingsAreTheTrianglesAroundAVertex) {
  Dice dice(2);
  int ordered = 0;
  for (int n = 0; n < 300; ++n) {
    TriangleMesh mesh = clothGrid(dice.within(1, 5), 1, 0, 0);
    for (int changes = dice.within(0, 6); changes > 0; --changes) {  // holes, turns, wrong corners
      const auto t =
          3 * static_cast<std::size_t>(dice.within(0, static_cast<int>(mesh.triangleCount()) - 1));
      const int what = dice.within(0, 2);
      if (what == 0) std::swap(mesh.triangles[t], mesh.triangles[t + 1]);
      if (what == 1) mesh.triangles[t] = mesh.triangles[3 * (t / 6)];
      if (what == 2)
        mesh.triangles.erase(mesh.triangles.begin() + static_cast<long>(t),
                             mesh.triangles.begin() + static_cast<long>(t) + 3);
      if (mesh.triangles.empty()) break;
    }
    const VertexFans fans = vertexFans(mesh);
    ASSERT_EQ(mesh.vertexCount() + 1, fans.begin.size());
    using Corner = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;
    std::multiset<Corner> expected, found;
    std::set<std::uint32_t> with_ring;
    for (std::uint32_t v = 0; v < mesh.vertexCount(); ++v) {
      if (fans.ring[fans.begin[v]] == v) continue;
      ++ordered;
      with_ring.insert(v);
      for (std::uint32_t k = fans.begin[v]; k + 1 < fans.begin[v + 1]; ++k) {
        found.insert({v, fans.ring[k], fans.ring[k + 1]});
      }
    }
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
      const std::uint32_t* corner = &mesh.triangles[t];
      for (int k = 0; k < 3; ++k) {
        if (with_ring.count(corner[k]) == 0) continue;
        expected.insert({corner[k], corner[(k + 1) % 3], corner[(k + 2) % 3]});
      }
    }
    ASSERT_EQ(expected, found) << "mesh " << n;
  }
  EXPECT_GT(ordered, 1000);
}

class CrumpledCloths : public DetectorSuite {};

// A cloth of which every vertex is off by up to `by` of an edge.
TriangleMesh crumpled(int n, float by, Dice& dice) {
  TriangleMesh mesh = clothGrid(n, 1, 0, 0.1F);
  for (float& x : mesh.vertices) x += dice.real(by / static_cast<float>(n));
  return mesh;
}

// Compared with brute force, which knows no certificates. The detector sees them one after the
// other, so that what it keeps of a body must follow.
TEST_P(CrumpledCloths, HaveTheContactsOfBruteForce) {
  Dice dice(3);
  const auto reference = makeBruteForceDetector();
  std::size_t sharing = 0;
  Scene scene = selfScene(clothGrid(10, 1, 0, 0.1F));
  for (const float by : {0.0F, 0.3F, 0.8F, 2.0F}) {
    for (int n = 0; n < 12; ++n) {
      TriangleMesh mesh = crumpled(10, by, dice);
      if (n % 4 == 1) mesh = soupOf(mesh);
      if (n % 4 == 2) {  // seams: some vertices a second time
        for (std::size_t t = 0; t < mesh.triangles.size(); t += 7) {
          const Vec3f v = mesh.vertex(mesh.triangles[t]);
          mesh.triangles[t] = static_cast<std::uint32_t>(mesh.vertexCount());
          mesh.vertices.insert(mesh.vertices.end(), {v.x, v.y, v.z});
        }
      }
      if (n % 4 == 3) {  // other triangles, as many: folded over, turned round, doubled
        for (std::size_t t = 0; t + 6 < mesh.triangles.size(); t += 33) {
          mesh.triangles[t] = mesh.triangles[t + 5];
        }
      }
      scene.setMesh(0, mesh);
      for (const Predicates predicates : {Predicates::kExact, Predicates::kConservative}) {
        for (const AdjacentPairs adjacent : kBothAdjacent) {
          Options options = withAdjacent(adjacent);
          options.predicates = predicates;
          const std::vector<TrianglePair> expected = reference->detect(scene, options).contacts;
          EXPECT_TRUE(samePairs(expected, contacts(scene, options))) << by << " " << n;
          const bool beyond = adjacent == AdjacentPairs::kBeyondShared;
          sharing += beyond ? expected.size() : -expected.size();
        }
      }
    }
  }
  EXPECT_GT(sharing, 1000U);
}

// Equal places that move apart and together again: no certificate may outlive them.
TEST_P(CrumpledCloths, CertificatesAreOfThisCycle) {
  const auto reference = makeBruteForceDetector();
  const TriangleMesh flat = clothGrid(8, 1, 0, 0);
  Scene scene = selfScene(flat);
  Dice dice(4);
  std::vector<std::vector<float>> states(4, flat.vertices);
  for (float& x : states[1]) x += dice.real(0.3F);
  for (std::size_t i = 3; i + 3 < states[2].size(); i += 9) {  // two vertices in one place
    for (int k = 0; k < 3; ++k) states[2][i + static_cast<std::size_t>(k)] = states[2][k];
  }
  for (std::size_t i = 2; i < states[3].size(); i += 3) {  // folded over
    if (states[3][i - 2] > states[3][0]) states[3][i - 2] = 2 * states[3][0] - states[3][i - 2];
  }
  for (int i = 0; i < 12; ++i) {
    const std::vector<float>& state = states[static_cast<std::size_t>(i * 7 % 4)];
    scene.setVertices(0, state.data(), state.size() / 3);
    const AdjacentPairs adjacent = kBothAdjacent[i % 5 == 0 ? 0 : 1];
    const Options options = withAdjacent(adjacent);
    EXPECT_TRUE(samePairs(reference->detect(scene, options).contacts, contacts(scene, options)))
        << i;
  }
}

// Far from the origin rounding folds fans that are flat in the body's own frame.
TEST_P(CrumpledCloths, CertificatesAreOfPosedVertices) {
  const auto reference = makeBruteForceDetector();
  Scene scene = selfScene(clothGrid(16, 1, 0, 0.1F));
  EXPECT_TRUE(contacts(scene, withAdjacent(AdjacentPairs::kBeyondShared)).empty());
  std::size_t sharing = 0;
  for (const double far : {1e4, 2e5, 5e5, 1e6}) {
    RigidTransform pose;
    const double rotation[9] = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1};
    std::copy(rotation, rotation + 9, pose.rotation);
    std::fill(pose.translation, pose.translation + 3, far);
    scene.setPose(0, pose);
    for (const AdjacentPairs adjacent : kBothAdjacent) {
      const Options options = withAdjacent(adjacent);
      const std::vector<TrianglePair> expected = reference->detect(scene, options).contacts;
      EXPECT_TRUE(samePairs(expected, contacts(scene, options))) << far;
      sharing += adjacent == AdjacentPairs::kBeyondShared ? expected.size() : -expected.size();
    }
  }
  EXPECT_GT(sharing, 50U);
}

// Without certificates 18 565 pairs that share a vertex are candidates, where the cloth is flat.
TEST_P(CrumpledCloths, SmoothNeighboursAreNoCandidates) {
  const bool certifies = GetParam().make != makeBruteForceDetector;
  for (const float wave_height : {0.0F, 0.1F}) {
    const Scene scene = selfScene(clothGrid(40, 1, 0, wave_height));
    std::uint64_t candidates[2];
    for (int i = 0; i < 2; ++i) {
      const auto detector = GetParam().make();
      for (int n = 0; n < 4; ++n) {  // clusters settle
        const DetectionResult& result = detector->detect(scene, withAdjacent(kBothAdjacent[i]));
        EXPECT_TRUE(result.contacts.empty());
        candidates[i] = result.counters.candidates;
      }
    }
    EXPECT_EQ(certifies, candidates[1] < candidates[0] + 2000)
        << candidates[0] << " " << candidates[1];
  }
}

INSTANTIATE_TEST_SUITE_P(, CrumpledCloths, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
