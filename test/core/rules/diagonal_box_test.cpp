// Intervals along the axes and diagonals of space, rounded to 15 bits, against the contacts that
// brute force finds.
#include "core/rules/diagonal_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/detector.h"
#include "core/predicates/aabb.h"
#include "core/rules/axis_box.h"
#include "reference/reference_detectors.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

Triangle triangleOf(const TriangleMesh& mesh, std::uint32_t t) {
  Triangle triangle;
  for (int k = 0; k < 3; ++k) {
    const float* v = &mesh.vertices[3 * std::size_t{mesh.triangles[3 * t + k]}];
    triangle.v[k] = {v[0], v[1], v[2]};
  }
  return triangle;
}

// A soup of thin triangles whose edges are about `size_m`, within `reach_m` of `middle` along each
// axis.
TriangleMesh soup(std::mt19937& random, std::uint32_t count, double size_m, double reach_m,
                  const Vec3d& middle) {
  std::uniform_real_distribution<double> either(-1, 1);
  TriangleMesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    const double at[3] = {middle.x + reach_m * either(random), middle.y + reach_m * either(random),
                          middle.z + reach_m * either(random)};
    for (std::uint32_t k = 0; k < 3; ++k) {
      for (const double x : at) {
        mesh.vertices.push_back(static_cast<float>(x + size_m * either(random)));
      }
      mesh.triangles.push_back(3 * t + k);
    }
  }
  return mesh;
}

SceneScale scaleOf(double reach, const Vec3d& origin) {
  SceneScale scale;
  scale.scale = 1 / reach;
  scale.origin = origin;
  return scale;
}

// Scales that fit the scene, and scales that do not.
std::vector<SceneScale> scalesFor(double reach_m, const Vec3d& middle) {
  return {scaleOf(reach_m, middle),
          scaleOf(reach_m / 100, middle),
          scaleOf(reach_m * 1e6, middle),
          scaleOf(reach_m, middle + Vec3d{reach_m, -reach_m, 0}),
          scaleOf(0, middle),
          scaleOf(1e-44, {1e-44, 0, 0}),
          scaleOf(1e40, {1e38, -1e38, 1e38}),
          SceneScale()};
}

// Frames for these scales, and a frame for nothing.
template <class Frame>
std::vector<Frame> framesFor(double reach_m, const Vec3d& middle) {
  std::vector<Frame> frames;
  for (const SceneScale& scale : scalesFor(reach_m, middle)) frames.emplace_back(scale);
  frames.emplace_back();
  return frames;
}

// Returns whether the rounded boxes of two triangles meet, of which the second is grown by a
// margin.
bool boxesMeet(const Triangle& a, const Triangle& b, float margin_m, const AxisFrame& frame) {
  const AxisBox box_a(boxOf(a), frame), box_b(inflated(boxOf(b), margin_m), frame);
  const bool meet = intersects(TurnedAxisBox(box_a), box_b);
  EXPECT_EQ(meet, intersects(TurnedAxisBox(box_b), box_a));
  return meet;
}

struct Extreme {
  const char* name;
  double size_m, reach_m, offset_m, margin_m;
};

class DiagonalBoxesOf : public ::testing::TestWithParam<Extreme> {};

TEST_P(DiagonalBoxesOf, ContactsMeet) {
  const Extreme& it = GetParam();
  std::mt19937 random(7);
  std::size_t contacts = 0;
  for (int turn = 0; turn < 20; ++turn) {
    const Vec3d middle{it.offset_m, -it.offset_m, it.offset_m / 3};
    const TriangleMesh a = soup(random, 100, it.size_m, it.reach_m, middle);
    const TriangleMesh b = soup(random, 100, it.size_m, it.reach_m, middle);
    Scene scene = pairScene(a, b);
    const auto margin_m = static_cast<float>(it.margin_m);
    scene.setMargin(1, margin_m);
    const DetectionResult result = makeBruteForceDetector()->detect(scene, Options());
    const auto frames = framesFor<DiagonalFrame>(it.reach_m, middle);
    const auto axis_frames = framesFor<AxisFrame>(it.reach_m, middle);
    for (const TrianglePair& pair : result.contacts) {
      const Triangle of_a = triangleOf(a, pair.triangle_a), of_b = triangleOf(b, pair.triangle_b);
      for (const DiagonalFrame& frame : frames) {
        ASSERT_TRUE(
            intersects(diagonalBox<3>(of_a.v, 0, frame), diagonalBox<3>(of_b.v, margin_m, frame)));
      }
      for (const AxisFrame& frame : axis_frames) {
        ASSERT_TRUE(boxesMeet(of_a, of_b, margin_m, frame));
      }
    }
    contacts += result.contacts.size();
  }
  EXPECT_GT(contacts, 200U);
}

INSTANTIATE_TEST_SUITE_P(, DiagonalBoxesOf,
                         ::testing::Values(Extreme{"usual", 0.1, 0.3, 0, 0},
                                           Extreme{"far_away", 0.1, 0.3, 1e5, 0},
                                           Extreme{"tiny", 1e-40, 3e-40, 0, 0},
                                           Extreme{"huge", 1e36, 3e36, 0, 0},
                                           Extreme{"beyond_floats", 1e38, 2e38, 0, 0},
                                           Extreme{"margin", 0.02, 0.3, 0, 0.05},
                                           Extreme{"far_margin", 0.02, 0.3, 1e4, 0.05},
                                           Extreme{"huge_margin", 0.02, 0.3, 0, FLT_MAX}),
                         [](const auto& info) { return info.param.name; });

// A vertex of one triangle is the middle of another one's edge, which is square to the diagonal. So
// the triangles only touch, and the rounded positions of the three points differ.
TEST(DiagonalBox, HoldsAPointWhosePositionIsRounded) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> place(1, 2);
  int rounded_apart = 0;
  for (int turn = 0; turn < 10000; ++turn) {
    const Vec3f p{place(random), place(random), place(random)};
    const float step = std::ldexp(1.0F, -static_cast<int>(random() % 20) - 3);
    const Vec3f along{step, 0, -step}, above{0.25F, 0.25F, 0.25F};
    const Triangle of_a{{p - along, p + along, p - above}}, of_b{{p, p + above, p + above + along}};
    // The vertex is the middle of the edge where no coordinate was rounded.
    if (!(of_a.v[0] + along == p && of_a.v[1] - along == p)) continue;
    const auto sum = [](const Vec3f& v) { return v.x + v.y + v.z; };
    if (sum(p) > most(sum(of_a.v[0]), sum(of_a.v[1]))) ++rounded_apart;
    const Vec3d middle{p.x, p.y, p.z};
    for (const double reach : {1e-6, 1e-3, 1.0}) {
      const DiagonalFrame frame = framesFor<DiagonalFrame>(reach, middle).front();
      ASSERT_TRUE(intersects(diagonalBox<3>(of_a.v, 0, frame), diagonalBox<3>(of_b.v, 0, frame)));
    }
  }
  EXPECT_GT(rounded_apart, 10);
}

// Pairs whose boxes meet, but that have no contact.
TEST(DiagonalBox, TellManyTrianglesApart) {
  std::mt19937 random(3);
  const TriangleMesh mesh = soup(random, 400, 0.1, 0.3, {});
  const DiagonalFrame frame = framesFor<DiagonalFrame>(1, {}).front();
  int boxes = 0, apart = 0;
  for (std::uint32_t a = 0; a < 400; ++a) {
    for (std::uint32_t b = 0; b < a; ++b) {
      const Triangle of_a = triangleOf(mesh, a), of_b = triangleOf(mesh, b);
      if (!intersects(boxOf(of_a), boxOf(of_b))) continue;
      ++boxes;
      if (!intersects(diagonalBox<3>(of_a.v, 0, frame), diagonalBox<3>(of_b.v, 0, frame))) ++apart;
    }
  }
  EXPECT_GT(boxes, 1000);
  EXPECT_GT(apart, boxes / 4);
}

// Boxes that are apart by more than a step of the frame, and boxes of nothing.
TEST(AxisBox, TellsTrianglesApart) {
  std::mt19937 random(3);
  const TriangleMesh mesh = soup(random, 300, 0.1, 0.9, {});
  const AxisFrame frame(scaleOf(1, {}));
  constexpr float kStep = 2.0F / 32767;
  int apart = 0;
  for (std::uint32_t a = 0; a < 300; ++a) {
    const Triangle of_a = triangleOf(mesh, a);
    EXPECT_FALSE(intersects(TurnedAxisBox(AxisBox(boxOf(of_a), frame)), AxisBox()));
    EXPECT_FALSE(intersects(TurnedAxisBox(AxisBox()), AxisBox(boxOf(of_a), frame)));
    for (std::uint32_t b = 0; b < a; ++b) {
      const Triangle of_b = triangleOf(mesh, b);
      if (intersects(inflated(boxOf(of_a), 1.01F * kStep), boxOf(of_b))) continue;
      ++apart;
      ASSERT_FALSE(boxesMeet(of_a, of_b, 0, frame));
    }
  }
  EXPECT_GT(apart, 10000);
}

// A moving triangle lies in the hull of its vertices at both ends of the time interval.
TEST(DiagonalBox, HoldAllPlacesOfAMovingTriangle) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> part(0, 1);
  const DiagonalFrame frame = framesFor<DiagonalFrame>(1, {}).front();
  for (int turn = 0; turn < 1000; ++turn) {
    const TriangleMesh mesh = soup(random, 2, 0.1, 0.3, {});
    const Triangle from = triangleOf(mesh, 0), to = triangleOf(mesh, 1);
    const Vec3f v[6] = {from.v[0], from.v[1], from.v[2], to.v[0], to.v[1], to.v[2]};
    const float t = part(random);
    Vec3f between[3];
    for (int k = 0; k < 3; ++k) between[k] = from.v[k] * (1 - t) + to.v[k] * t;
    const DiagonalBox moving = diagonalBox<6>(v, 0, frame);
    for (const Vec3f& p : between) {
      const Vec3f point[3] = {p, p, p};
      ASSERT_TRUE(intersects(moving, diagonalBox<3>(point, 0, frame)));
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
