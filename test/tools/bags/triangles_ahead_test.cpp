// Triangles that come later than their meshes: worked examples, and random recordings against the
// rule, looked up forwards.
#include "tools/bags/triangles_ahead.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <boost/make_shared.hpp>
#include <optional>
#include <random>
#include <tuple>
#include <vector>

namespace deformable_contact_monitor {
namespace {

DeformableMesh::ConstPtr mesh(std::uint32_t id, std::size_t vertices, bool with_triangles) {
  const auto message = boost::make_shared<DeformableMesh>();
  message->topology_id = id;
  message->vertices.resize(3 * vertices);
  if (with_triangles) message->triangles = {0, 1, 2};
  return message;
}

struct Recorded {
  double stamp_s;
  DeformableMesh::ConstPtr mesh;
  std::size_t part = 0;  // how often the clock had gone back
};

// Numbers are places in `meshes`, which is in order of receipt.
TrianglesAhead settled(const std::vector<Recorded>& meshes) {
  TrianglesAhead ahead;
  std::vector<TrianglesAhead::Cycle> cycles;
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    ahead.add("cloth", i, ros::Time(meshes[i].stamp_s), meshes[i].mesh);
    cycles.push_back({i, meshes[i].part});
  }
  std::stable_sort(cycles.begin(), cycles.end(), [&meshes](const auto& a, const auto& b) {
    return std::tie(a.part, meshes[a.number].stamp_s) < std::tie(b.part, meshes[b.number].stamp_s);
  });
  ahead.settle(cycles);
  return ahead;
}

TEST(TrianglesAhead, TheFirstMeshThatNeedsThemGetsTheNext) {
  const std::vector<Recorded> meshes = {
      {1, mesh(4, 3, false)}, {2, mesh(4, 3, false)}, {3, mesh(4, 3, true)}, {4, mesh(4, 3, false)},
      {5, mesh(4, 3, true)},  {6, mesh(5, 3, false)}, {7, mesh(5, 3, true)}};
  const TrianglesAhead ahead = settled(meshes);
  EXPECT_EQ(ahead.of(0), meshes[2].mesh);
  EXPECT_EQ(ahead.of(5), meshes[6].mesh);
  for (const std::uint64_t other : {1, 2, 3, 4, 6, 7}) EXPECT_EQ(ahead.of(other), nullptr);
  EXPECT_EQ(ahead.count(), 3U);
}

TEST(TrianglesAhead, OtherIdsVerticesAndObjectsAreOtherTopologies) {
  EXPECT_EQ(settled({{1, mesh(4, 3, false)}, {2, mesh(5, 3, true)}}).of(0), nullptr);
  EXPECT_EQ(settled({{1, mesh(4, 3, false)}, {2, mesh(4, 4, true)}}).of(0), nullptr);
  EXPECT_EQ(settled({{1, mesh(4, 3, false)}, {2, mesh(5, 3, false)}, {3, mesh(4, 3, true)}}).of(0),
            nullptr)
      << "it may be another one under the same number";
  TrianglesAhead ahead;
  ahead.add("cloth", 0, ros::Time(1), mesh(4, 3, false));
  ahead.add("towel", 1, ros::Time(2), mesh(4, 3, true));
  ahead.settle({{0, 0}, {1, 0}});
  EXPECT_EQ(ahead.of(0), nullptr);
}

TEST(TrianglesAhead, StampsCountNotTheOrderOfReceipt) {
  const std::vector<Recorded> meshes = {
      {3, mesh(4, 3, true)}, {1, mesh(4, 3, false)}, {2, mesh(4, 3, false)}};
  const TrianglesAhead ahead = settled(meshes);
  EXPECT_EQ(ahead.of(1), meshes[0].mesh);
  EXPECT_EQ(ahead.of(2), nullptr);
  EXPECT_EQ(ahead.count(), 2U);
}

// A simulator that starts anew counts ids anew, so an id may stand for other triangles.
TEST(TrianglesAhead, AreOfTheSameEpisode) {
  const std::vector<Recorded> meshes = {
      {1.01, mesh(1, 3, false), 0}, {2.01, mesh(1, 3, true), 0}, {3.01, mesh(1, 3, false), 0},
      {1, mesh(2, 3, false), 1},    {1.5, mesh(1, 3, false), 1}, {2, mesh(1, 3, false), 1},
      {3, mesh(1, 3, true), 1},     {4, mesh(1, 3, false), 1},   {1, mesh(1, 3, false), 2}};
  const TrianglesAhead ahead = settled(meshes);
  EXPECT_EQ(ahead.of(0), meshes[1].mesh);
  EXPECT_EQ(ahead.of(4), meshes[6].mesh);
  for (const std::uint64_t other : {1, 2, 3, 5, 6, 7, 8}) EXPECT_EQ(ahead.of(other), nullptr);
  EXPECT_EQ(ahead.count(), 3U);
}

// The rule, from a mesh on; `known`: the id whose triangles are known.
DeformableMesh::ConstPtr wanted(const std::vector<Recorded>& meshes, std::size_t from,
                                const std::optional<std::uint32_t>& known) {
  const DeformableMesh& first = *meshes[from].mesh;
  if (!first.triangles.empty() || known == first.topology_id) return nullptr;
  for (std::size_t i = from; i < meshes.size(); ++i) {
    const DeformableMesh& other = *meshes[i].mesh;
    if (other.topology_id != first.topology_id || other.vertices.size() != first.vertices.size()) {
      return nullptr;
    }
    if (!other.triangles.empty()) return meshes[i].mesh;
  }
  return nullptr;
}

TEST(TrianglesAhead, IsTheRuleForRandomRecordings) {
  std::mt19937 random(7);
  std::size_t found = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<Recorded> meshes;
    std::uint32_t id = 0;
    for (std::size_t i = 0; i < 12; ++i) {
      if (random() % 4 == 0) id = static_cast<std::uint32_t>(random() % 3);
      meshes.push_back(
          {1.0 + static_cast<double>(i),
           mesh(id, 3 + static_cast<std::size_t>(random() % 8 == 0), random() % 4 == 0)});
    }
    const TrianglesAhead ahead = settled(meshes);
    std::optional<std::uint32_t> known;
    for (std::size_t i = 0; i < meshes.size(); ++i) {
      const DeformableMesh::ConstPtr right = wanted(meshes, i, known);
      ASSERT_EQ(ahead.of(i), right) << "trial " << trial << ", mesh " << i;
      found += right != nullptr;
      if (right || !meshes[i].mesh->triangles.empty()) known = meshes[i].mesh->topology_id;
    }
  }
  EXPECT_GT(found, 1000U);
}

}  // namespace
}  // namespace deformable_contact_monitor
