// Fans in vector lanes are certified where the rule says so, and nowhere else.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>
#include <vector>

#include "core/cpu/fans.h"
#include "core/cpu/lane_triangle.h"
#include "core/predicates/orientation.h"
#include "core/predicates/vertex_fan.h"
#include "hard_orientations.h"

namespace deformable_contact_monitor {
namespace {

// A fan in the form that isFanCertified() takes.
struct Ring {
  const VertexFans& fans;
  const std::vector<Vec3f>& vertices;
  std::uint32_t v;

  std::uint32_t size() const { return fans.begin[v + 1] - fans.begin[v]; }
  Vec3f ring(std::uint32_t k) const { return vertices[fans.ring[fans.begin[v] + k]]; }
  bool closed() const { return fans.ring[fans.begin[v]] == fans.ring[fans.begin[v + 1] - 1]; }
};

// Fans of all sizes, apart: each a centre and its ring, most about flat, some folded or wound
// twice.
TriangleMesh randomFans(std::mt19937& random, int count, float size) {
  TriangleMesh mesh;
  const auto within = [&random](int low, int high) {
    return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
  };
  for (int i = 0; i < count; ++i) {
    const int triangles = random() % 16 == 0 ? within(30, 34) : within(1, 9);
    const bool closed = triangles > 2 && random() % 2 == 0;
    const int points = closed ? triangles : triangles + 1;
    const double turn = 2 * M_PI * (random() % 8 == 0 ? 2 : 1) / triangles;
    const auto first = static_cast<std::uint32_t>(mesh.vertexCount());
    mesh.vertices.insert(mesh.vertices.end(), 3, 0.0F);
    for (int k = 0; k < points; ++k) {
      for (const double x : {std::cos(k * turn), std::sin(k * turn), 0.0}) {
        mesh.vertices.push_back(size * static_cast<float>(x + 1e-4 * within(-2500, 2500)));
      }
    }
    for (int k = 0; k < triangles; ++k) {
      const auto next = static_cast<std::uint32_t>((k + 1) % points);
      mesh.triangles.insert(mesh.triangles.end(),
                            {first, first + 1 + static_cast<std::uint32_t>(k), first + 1 + next});
    }
  }
  return mesh;
}

std::vector<Vec3f> placesOf(const TriangleMesh& mesh) {
  std::vector<Vec3f> places;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    places.push_back({mesh.vertices[i], mesh.vertices[i + 1], mesh.vertices[i + 2]});
  }
  return places;
}

TEST(LaneFan, CertifiesWhatTheRuleCertifies) {
  std::mt19937 random(1);
  int certified = 0, others = 0;
  for (const float size : {1.0F, 1e-3F, 1e-19F, 1e-38F, 1e-44F, 1e12F, 1e19F, 1e38F, INFINITY}) {
    const TriangleMesh mesh = randomFans(random, 2000, size);
    const std::vector<Vec3f> vertices = placesOf(mesh);
    const VertexFans fans = vertexFans(mesh);
    const std::vector<std::uint32_t> fours = foursAlike(fans);
    ASSERT_EQ(0U, fours.size() % 4);
    std::set<std::uint32_t> seen;
    for (std::size_t i = 0; i < fours.size(); i += 4) {
      const int crossings = laneBits(areFansCertified(fans, &fours[i], vertices.data()));
      for (std::size_t k = 0; k < 4; ++k) {
        const std::uint32_t v = fours[i + k];
        const bool expected = isFanCertified(vertices[v], Ring{fans, vertices, v});
        ASSERT_EQ(expected, (crossings >> k & 1) != 0) << "vertex " << v << ", size " << size;
        if (!seen.insert(v).second) continue;
        (expected ? certified : others) += 1;
      }
    }
    for (std::uint32_t v = 0; v < vertices.size(); ++v) {  // none is missing
      EXPECT_TRUE(seen.count(v) > 0 || !isFanCertified(vertices[v], Ring{fans, vertices, v})) << v;
    }
  }
  EXPECT_GT(certified, 2000);
  EXPECT_GT(others, 2000);
}

// So far off that no bound may be a fifth as large.
TEST(LaneFan, TellsNoTurnThatRoundingMade) {
  const std::vector<HardOrientation> hard = hardOrientations(4, 200, FirstPoint::kAtOrigin);
  EXPECT_GT(worstOf(hard), 1.5);
  const auto lanes = [](const Vec3f& v) {
    return LanePoint{{v.x, v.x, v.x, v.x}, {v.y, v.y, v.y, v.y}, {v.z, v.z, v.z, v.z}};
  };
  for (const HardOrientation& points : hard) {
    const Vec3f &u = points.p[1], &w = points.p[2], &normal = points.p[3];
    const int expected = orient3dExact({0, 0, 0}, u, w, normal);
    const int turn = detail::EdgeProduct(u, w).turn(normal);
    EXPECT_TRUE(turn == 0 || turn == expected) << points.off_by;
    const LaneSigns signs = LaneProduct(lanes(u), lanes(w)).signWith(lanes(normal));
    EXPECT_EQ(turn == 1 ? 15 : 0, laneBits(signs.positive));
    EXPECT_EQ(turn == -1 ? 15 : 0, laneBits(signs.negative));
  }
}

TEST(LaneFan, OfNoTrianglesThereIsNone) {
  TriangleMesh mesh;
  mesh.vertices.assign(30, 1);
  EXPECT_TRUE(foursAlike(vertexFans(mesh)).empty());
}

}  // namespace
}  // namespace deformable_contact_monitor
