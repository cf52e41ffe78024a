// Tests what settings for speed may cost, and what must cost nothing: overlap, numbers of clusters,
// outliers.
#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "detector_suite.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

Options with256Clusters() {
  Options options = withAdjacent(AdjacentPairs::kSkip);
  options.clusters = 256;
  return options;
}

TriangleMesh clothOnBall() { return readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply")); }

void addTriangle(const Triangle& triangle, TriangleMesh* mesh) {
  for (const Vec3f& v : triangle.v) {
    mesh->triangles.push_back(static_cast<std::uint32_t>(mesh->vertexCount()));
    mesh->vertices.insert(mesh->vertices.end(), {v.x, v.y, v.z});
  }
}

class Trade : public DetectorSuite {
 protected:
  // Returns the counters after a few warm cycles.
  Counters settled(const Scene& scene, const Options& options) {
    for (int cycle = 0; cycle < 4; ++cycle) detector_->detect(scene, options);
    return detector_->detect(scene, options).counters;
  }
  // On CUDA the entries of clusters are tiles of triangles (Counters, Options::overlap). Each
  // triangle is in more clusters then, so that fewer pairs are lost.
  bool inTiles() const { return std::string(GetParam().name) == "cuda"; }
};

// Hard clustering must neither pass for complete nor be what `overlap: 1` does.
TEST_P(Trade, OverlapZeroLosesPairsAndSaysSo) {
  DCM_REQUIRE_TEST_DATA();
  const Scene scene = selfScene(clothOnBall());
  Options options = with256Clusters();
  const std::vector<TrianglePair> complete = contacts(scene, options);
  EXPECT_TRUE(detector_->detect(scene, options).guaranteed);
  EXPECT_EQ(61530U, complete.size());
  std::size_t before = 0;
  std::uint64_t entries_before = 0;
  for (const float overlap : {0.0F, 0.5F, 1.0F}) {
    options.overlap = overlap;
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(isOrdered(result.contacts));
    EXPECT_TRUE(std::includes(complete.begin(), complete.end(), result.contacts.begin(),
                              result.contacts.end()))
        << "overlap " << overlap;
    EXPECT_EQ(overlap == 1, result.guaranteed);
    EXPECT_GE(result.contacts.size(), before) << "overlap " << overlap;
    EXPECT_GT(result.counters.cluster_entries, entries_before);
    if (overlap == 0) {
      // But for a triangle whose centroid has two nearest prototypes, for all that rounding can
      // tell. A tile is where one of its triangles is.
      EXPECT_GE(result.counters.cluster_entries, result.counters.clustered);
      EXPECT_LE(result.counters.cluster_entries,
                result.counters.clustered + (inTiles() ? 5 * result.counters.clustered / 4
                                                       : result.counters.clustered / 1000));
      EXPECT_LT(result.contacts.size(), complete.size() - (inTiles() ? 100 : 500));
      EXPECT_GT(result.contacts.size(), complete.size() / 2);
    }
    before = result.contacts.size();
    entries_before = result.counters.cluster_entries;
  }
  EXPECT_EQ(complete.size(), before);
}

TEST_P(Trade, OverlapAloneTakesTheGuarantee) {
  const Scene scene = pairScene(clothGrid(10, 1, 0, 0.1F), clothGrid(10, 1, 0, -0.1F));
  Options options;
  for (const Predicates predicates : {Predicates::kExact, Predicates::kConservative}) {
    for (const float overlap : {0.5F, 1.0F}) {
      options.predicates = predicates;
      options.overlap = overlap;
      EXPECT_EQ(overlap == 1, detector_->detect(scene, options).guaranteed)
          << toString(predicates) << ", overlap " << overlap;
    }
  }
}

TEST(Predicates, AreFoundByTheirNames) {
  for (const Predicates predicates : {Predicates::kExact, Predicates::kConservative}) {
    EXPECT_EQ(predicates, toPredicates(toString(predicates)));
  }
  try {
    toPredicates("fast");
    FAIL() << "accepted";
  } catch (const std::invalid_argument& refusal) {
    EXPECT_STREQ("predicates 'fast' is none of exact, conservative", refusal.what());
  }
}

TEST_P(Trade, OptionsOutOfRangeAreRefusedAllAtOnce) {
  Options options;
  options.overlap = 2;
  options.fuzzifier = 0.5F;
  try {
    detector_->detect(pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0)), options);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& refusal) {
    const std::string what = refusal.what();
    EXPECT_NE(std::string::npos, what.find("overlap")) << what;
    EXPECT_NE(std::string::npos, what.find("fuzzifier")) << what;
  }
}

TEST_P(Trade, WorkAt256Clusters) {
  DCM_REQUIRE_TEST_DATA();
  const Scene scene = selfScene(clothOnBall());
  const Counters c = settled(scene, with256Clusters());
  EXPECT_GE(c.clusters, 200U);
  EXPECT_LE(static_cast<double>(c.cluster_entries),
            (inTiles() ? 3.1 : 1.45) * static_cast<double>(c.clustered));
  EXPECT_LE(c.interval_overlaps, 9500000U);
  EXPECT_GT(c.clustered + c.large, 92000U);
}

TEST_P(Trade, OutliersCostOnlyThemselves) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh cloth = clothOnBall();
  float low[3], high[3];
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = high[axis] = cloth.vertices[static_cast<std::size_t>(axis)];
  }
  for (std::size_t i = 0; i < cloth.vertices.size(); ++i) {
    low[i % 3] = std::min(low[i % 3], cloth.vertices[i]);
    high[i % 3] = std::max(high[i % 3], cloth.vertices[i]);
  }
  const float below = low[1] - 0.1F * (high[1] - low[1]);
  const float size = 50 * (high[0] - low[0]);
  struct Outliers {
    const char* name;
    std::vector<Triangle> triangles;
  };
  const std::vector<Outliers> all = {
      {"a vertex at 1e30",
       {{{{low[0], high[1], low[2]}, {high[0], high[1], low[2]}, {0, 1e30F, 0}}}}},
      {"a small triangle at 1e30", {{{{1e30F, 0, 0}, {1e30F, 1, 0}, {1e30F, 0, 1}}}}},
      {"two huge floor triangles",
       {{{{-size, below, -size}, {size, below, -size}, {size, below, size}}},
        {{{-size, below, -size}, {size, below, size}, {-size, below, size}}}}},
      {"two huge triangles through the cloth",
       {{{{-size, low[1], -size}, {size, high[1], -size}, {size, high[1], size}}},
        {{{-size, low[1], -size}, {size, high[1], size}, {-size, low[1], size}}}}},
  };
  for (const int clusters : {256, 0}) {
    Options options = with256Clusters();
    options.clusters = clusters;
    detector_->reset();
    const Counters plain = settled(selfScene(cloth), options);
    for (const Outliers& outliers : all) {
      TriangleMesh mesh = cloth;
      for (const Triangle& triangle : outliers.triangles) addTriangle(triangle, &mesh);
      const Scene scene = selfScene(mesh);
      detector_->reset();
      const Counters c = settled(scene, options);
      EXPECT_LT(static_cast<double>(c.interval_overlaps),
                1.1 * static_cast<double>(plain.interval_overlaps))
          << outliers.name << ", clusters " << clusters;
      EXPECT_LT(static_cast<double>(c.cluster_entries),
                1.1 * static_cast<double>(plain.cluster_entries))
          << outliers.name << ", clusters " << clusters;
      EXPECT_TRUE(samePairs(oracleContacts(scene, AdjacentPairs::kSkip), contacts(scene, options)))
          << outliers.name << ", clusters " << clusters;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, Trade, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
