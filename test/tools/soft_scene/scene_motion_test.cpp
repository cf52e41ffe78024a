// Tests of what soft_scene moves: joints, links, mesh files.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "robot/urdf_document.h"
#include "tools/simulation/scene_object.h"
#include "tools/soft_scene/joint_mover.h"

namespace deformable_contact_monitor {
namespace {

// An upright cylinder on a post, turned about y, with a slide and its mimic.
const char* const kUrdf = R"(<robot name="r">
  <link name="base"/>
  <link name="arm"><collision><origin xyz="0 0 0.5"/>
    <geometry><cylinder radius="0.05" length="1"/></geometry></collision></link>
  <link name="slide"/><link name="follower"/><link name="wheel"/>
  <joint name="lift" type="revolute"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 2"/><axis xyz="0 1 0"/>
    <limit lower="-0.2" upper="1" velocity="1" effort="1"/></joint>
  <joint name="push" type="prismatic"><parent link="arm"/><child link="slide"/>
    <axis xyz="1 0 0"/><limit lower="0" upper="0.04" velocity="0.01" effort="1"/></joint>
  <joint name="echo" type="prismatic"><parent link="arm"/><child link="follower"/>
    <axis xyz="1 0 0"/><mimic joint="push" multiplier="2"/>
    <limit lower="0" upper="0.08" velocity="1" effort="1"/></joint>
  <joint name="roll" type="continuous"><parent link="arm"/><child link="wheel"/>
    <axis xyz="0 0 1"/></joint></robot>)";

TEST(JointMoverTest, staysWithinTheLimitsAndMovesSmoothly) {
  const std::vector<RobotJoint> joints = readUrdf(kUrdf, GeometryKind::kCollision).joints;
  const JointMover mover(joints, 1);
  EXPECT_EQ(mover.names(), (std::vector<std::string>{"lift", "push", "roll"}));
  std::vector<double> last = mover.positions(0);
  double travelled = 0;
  for (int i = 1; i < 6000; ++i) {
    const std::vector<double> now = mover.positions(i * 0.01);
    EXPECT_GT(now[0], -0.2);
    EXPECT_LT(now[0], 1);
    EXPECT_GT(now[1], 0);
    EXPECT_LT(now[1], 0.04);
    EXPECT_LT(std::abs(now[0] - last[0]), 0.01 * 0.51);
    EXPECT_LT(std::abs(now[1] - last[1]), 0.01 * 0.0051);
    travelled += std::abs(now[0] - last[0]);
    last = now;
  }
  EXPECT_GT(travelled, 1);
  EXPECT_EQ(JointMover(joints, 1).positions(3), mover.positions(3));
  EXPECT_NE(JointMover(joints, 2).positions(3), mover.positions(3));
}

TEST(MeshPlayerTest, scalesShiftsAndTellsTopologiesApart) {
  const std::string base = ::testing::TempDir() + "dcm_mesh_player_";
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(base + name) << text;
    return base + name;
  };
  const std::string a = write("a.obj", "v 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
  const std::string b = write("b.obj", "v 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\n");
  const std::string c = write("c.obj", "v 2 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\n");
  std::size_t read = 0;
  const auto frames =
      readMeshFrames({a, b, c}, 0.5, {10, 20, 30}, [&](std::size_t n) { read = n; });
  EXPECT_EQ(read, 3U);
  ASSERT_EQ(frames.size(), 3U);
  EXPECT_EQ(frames[1].mesh.vertices,
            (std::vector<float>{11, 20, 30, 10, 20.5F, 30, 10, 20, 30.5F}));
  EXPECT_EQ(frames[0].topology_id, frames[1].topology_id);
  EXPECT_NE(frames[1].topology_id, frames[2].topology_id);
  EXPECT_THROW(readMeshFrames({a, base + "none.obj"}, 1, {0, 0, 0}, [](std::size_t) {}),
               std::runtime_error);
}

}  // namespace
}  // namespace deformable_contact_monitor
