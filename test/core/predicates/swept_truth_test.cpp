// Published verdicts on features between two frames, and the swept contacts of real cloth.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh_file.h"
#include "core/predicates/swept_exact.h"
#include "core/predicates/swept_roots.h"
#include "moving_features.h"
#include "moving_meshes.h"
#include "swept/swept_oracle.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

// Counts of what decides.
struct Tally {
  int halving = 0, exact = 0, roots = 0;
};

// By the filters, halving, and what they leave by integers.
bool meets(const Feature& feature, Tally* tally) {
  if (areApart(feature)) return false;
  if (meetsAtStart(feature)) return true;
  const FeatureVerdict verdict = halvedVerdict(feature, coplanarity<double>(feature), false, 1.0F);
  if (verdict.part != PartVerdict::kOpen) {
    ++tally->halving;
    return verdict.part == PartVerdict::kMeet;
  }
  ++tally->exact;
  return exactFeatureTime(feature, false).happens();
}

// Compares what the only root of the cubic says with the truth, if there is one: in the whole
// interval of time, and in its part in which the feature meets or that follows.
template <class Real>
void expectByRoot(const Feature& feature, bool expected, Tally* tally) {
  const Cubic<Real> d = coplanarity<Real>(feature);
  if (d.sign() != 0) return;
  const FeatureVerdict verdict = detail::verdictByRoot(feature, d, detail::HalvedInterval{});
  if (verdict.part == PartVerdict::kOpen) return;
  ++tally->roots;
  ASSERT_EQ(verdict.part == PartVerdict::kMeet, expected);
  if (!expected) return;
  const FirstTime exact = exactFeatureTime(feature, true);
  EXPECT_LE(verdict.low, exact.high);
  EXPECT_LE(exact.low, verdict.high);
  constexpr int kLevel = 5;
  const auto path = static_cast<std::uint32_t>(verdict.low * (1 << kLevel));
  const FeatureVerdict part = detail::verdictByRoot(feature, d, {kLevel, path, 0});
  if (part.part == PartVerdict::kMeet) {
    EXPECT_EQ(part.low, verdict.low);
    EXPECT_EQ(part.high, verdict.high);
  }
  EXPECT_NE(part.part, PartVerdict::kApart);
  EXPECT_NE(detail::verdictByRoot(feature, d, {kLevel, path ^ 1, 0}).part, PartVerdict::kMeet);
}

nlohmann::json readJson(const std::string& name) {
  std::ifstream file(testDataFile(name));
  return nlohmann::json::parse(file);
}

// Edges (i < j) sorted by j, then i: as the box ids count them.
std::vector<std::pair<std::uint32_t, std::uint32_t>> edgesOf(const TriangleMesh& mesh) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;  // j, i
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t p = mesh.triangles[t + k], q = mesh.triangles[t + (k + 1) % 3];
      edges.emplace_back(std::max(p, q), std::min(p, q));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

struct Frames {
  TriangleMesh from, to;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;

  Frames(const std::string& name0, const std::string& name1)
      : from(readMeshFile(testDataFile(name0))),
        to(readMeshFile(testDataFile(name1))),
        edges(edgesOf(from)) {}

  MovingPoint point(std::size_t v) const { return {from.vertex(v), to.vertex(v)}; }
  Feature vertexFace(std::size_t vertex, std::size_t face_box) const {
    const std::size_t t = 3 * (face_box - from.vertexCount() - edges.size());
    return {FeatureKind::kVertexFace,
            {point(from.triangles.at(t)), point(from.triangles.at(t + 1)),
             point(from.triangles.at(t + 2)), point(vertex)}};
  }
  Feature edgeEdge(std::size_t box_a, std::size_t box_b) const {
    const auto &a = edges.at(box_a - from.vertexCount()), &b = edges.at(box_b - from.vertexCount());
    return {FeatureKind::kEdgeEdge,
            {point(a.first), point(a.second), point(b.first), point(b.second)}};
  }
};

void expectListedTruth(const Frames& frames, const std::string& folder, const std::string& step,
                       std::size_t count, Tally* tally) {
  std::size_t seen = 0, positive = 0;
  for (const bool faces : {true, false}) {
    const std::string name = step + (faces ? "vf" : "ee");
    const nlohmann::json boxes = readJson(folder + "/boxes/" + name + ".json");
    const nlohmann::json truth = readJson(folder + "/mma_bool/" + name + "_mma_bool.json");
    ASSERT_EQ(boxes.size(), truth.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const std::size_t a = boxes[i][0], b = boxes[i][1];
      const Feature feature = faces ? frames.vertexFace(a, b) : frames.edgeEdge(a, b);
      const bool expected = truth[i];
      ASSERT_EQ(meets(feature, tally), expected) << name << " " << i;
      if (i % 16 == 1 && !meetsAtStart(feature)) {
        SCOPED_TRACE(name + " " + std::to_string(i));
        ASSERT_NO_FATAL_FAILURE(expectByRoot<double>(feature, expected, tally));
        ASSERT_NO_FATAL_FAILURE(expectByRoot<float>(feature, expected, tally));
      }
      ++seen;
      positive += expected ? 1 : 0;
      if (i % 16 == 0) {
        ASSERT_EQ(meetsExactly(feature), expected) << name << " " << i;
      }
    }
  }
  EXPECT_EQ(seen, count);
  EXPECT_GT(positive, count / 20);
}

TEST(SweptTruth, ListedPairsOfClothFunnel) {
  DCM_REQUIRE_TEST_DATA();
  Tally tally;
  expectListedTruth(Frames("cloth-funnel/227.ply", "cloth-funnel/228.ply"), "cloth-funnel", "227",
                    355, &tally);
  EXPECT_GT(tally.halving, 0);
}

TEST(SweptTruth, ListedPairsOfClothBall) {
  DCM_REQUIRE_TEST_DATA();
  Tally tally;
  expectListedTruth(Frames("cloth-ball/cloth_ball92.ply", "cloth-ball/cloth_ball93.ply"),
                    "cloth-ball", "92", 113859, &tally);
  EXPECT_GT(tally.halving, 0);
  EXPECT_GT(tally.roots, 100);
}

// Eight lines a query: the four points in state 0, then in state 1; a coordinate is two integers,
// numerator and denominator. Vertex-face: the vertex first.
std::vector<Feature> readQueries(const std::string& name, FeatureKind kind) {
  std::ifstream file(testDataFile(name));
  std::vector<Vec3f> points;
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream text(line);
    double n[6];
    for (double& x : n) text >> x;
    EXPECT_TRUE(text) << line;
    points.push_back({static_cast<float>(n[0] / n[1]), static_cast<float>(n[2] / n[3]),
                      static_cast<float>(n[4] / n[5])});
    for (int k = 0; k < 3; ++k) EXPECT_EQ(points.back()[k], n[2 * k] / n[2 * k + 1]) << line;
  }
  std::vector<Feature> features;
  for (std::size_t i = 0; i + 7 < points.size(); i += 8) {
    Feature feature;
    feature.kind = kind;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t place = kind == FeatureKind::kVertexFace ? (k + 3) % 4 : k;
      feature.x[place] = {points[i + k], points[i + 4 + k]};
    }
    features.push_back(feature);
  }
  return features;
}

TEST(SweptTruth, QueriesOfClothFunnel) {
  DCM_REQUIRE_TEST_DATA();
  Tally tally;
  for (const bool faces : {true, false}) {
    const std::string name = faces ? "227vf" : "227ee";
    const std::vector<Feature> features =
        readQueries("cloth-funnel/queries/" + name + ".csv",
                    faces ? FeatureKind::kVertexFace : FeatureKind::kEdgeEdge);
    const nlohmann::json truth = readJson("cloth-funnel/mma_bool/" + name + "_mma_bool.json");
    ASSERT_EQ(features.size(), truth.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
      const bool expected = truth[i];
      EXPECT_EQ(meets(features[i], &tally), expected) << name << " " << i;
      EXPECT_EQ(meetsExactly(features[i]), expected) << name << " " << i;
    }
  }
}

// Contacts of a mesh with itself, among the pairs with overlapping swept boxes.
struct Contacts {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> skip, beyond_shared;
  std::size_t boxes = 0;
};

Contacts contactsOf(const std::vector<MovingTriangle>& triangles) {
  Contacts contacts;
  PredicateState state;
  for (const auto& pair : sweptBoxPairs(triangles)) {
    const MovingTriangle &a = triangles[pair.first], &b = triangles[pair.second];
    const SharedVertices shared = sharedTrajectories(a, b);
    contacts.boxes += shared.any ? 0 : 1;
    const SweptVerdict verdict =
        sweptVerdict(a, b, shared, AdjacentPairs::kBeyondShared, false, state);
    if (verdict.part != PartVerdict::kMeet) continue;
    contacts.beyond_shared.push_back(pair);
    if (!shared.any) contacts.skip.push_back(pair);
  }
  return contacts;
}

TEST(SweptTruth, ClothFunnelWithItself) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh from = readMeshFile(testDataFile("cloth-funnel/227.ply"));
  const TriangleMesh to = readMeshFile(testDataFile("cloth-funnel/228.ply"));
  const std::vector<MovingTriangle> triangles = movingTriangles(from, to);
  const Contacts contacts = contactsOf(triangles);
  EXPECT_EQ(contacts.boxes, 43942U);
  EXPECT_EQ(contacts.skip.size(), 381U);
  EXPECT_EQ(contacts.beyond_shared.size(), 510U);
  // The oracle on all contacts, and on some of the others.
  std::size_t others = 0;
  for (const auto& pair : sweptBoxPairs(triangles)) {
    const bool found =
        std::binary_search(contacts.beyond_shared.begin(), contacts.beyond_shared.end(), pair);
    if (!found && ++others % 150 != 0) continue;
    const MovingTriangle &a = triangles[pair.first], &b = triangles[pair.second];
    ASSERT_EQ(sweptContact(a.from, a.to, b.from, b.to, AdjacentPairs::kBeyondShared), found)
        << pair.first << " " << pair.second;
  }
  // Zero motion is the static result.
  EXPECT_EQ(contactsOf(movingTriangles(from, from)).skip.size(), 261U);
  EXPECT_EQ(contactsOf(movingTriangles(from, from)).beyond_shared.size(), 309U);
  EXPECT_EQ(contactsOf(movingTriangles(to, to)).beyond_shared.size(), 382U);
  // Backwards in time, the same.
  EXPECT_EQ(contactsOf(movingTriangles(to, from)).beyond_shared, contacts.beyond_shared);
}

// The oracle on all contacts of triangles that share vertices, and on some of the others.
TEST(SweptTruth, NeighboursOfClothBall) {
  DCM_REQUIRE_TEST_DATA();
  const std::vector<MovingTriangle> triangles =
      movingTriangles(readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply")),
                      readMeshFile(testDataFile("cloth-ball/cloth_ball93.ply")));
  std::size_t neighbours = 0, contacts = 0;
  for (const auto& [i, j] : sweptBoxPairs(triangles)) {
    const MovingTriangle &a = triangles[i], &b = triangles[j];
    const SharedVertices shared = sharedTrajectories(a, b);
    if (!shared.any) continue;
    ++neighbours;
    PredicateState state;
    const bool found =
        sweptVerdict(a, b, shared, AdjacentPairs::kBeyondShared, false, state).part ==
        PartVerdict::kMeet;
    contacts += found ? 1 : 0;
    if (!found && neighbours % 50 != 0) continue;
    ASSERT_EQ(sweptContact(a.from, a.to, b.from, b.to, AdjacentPairs::kBeyondShared), found)
        << i << " " << j;
  }
  EXPECT_EQ(neighbours, 563793U);
  EXPECT_EQ(contacts, 9022U);
}

}  // namespace
}  // namespace deformable_contact_monitor
