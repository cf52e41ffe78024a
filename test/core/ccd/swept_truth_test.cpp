// The oracle of swept contacts on real steps: published verdicts of vertex-face and edge-edge
// queries, and pairs that are known.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "pair_sets.h"
#include "scenes.h"
#include "swept/swept_oracle.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

using Query = std::array<Trajectory, 4>;
using Meets = bool (*)(const Query&);

std::vector<bool> verdicts(const std::string& file) {
  std::ifstream in(testDataFile(file));
  return nlohmann::json::parse(in).get<std::vector<bool>>();
}

// Lines of x, y, z as numerator, denominator: four points in state 0, then in state 1.
std::vector<Query> queries(const std::string& file) {
  std::ifstream in(testDataFile(file));
  std::vector<Query> out;
  std::string line;
  for (std::size_t i = 0; std::getline(in, line); ++i) {
    std::istringstream fields(line);
    if (i % 8 == 0) out.emplace_back();
    Trajectory& point = out.back()[i % 4];
    for (mpq_class& x : i % 8 < 4 ? point.start : point.end) {
      std::string numerator, denominator;
      if (!std::getline(fields, numerator, ',') || !std::getline(fields, denominator, ',')) {
        throw std::runtime_error(file + ": " + line);
      }
      x = mpq_class(mpz_class(numerator), mpz_class(denominator));
      x.canonicalize();
    }
  }
  return out;
}

// Verdicts that differ from the published ones; which ones is said.
int disagreements(const std::vector<Query>& asked, const std::vector<bool>& published,
                  Meets meets) {
  EXPECT_EQ(asked.size(), published.size());
  int count = 0;
  for (std::size_t i = 0; i < std::min(asked.size(), published.size()); ++i) {
    if (meets(asked[i]) == published[i]) continue;
    ++count;
    ADD_FAILURE() << "query " << i << " is published as " << published[i];
  }
  return count;
}

Triangle toTriangle(const RationalPoint& a, const RationalPoint& b, const RationalPoint& c) {
  Triangle out;
  const RationalPoint* corners[] = {&a, &b, &c};
  for (int i = 0; i < 3; ++i) {
    float x[3];
    for (int axis = 0; axis < 3; ++axis) {
      x[axis] = static_cast<float>((*corners[i])[axis].get_d());
      if (mpq_class(double{x[axis]}) != (*corners[i])[axis]) throw std::range_error("no float");
    }
    out.v[i] = {x[0], x[1], x[2]};
  }
  return out;
}

// Decides a query as two triangles: a vertex becomes a triangle with three equal corners, an edge
// one with two.
bool meetAsTriangles(const Query& q, bool vertex_face) {
  const auto a = [&](const RationalPoint Trajectory::*state) {
    return toTriangle(q[0].*state, q[vertex_face ? 0 : 1].*state, q[0].*state);
  };
  const auto b = [&](const RationalPoint Trajectory::*state) {
    return toTriangle(q[vertex_face ? 1 : 2].*state, q[2].*state, q[3].*state);
  };
  return sweptContact(a(&Trajectory::start), a(&Trajectory::end), b(&Trajectory::start),
                      b(&Trajectory::end));
}

TEST(SweptTruth, FunnelAsPublished) {
  DCM_REQUIRE_TEST_DATA();
  const std::string folder = "cloth-funnel/";
  const std::vector<bool> vf = verdicts(folder + "mma_bool/227vf_mma_bool.json");
  const std::vector<bool> ee = verdicts(folder + "mma_bool/227ee_mma_bool.json");
  const std::vector<Query> asked_vf = queries(folder + "queries/227vf.csv");
  const std::vector<Query> asked_ee = queries(folder + "queries/227ee.csv");
  ASSERT_EQ(355U, asked_vf.size() + asked_ee.size());
  disagreements(asked_vf, vf, vertexFaceMeets);
  disagreements(asked_ee, ee, edgeEdgeMeets);
  disagreements(asked_vf, vf, [](const Query& q) { return meetAsTriangles(q, true); });
  disagreements(asked_ee, ee, [](const Query& q) { return meetAsTriangles(q, false); });
}

// One mesh in two states, whose vertices, edges and faces have ids in this order.
class BoxIds {
 public:
  BoxIds(const TriangleMesh& state0, const TriangleMesh& state1) : states_{&state0, &state1} {
    const std::vector<std::uint32_t>& corners = state0.triangles;
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;  // the greater end first
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const std::uint32_t p = corners[i], q = corners[i % 3 == 2 ? i - 2 : i + 1];
      edges.emplace(std::max(p, q), std::min(p, q));
    }
    edges_.assign(edges.begin(), edges.end());
  }

  Query edgeEdge(std::size_t a, std::size_t b) const {
    const auto& [q, p] = edges_.at(a - states_[0]->vertexCount());
    const auto& [s, r] = edges_.at(b - states_[0]->vertexCount());
    return {vertex(p), vertex(q), vertex(r), vertex(s)};
  }
  Query vertexFace(std::size_t v, std::size_t face) const {
    const std::size_t first = 3 * (face - states_[0]->vertexCount() - edges_.size());
    const std::vector<std::uint32_t>& corners = states_[0]->triangles;
    return {vertex(v), vertex(corners.at(first)), vertex(corners.at(first + 1)),
            vertex(corners.at(first + 2))};
  }

 private:
  Trajectory vertex(std::size_t i) const {
    const auto in = [i](const TriangleMesh& mesh) {
      const Vec3f v = mesh.vertex(i);
      return RationalPoint{mpq_class(double{v.x}), mpq_class(double{v.y}), mpq_class(double{v.z})};
    };
    return {in(*states_[0]), in(*states_[1])};
  }

  const TriangleMesh* states_[2];
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges_;
};

// All of a list, or each `stride`-th.
void checkListed(const BoxIds& ids, const std::string& scene, const std::string& step,
                 bool vertex_face, std::size_t stride) {
  const std::string name = step + (vertex_face ? "vf" : "ee");
  std::ifstream in(testDataFile(scene + "/boxes/" + name + ".json"));
  const nlohmann::json boxes = nlohmann::json::parse(in);
  const std::vector<bool> all = verdicts(scene + "/mma_bool/" + name + "_mma_bool.json");
  ASSERT_EQ(boxes.size(), all.size());
  std::vector<Query> asked;
  std::vector<bool> published;
  for (std::size_t i = 0; i < all.size(); i += stride) {
    const std::size_t a = boxes[i][0], b = boxes[i][1];
    asked.push_back(vertex_face ? ids.vertexFace(a, b) : ids.edgeEdge(a, b));
    published.push_back(all[i]);
  }
  disagreements(asked, published, vertex_face ? vertexFaceMeets : edgeEdgeMeets);
}

TEST(SweptTruth, FunnelAsListed) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh state0 = readMeshFile(testDataFile("cloth-funnel/227.ply"));
  const TriangleMesh state1 = readMeshFile(testDataFile("cloth-funnel/228.ply"));
  const BoxIds ids(state0, state1);
  for (const bool vertex_face : {false, true})
    checkListed(ids, "cloth-funnel", "227", vertex_face, 1);
}

// All 113 859, where $DCM_SWEPT_ALL is set; else a part of them.
TEST(SweptTruth, ClothOnBallAsListed) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh state0 = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  const TriangleMesh state1 = readMeshFile(testDataFile("cloth-ball/cloth_ball93.ply"));
  const BoxIds ids(state0, state1);
  const std::size_t stride = std::getenv("DCM_SWEPT_ALL") != nullptr ? 1 : 16;
  for (const bool vertex_face : {false, true}) {
    checkListed(ids, "cloth-ball", "92", vertex_face, stride);
  }
}

// Both ways are known from an integer reference with another method.
TEST(SweptTruth, FunnelSelfContacts) {
  DCM_REQUIRE_TEST_DATA();
  const TriangleMesh state0 = readMeshFile(testDataFile("cloth-funnel/227.ply"));
  const TriangleMesh state1 = readMeshFile(testDataFile("cloth-funnel/228.ply"));
  for (const AdjacentPairs adjacent : {AdjacentPairs::kSkip, AdjacentPairs::kBeyondShared}) {
    const bool skip = adjacent == AdjacentPairs::kSkip;
    const std::vector<TrianglePair> swept =
        oracleSweptContacts(selfScene(state0), selfScene(state1), adjacent);
    EXPECT_TRUE(isOrdered(swept));
    EXPECT_EQ(skip ? 381U : 510U, swept.size());
    for (const TriangleMesh* state : {&state0, &state1}) {
      const std::vector<TrianglePair> still = oracleContacts(selfScene(*state), adjacent);
      EXPECT_TRUE(std::includes(swept.begin(), swept.end(), still.begin(), still.end()));
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
