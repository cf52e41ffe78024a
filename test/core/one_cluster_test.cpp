// A million triangles in one cluster, on every backend, against the exact oracle.
#include "cgal_oracle.h"
#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A ribbon of squares of edge 1 along x, two triangles each; on integers.
TriangleMesh ribbon(std::uint32_t length, std::uint32_t width) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= length; ++i) {
    for (std::uint32_t j = 0; j <= width; ++j) {
      const auto height = static_cast<float>((i * 7 + j * 5) % 3);
      mesh.vertices.insert(mesh.vertices.end(),
                           {static_cast<float>(i), static_cast<float>(j), height});
      if (i == length || j == width) continue;
      const std::uint32_t a = i * (width + 1) + j, b = a + 1, c = a + width + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {a, b, c, b, d, c});
    }
  }
  return mesh;
}

class OneCluster : public DetectorSuite {};

TEST_P(OneCluster, OfAMillionTriangles) {
  Scene scene = selfScene(ribbon(250000, 2));
  ASSERT_EQ(scene.triangleCount(), 1000000U);
  // Another ribbon goes through it, along the whole of it.
  TriangleMesh through = ribbon(250000, 1);
  for (std::size_t i = 0; i < through.vertices.size(); i += 3) {
    through.vertices[i] += 0.25F;
    through.vertices[i + 1] += 0.5F;
    if (i % 600 == 0)
      through.vertices[i + 2] = 3;
    else
      through.vertices[i + 2] -= 9;
  }
  scene.addBody("through", through);
  scene.setPairEnabled(0, 1, true);
  const std::vector<TrianglePair> expected = oracleContacts(scene, AdjacentPairs::kSkip);
  ASSERT_GT(expected.size(), 1000U);
  Options options = withAdjacent(AdjacentPairs::kSkip);
  options.clusters = 1;
  for (int cycle = 0; cycle < 2; ++cycle) {
    const DetectionResult& result = detector_->detect(scene, options);
    EXPECT_TRUE(samePairs(expected, result.contacts));
    EXPECT_EQ(result.counters.clusters, 1U);
    EXPECT_GT(result.counters.largest_cluster, 1000000U);
  }
}

INSTANTIATE_TEST_SUITE_P(, OneCluster, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
