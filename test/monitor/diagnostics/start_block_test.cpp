// Tests the block of lines that the node shows at its start.
#include "monitor/diagnostics/start_block.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace deformable_contact_monitor {
namespace {

// Two links of half a metre and a metre, and one whose file is missing.
RobotGeometry panda() {
  RobotGeometry robot;
  robot.links = {
      {"hand", "hand.stl", {{0, 0, 0, 0.25F, 0, 0, 0, 0, 0.5F}, {0, 1, 2}}, ""},
      {"arm", "arm.stl", {{0, 0, 0, 1, 0, 0, 0, 0, 0.5F}, {0, 1, 2}}, ""},
      {"foot", "foot.stl", TriangleMesh(), "link 'foot': foot.stl: no such file"},
  };
  robot.robots = {{"panda", {"hand", "arm", "foot", "tip"}, {}}};
  return robot;
}

MonitorParameters parameters() {
  MonitorParameters parameters;
  parameters.reference_frame = "base";
  parameters.margin_m = 0.125F;
  parameters.objects = {{"cloth", "/cloth", 0.125F}};
  parameters.changed = {"reference_frame: base", "margin_m: 0.125", "objects: [...]"};
  return parameters;
}

TEST(StartBlockTest, SaysWhatIsWatchedHowAndWhatIsMissing) {
  RobotGeometry with_srdf = panda();
  with_srdf.robots[0].srdf.disabled = {{"hand", "arm", ""}};
  EXPECT_EQ(
      describeStart(parameters(), {&with_srdf, {"/ns/cloth"}, "cpu", "no GPU", {"TF", "a mesh"}}),
      "looks for contacts in frame 'base':\n"
      "  robot    'panda': 2 links with 2 triangles, the longest is 'arm' with 1 m; 1 link "
      "UNKNOWN without a usable mesh; its SRDF lets 1 pair of links touch\n"
      "  object   'cloth': deformable_contact_monitor/DeformableMesh on /ns/cloth\n"
      "  pairs    robot_deformable\n"
      "  margins  links 0.125 m, objects 0.125 m\n"
      "  backend  CPU, not CUDA: no GPU\n"
      "  set      margin_m: 0.125\n"
      "  missing  TF\n"
      "  missing  a mesh\n"
      "  see      config/docs/console.md#at-the-start");
}

TEST(StartBlockTest, SaysThatNothingIsMissing) {
  const RobotGeometry robot = panda();
  const std::string block = describeStart(parameters(), {&robot, {"/cloth"}, "cuda", "", {}});
  EXPECT_NE(block.find("\n  backend  CUDA\n"), std::string::npos) << block;
  EXPECT_NE(block.find("\n  missing  nothing\n"), std::string::npos) << block;
}

TEST(StartBlockTest, NamesWhatNobodyConfigured) {
  MonitorParameters none;
  none.backend = BackendChoice::kCpu;
  std::string block = describeStart(none, {nullptr, {}, "cpu", "", {}});
  for (const char* line :
       {"\n  robot    not there yet\n", "\n  object   none\n",
        "\n  margins  links 0 m: no distances, only what touches (set margin_m)\n",
        "\n  backend  CPU, as asked for\n"}) {
    EXPECT_NE(block.find(line), std::string::npos) << line << "in:\n" << block;
  }
  none.link_margin_m = {{"hand", 0.5}};
  block = describeStart(none, {nullptr, {}, "cpu", "", {}});
  EXPECT_NE(block.find("\n  margins  links 0 to 0.5 m\n"), std::string::npos) << block;
  none.pair_classes.robot_deformable = false;
  block = describeStart(none, {nullptr, {}, "cpu", "", {}});
  EXPECT_NE(block.find("\n  robot    none is watched\n"), std::string::npos) << block;
}

TEST(StartBlockTest, TellsRangesOfMarginsAndRigidObjects) {
  MonitorParameters some = parameters();
  some.link_margin_m = {{"hand", 0.5}};
  some.objects[0].parts.resize(2);
  some.objects[0].parts[1].margin_m = 2;
  some.rigids = {{"table", "table_top"}};
  const RobotGeometry robot = panda();
  const std::string block = describeStart(some, {&robot, {"/cloth"}, "cuda", "", {}});
  for (const char* line : {"\n  margins  links 0.125 to 0.5 m, objects 0 to 2 m\n",
                           "on /cloth, 2 parts\n", "'table': rigid, in TF frame 'table_top'\n"}) {
    EXPECT_NE(block.find(line), std::string::npos) << line << "in:\n" << block;
  }
}

TEST(StartBlockTest, MissingTransformsAreCountedAndExplained) {
  TransformBuffer buffer;
  const auto connect = [&buffer](const std::string& frame) {
    geometry_msgs::TransformStamped transform;
    transform.header.frame_id = "base";
    transform.header.stamp = ros::Time(5);
    transform.child_frame_id = frame;
    transform.transform.rotation.w = 1;
    buffer.setTransform(transform, "test");
  };
  const RobotGeometry robot = panda();
  using Lines = std::vector<std::string>;
  EXPECT_EQ(missingTransforms(parameters(), &robot, buffer),
            Lines{"TF of 3 of 3 links: TF frame 'base' never seen"});
  connect("hand");
  EXPECT_EQ(missingTransforms(parameters(), &robot, buffer),
            Lines{"TF of 2 of 3 links: TF frame 'arm' never seen"});
  connect("arm");
  connect("foot");
  EXPECT_EQ(missingTransforms(parameters(), &robot, buffer), Lines());
  MonitorParameters with_table = parameters();
  with_table.rigids = {{"table", "table_top"}};
  EXPECT_EQ(missingTransforms(with_table, nullptr, buffer),
            Lines{"TF of 1 of 1 rigid object: TF frame 'table_top' never seen"});
  EXPECT_EQ(missingTransforms(with_table, &robot, buffer).size(), 1U);
}

}  // namespace
}  // namespace deformable_contact_monitor
