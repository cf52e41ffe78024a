// Steps in which bodies turn, against their true motion: many times of the step, each looked at
// with exact rationals.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include "core/substeps.h"
#include "exact_triangles.h"
#include "pair_sets.h"
#include "scenes.h"
#include "swept/screw_motions.h"
#include "test/core/ccd/swept_suite.h"

namespace deformable_contact_monitor {
namespace {

// A body on a screw motion, whose vertices move straight in its own frame.
struct TrueBody {
  TriangleMesh mesh;
  std::vector<float> earlier;  // empty: it is rigid
  ScrewMotion screw;

  Place vertexAt(std::uint32_t i, double part) const {
    Place v;
    for (std::size_t k = 0; k < 3; ++k) {
      const double to = mesh.vertices[3 * i + k];
      v[k] = earlier.empty() ? to : earlier[3 * i + k] + part * (to - earlier[3 * i + k]);
    }
    return placeOf(screw.at(part), v);
  }

  exact::Corners triangleAt(std::uint32_t t, double part) const {
    exact::Corners corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const Place p = vertexAt(mesh.triangles[3 * t + i], part);
      corners[i] = exact::Point(p[0], p[1], p[2]);
    }
    return corners;
  }
};

bool boxesMeet(const exact::Corners& a, const exact::Corners& b) {
  for (int k = 0; k < 3; ++k) {
    const auto range = [k](const exact::Corners& t) {
      return std::minmax(
          {CGAL::to_double(t[0][k]), CGAL::to_double(t[1][k]), CGAL::to_double(t[2][k])});
    };
    const std::pair<double, double> in_a = range(a), in_b = range(b);
    if (in_a.first > in_b.second || in_b.first > in_a.second) return false;
  }
  return true;
}

// The true contacts of bodies 0 and 1, and at what sample first.
std::map<std::pair<std::uint32_t, std::uint32_t>, double> trueContacts(const TrueBody& a,
                                                                       const TrueBody& b,
                                                                       int samples) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> first;
  for (int k = 0; k <= samples; ++k) {
    const double part = static_cast<double>(k) / samples;
    std::vector<exact::Corners> of_b;
    for (std::uint32_t t = 0; t < b.mesh.triangleCount(); ++t) {
      of_b.push_back(b.triangleAt(t, part));
    }
    for (std::uint32_t s = 0; s < a.mesh.triangleCount(); ++s) {
      const exact::Corners of_a = a.triangleAt(s, part);
      for (std::uint32_t t = 0; t < b.mesh.triangleCount(); ++t) {
        if (first.count({s, t}) != 0 || !boxesMeet(of_a, of_b[t])) continue;
        if (exact::meetBeyond(of_a, of_b[t], {})) first[{s, t}] = part;
      }
    }
  }
  return first;
}

Scene sceneOf(const std::vector<TrueBody>& bodies) {
  Scene scene;
  for (const TrueBody& body : bodies) {
    const BodyId id = scene.addBody("body " + std::to_string(scene.bodyCount()), body.mesh);
    scene.setPose(id, body.screw.at(1));
    scene.setEarlier(id, body.screw.at(0), body.earlier);
  }
  scene.setPairEnabled(0, 1, true);
  return scene;
}

// Small triangles, up to `reach` from the body's origin.
TriangleMesh shards(std::mt19937* random, int count, double reach) {
  std::vector<Triangle> triangles;
  for (int i = 0; i < count; ++i) {
    const Place centre = randomUnit(random);
    Triangle t;
    for (Vec3f& v : t.v) {
      const Place off = randomUnit(random);
      v = {static_cast<float>(reach * centre[0] + 0.2 * off[0]),
           static_cast<float>(reach * centre[1] + 0.2 * off[1]),
           static_cast<float>(reach * centre[2] + 0.2 * off[2])};
    }
    triangles.push_back(t);
  }
  return meshOf(triangles);
}

std::vector<float> shifted(std::mt19937* random, const TriangleMesh& mesh, double by) {
  std::vector<float> vertices = mesh.vertices;
  for (float& x : vertices) x += static_cast<float>(uniform(random, -by, by));
  return vertices;
}

class SubStepsTruth : public DetectorSuite {
 protected:
  // And counts those that were compared.
  void expectAllOfTheTrueMotion(const TrueBody& a, const TrueBody& b,
                                const std::vector<BodyPath>& paths, double tolerance_m);

  SubStepDetector steps_{*detector_};
  int contacts_ = 0, only_swept_ = 0;
};

void SubStepsTruth::expectAllOfTheTrueMotion(const TrueBody& a, const TrueBody& b,
                                             const std::vector<BodyPath>& paths,
                                             double tolerance_m) {
  const Scene scene = sceneOf({a, b});
  Options options;
  options.first_times = true;
  const StepResult& result = steps_.detect(scene, paths, tolerance_m, options);
  const DetectionResult& found = result.detection;
  ASSERT_TRUE(isOrdered(found.contacts));
  ASSERT_EQ(found.within_pad.size(), found.contacts.size());
  for (const auto& [pair, part] : trueContacts(a, b, 150)) {
    const TrianglePair wanted(0, pair.first, 1, pair.second);
    const auto at = std::lower_bound(found.contacts.begin(), found.contacts.end(), wanted);
    ASSERT_TRUE(at != found.contacts.end() && *at == wanted)
        << wanted << " at " << part << ", tolerance " << tolerance_m;
    const auto i = static_cast<std::size_t>(at - found.contacts.begin());
    ASSERT_LE(found.first_times[i].low, part) << wanted;
    ++contacts_;
    only_swept_ += part > 0;
  }
}

TEST_P(SubStepsTruth, EveryContactOfALinkThatTurnsIsFound) {
  std::mt19937 random(1);
  for (int i = 0; i < 25; ++i) {
    TrueBody link{shards(&random, 12, 0.5), {}, randomScrewMotion(&random, 0.2, 1.5)};
    TrueBody cloth{shards(&random, 60, 0.5), {}, {}};
    cloth.earlier = shifted(&random, cloth.mesh, 0.05);
    for (const double tolerance_m : {1e-2, 1e-4}) {
      expectAllOfTheTrueMotion(link, cloth, {link.screw.path(i % 3), {}}, tolerance_m);
      ASSERT_FALSE(HasFatalFailure()) << i;
    }
  }
  EXPECT_GT(contacts_, 600);
  EXPECT_GT(only_swept_, 400);
}

TEST_P(SubStepsTruth, EveryContactOfTwoThatTurnIsFound) {
  std::mt19937 random(2);
  for (int i = 0; i < 25; ++i) {
    const TrueBody a{shards(&random, 15, 0.5), {}, randomScrewMotion(&random, 0.2, 0.8)};
    TrueBody b{shards(&random, 40, 0.5), {}, randomScrewMotion(&random, 0.2, 0.5)};
    if (i % 2 == 0) b.earlier = shifted(&random, b.mesh, 0.05);  // in a frame that turns
    expectAllOfTheTrueMotion(a, b, {a.screw.path(i % 2), b.screw.path(i % 5)}, 1e-3);
    ASSERT_FALSE(HasFatalFailure()) << i;
  }
  EXPECT_GT(contacts_, 200);
  EXPECT_GT(only_swept_, 100);
}

// More pieces than there may be: pads are larger than was asked for, and cover what is left.
TEST_P(SubStepsTruth, AtMostSoManySubStepsAndTheRestIsPad) {
  std::mt19937 random(3);
  for (int i = 0; i < 5; ++i) {
    TrueBody link{shards(&random, 12, 0.5), {}, randomScrewMotion(&random, 0.2, 0.1)};
    link.screw.angle = 3;
    const TrueBody still{shards(&random, 60, 0.5), {}, {}};
    expectAllOfTheTrueMotion(link, still, {link.screw.path(), {}}, 1e-9);
    const StepResult& result =
        steps_.detect(sceneOf({link, still}), {link.screw.path(), {}}, 1e-9, Options());
    EXPECT_GT(result.sub_steps, kMostSubSteps / 2);
    EXPECT_LE(result.sub_steps, kMostSubSteps);
    const double arc = 9 * 0.5 / 8 / result.sub_steps / result.sub_steps;
    EXPECT_GT(result.pad_m, arc * 0.5);
    EXPECT_LT(result.pad_m, arc * 1.5);
  }
  EXPECT_GT(only_swept_, 50);
}

// A finer tolerance costs more sub-steps, and leaves fewer pairs that only may touch.
TEST_P(SubStepsTruth, AFinerToleranceLeavesFewerPairsToThePads) {
  std::mt19937 random(4);
  const TrueBody link{shards(&random, 150, 0.5), {}, randomScrewMotion(&random, 0.1, 0.4)};
  TrueBody cloth{shards(&random, 300, 0.5), {}, {}};
  cloth.earlier = shifted(&random, cloth.mesh, 0.01);
  std::vector<double> shares;
  for (const double tolerance_m : {1e-2, 1e-3, 1e-4, 1e-5}) {
    const StepResult& result =
        steps_.detect(sceneOf({link, cloth}), {link.screw.path(), {}}, tolerance_m, Options());
    const std::vector<std::uint8_t>& within = result.detection.within_pad;
    shares.push_back(static_cast<double>(std::count(within.begin(), within.end(), 1)) /
                     static_cast<double>(within.size()));
  }
  for (std::size_t i = 1; i < shares.size(); ++i) EXPECT_LE(shares[i], shares[i - 1]);
  EXPECT_GT(shares[0], 0.02);
  EXPECT_LT(shares[2], 0.002);
}

INSTANTIATE_TEST_SUITE_P(, SubStepsTruth, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
