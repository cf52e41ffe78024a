// Tests where rigid objects are, and how a link takes hold of one.
#include "monitor/cycle/rigid_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "loop_fixture.h"
#include "refusal.h"

namespace deformable_contact_monitor {
namespace {

RigidTransform turned(double angle, double x, double y, double z) {
  geometry_msgs::Transform t;
  t.translation.x = x;
  t.translation.y = y;
  t.translation.z = z;
  t.rotation.x = 0.6 * std::sin(angle / 2);
  t.rotation.z = 0.8 * std::sin(angle / 2);
  t.rotation.w = std::cos(angle / 2);
  return toRigidTransform(t);
}

void expectNear(const RigidTransform& a, const RigidTransform& b) {
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(a.rotation[i], b.rotation[i], 1e-12) << i;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.translation[i], b.translation[i], 1e-12) << i;
}

TEST(RigidPlace, TransformsAreAppliedFromInnerToOuter) {
  const RigidTransform a = turned(1.1, 1, 2, 3), b = turned(-0.4, -5, 0.5, 2),
                       c = turned(2, 0, 1, 0);
  EXPECT_EQ(compose(a, RigidTransform()), a) << "to the bit";
  expectNear(compose(RigidTransform(), a), a);
  expectNear(compose(a, inverse(a)), RigidTransform());
  expectNear(compose(inverse(a), a), RigidTransform());
  expectNear(compose(compose(a, b), c), compose(a, compose(b, c)));
  // Of the point (1, 0, 0): first b, then a.
  const RigidTransform both = compose(a, b);
  for (int row = 0; row < 3; ++row) {
    double expected = a.translation[row];
    for (int k = 0; k < 3; ++k) {
      expected += a.rotation[3 * row + k] * (b.rotation[3 * k] + b.translation[k]);
    }
    EXPECT_NEAR(both.rotation[3 * row] + both.translation[row], expected, 1e-12);
  }
}

class GripTest : public ::testing::Test {
 protected:
  GripTest() {
    parameters_.reference_frame = "base";
    parameters_.frame_prefix = "left/";
    parameters_.max_mesh_age_s = 1;
    parameters_.rigids = {{"tool", "tool_frame"}, {"shelf", "base"}};
  }

  RigidTransform grip(std::size_t rigid, const std::string& link, float radius_m = 0) {
    const TransformLookup lookup(transforms_, "base");
    const auto found =
        findGrip({parameters_.rigids[rigid], link, attached_, radius_m, now_}, parameters_, lookup);
    EXPECT_EQ(found->link, link);
    return found->link_from_object;
  }

  std::string refused(const std::string& link, float radius_m = 0) {
    return refusal([&] { grip(0, link, radius_m); });
  }

  // The pose in the link's frame, where both are rotations about z.
  static void expectRotation(const RigidTransform& transform, double angle) {
    EXPECT_NEAR(transform.rotation[0], std::cos(angle), 1e-12);
    EXPECT_NEAR(transform.rotation[3], std::sin(angle), 1e-12);
  }

  MonitorParameters parameters_;
  AttachedObjects attached_;
  TransformBuffer transforms_{[] { return ros::Time(50); }};
  ros::Time now_{50.5};
};

TEST_F(GripTest, KeepsThePlaceInTheLinkAtTheNewestCommonStamp) {
  addTransform(&transforms_, "left/hand", 50, 0.25);
  addTransform(&transforms_, "left/hand", 50.5, 0.75);
  addTransform(&transforms_, "tool_frame", 50, 1);
  addTransform(&transforms_, "tool_frame", 50.25, 1.5);
  expectRotation(grip(0, "hand"), 1.5 - 0.5);
  expectRotation(grip(1, "hand"), -0.75);
}

TEST_F(GripTest, ALinkMayTakeItFromAnother) {
  for (const double t : {50.0, 50.5}) {
    addTransform(&transforms_, "left/hand", t, 0.25);
    addTransform(&transforms_, "left/finger", t, 2);
  }
  const auto held = std::make_shared<const RigidGrip>(RigidGrip{"hand", {}});
  attached_ = {{"tool", {{"hand"}, nullptr, held}}};
  EXPECT_EQ(placeOf(parameters_.rigids[0], attached_, parameters_), (FramePlace{"left/hand"}));
  EXPECT_EQ(placeOf(parameters_.rigids[1], attached_, parameters_), (FramePlace{"base"}));
  expectRotation(grip(0, "finger"), 0.25 - 2);
}

TEST_F(GripTest, IsRefusedByNameWhereItIsNotKnown) {
  EXPECT_NE(refused("hand").find("hand: "), std::string::npos) << refused("hand");
  addTransform(&transforms_, "left/hand", 50);
  EXPECT_EQ(refused("hand").find("tool: "), 0U) << refused("hand");
  addTransform(&transforms_, "tool_frame", 50);
  EXPECT_EQ(refused("hand"), "");
  for (const float radius_m : {0.5F, -1.0F, std::nanf("")}) {
    EXPECT_EQ(
        refused("hand", radius_m),
        "a radius is not supported for 'tool', which is rigid: hold all of it, with radius 0");
  }
  now_ = ros::Time(52);
  EXPECT_NE(refused("hand").find("are 2.000000 s old"), std::string::npos) << refused("hand");
  now_ = ros::Time();
  EXPECT_EQ(refused("hand"), "") << "nobody knows how old they are";
}

}  // namespace
}  // namespace deformable_contact_monitor
