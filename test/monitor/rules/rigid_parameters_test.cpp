// Tests the parameters of rigid objects: their shapes, and what is refused by name.
#include "monitor/rules/rigid_parameters.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "parameter_trees.h"

namespace deformable_contact_monitor {
namespace {

class RigidObjects : public ::testing::Test {
 protected:
  RigidObjects() { write("v 0 0 0\nv 1000 0 0\nv 0 500 0\nv 1000 500 1\nf 1 2 4 3\n"); }
  ~RigidObjects() override { std::filesystem::remove(file_); }

  void write(const std::string& text) const { std::ofstream(file_) << text; }

  static XmlRpcValue rigid(const std::string& name) {
    XmlRpcValue value = object(name);
    value["type"] = "rigid";
    value["frame"] = name + "_frame";
    return value;
  }

  XmlRpcValue fromFile(const std::string& uri) const {
    XmlRpcValue value = rigid("table");
    value["mesh"] = uri;
    return value;
  }

  static std::string refusalOfOne(const XmlRpcValue& value) {
    XmlRpcValue tree;
    tree["objects"] = list(value);
    return refusalOf(tree);
  }

  const std::string file_ =
      std::filesystem::temp_directory_path() / ("rigid_" + std::to_string(getpid()) + ".obj");
};

TEST_F(RigidObjects, AreFilesOrPrimitives) {
  XmlRpcValue tree, table = fromFile("file://" + file_), bed = rigid("bed"), leg = rigid("leg"),
                    ball = rigid("ball");
  table["scale"] = 0.001;
  table["margin_m"] = 0.25;
  bed["box"] = list(2, 1, 0.5);
  bed["radius_m"] = 0.125;
  leg["cylinder"]["radius"] = 0.25;
  leg["cylinder"]["length"] = 1;
  ball["sphere"]["radius"] = 0.5;
  tree["objects"] = list(table, object("cloth"), bed, leg, ball);
  tree["margin_m"] = 0.5;
  tree["pair_classes"] = list("deformable_rigid");
  std::vector<std::string> warnings;
  const MonitorParameters p = parse(tree, &warnings);
  EXPECT_EQ(warnings, std::vector<std::string>());
  EXPECT_TRUE(p.pair_classes.deformable_rigid);
  EXPECT_FALSE(p.pair_classes.needRobot());
  ASSERT_EQ(p.objects.size(), 1U) << "rigid objects have no messages";
  ASSERT_EQ(p.rigids.size(), 4U);
  EXPECT_EQ(p.rigids[0].frame, "table_frame");
  EXPECT_EQ(p.rigids[0].margin_m, 0.25F);
  EXPECT_FALSE(p.rigids[0].shares_margin);
  EXPECT_EQ(p.rigids[0].mesh->triangles, (HostList<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(p.rigids[0].mesh->vertices[3], 1.0F);
  EXPECT_EQ(p.rigids[0].mesh->vertices[7], 0.5F);
  EXPECT_EQ(p.rigids[1].radius_m, 0.125F);
  EXPECT_EQ(p.rigids[1].margin_m, 0.5F);
  EXPECT_TRUE(p.rigids[1].shares_margin);
  EXPECT_EQ(p.rigids[1].mesh->triangleCount(), 12U);
  EXPECT_EQ(p.rigids[1].mesh->vertices[0], -1.0F);
  EXPECT_EQ(p.rigids[2].mesh->triangleCount(), 256U);
  EXPECT_EQ(p.rigids[3].mesh->triangleCount(), 1280U);
}

TEST_F(RigidObjects, ThatNoClassIsAboutAreWarnedOf) {
  XmlRpcValue tree, bed = rigid("bed");
  bed["box"] = list(2, 1, 0.5);
  tree["objects"] = list(bed);
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  expectIn("nothing looks at rigid object 'bed'", warnings[0]);
  tree["pair_classes"] = list("robot_rigid");
  warnings.clear();
  const MonitorParameters p = parse(tree, &warnings);
  EXPECT_TRUE(warnings.empty());
  EXPECT_TRUE(p.pair_classes.needRobot() && p.pair_classes.needRobotCycles());
}

TEST_F(RigidObjects, InMillimetresAreWarnedOf) {
  XmlRpcValue tree;
  tree["objects"] = list(fromFile(file_));
  tree["pair_classes"] = list("deformable_rigid");
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0],
            "rigid object 'table': 1000.000000 m long; if its file is in millimetres, set scale: "
            "0.001");
}

TEST_F(RigidObjects, WithoutFrameOrShapeAreRefused) {
  XmlRpcValue bare = object("bare"), two = rigid("two"), slash = rigid("slash");
  bare["type"] = "rigid";
  expectIn("~objects[0]/frame is missing: type rigid needs the TF frame", refusalOfOne(bare));
  expectIn("~objects[0]/mesh, box, cylinder and sphere are the shapes of type rigid: give one",
           refusalOfOne(bare));
  two["box"] = list(1, 1, 1);
  two["sphere"]["radius"] = 1;
  expectIn("give one", refusalOfOne(two));
  slash["frame"] = "/table";
  slash["box"] = list(1, 1, 1);
  expectIn("~objects[0]/frame is '/table', must not begin with '/'", refusalOfOne(slash));
}

TEST_F(RigidObjects, BadSizesAreRefused) {
  const double nan = std::nan(""), infinite = std::numeric_limits<double>::infinity();
  for (const double bad : {0.0, -1.0, 1e-7, 1001.0, nan, infinite}) {
    XmlRpcValue box = rigid("box"), ball = rigid("ball"), leg = rigid("leg");
    box["box"] = list(1.0, bad, 1.0);
    expectIn("~objects[0]/box", refusalOfOne(box));
    ball["sphere"]["radius"] = bad;
    expectIn("~objects[0]/sphere/radius", refusalOfOne(ball));
    leg["cylinder"]["radius"] = 1;
    leg["cylinder"]["length"] = bad;
    expectIn("~objects[0]/cylinder/length", refusalOfOne(leg));
    XmlRpcValue scaled = fromFile(file_);
    scaled["scale"] = bad < 1 ? bad - 1 : 1e3 * bad;
    expectIn("~objects[0]/scale", refusalOfOne(scaled));
  }
  XmlRpcValue flat = rigid("flat"), words = rigid("words"), leg = rigid("leg"), box = rigid("box");
  flat["box"] = list(1, 1);
  expectIn("~objects[0]/box", refusalOfOne(flat));
  words["sphere"] = "big";
  expectIn("~objects[0]/sphere", refusalOfOne(words));
  leg["cylinder"]["radius"] = 1;
  expectIn("~objects[0]/cylinder/length is missing", refusalOfOne(leg));
  box["box"] = list(1, 1, 1);
  box["scale"] = 2;
  expectIn("~objects[0]/scale is not supported with a box", refusalOfOne(box));
}

TEST_F(RigidObjects, BadFilesAreRefused) {
  expectIn("~objects[0]/mesh is '/no/such/table.stl': no such file",
           refusalOfOne(fromFile("/no/such/table.stl")));
  expectIn("~objects[0]/mesh is 'package://no_such_package/table.stl': package",
           refusalOfOne(fromFile("package://no_such_package/table.stl")));
  expectIn("~objects[0]/mesh is empty", refusalOfOne(fromFile("")));
  write("v 0 0 0\nf 1 2 3\n");
  expectIn("~objects[0]/mesh is '" + file_ + "': " + file_ + ": line 2",
           refusalOfOne(fromFile(file_)));
  write("v 0 0 0\nv 1e300 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_NE(refusalOfOne(fromFile(file_)), "") << "beyond float32";
  write("v 0 0 0\nv 1e38 0 0\nv 0 1 0\nf 1 2 3\n");
  XmlRpcValue scaled = fromFile(file_);
  scaled["scale"] = 1000;
  expectIn("~objects[0]/mesh has 1 vertices that are not finite", refusalOfOne(scaled));
  std::filesystem::resize_file(file_, (std::uintmax_t{1} << 29U) + 1);  // a hole, no data
  expectIn("~objects[0]/mesh is '" + file_ + "': ", refusalOfOne(fromFile(file_)));
  std::ofstream nan(file_ + ".ply");
  nan << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      << "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
      << "0 0 0\nnan 0 0\n0 1 0\n3 0 1 2\n";
  nan.close();
  expectIn("~objects[0]/mesh ", refusalOfOne(fromFile(file_ + ".ply")));
  std::filesystem::remove(file_ + ".ply");
}

TEST_F(RigidObjects, WhatOnlyMessagesHaveIsRefused) {
  XmlRpcValue bed = rigid("bed");
  bed["box"] = list(2, 1, 0.5);
  for (const char* const key : {"topic", "required", "stamp_offset_s", "frame_id", "faces", "cells",
                                "marker", "max_depth_jump", "min_seen"}) {
    XmlRpcValue with = bed;
    with[key] = "1";
    expectIn(std::string("~objects[0]/") + key + " is not supported with type rigid",
             refusalOfOne(with));
  }
  bed["parts"] = list(object("edge"));
  expectIn("~objects[0]/parts are not supported with type rigid; make each part an object",
           refusalOfOne(bed));
}

TEST_F(RigidObjects, NamesAreUniqueAmongAllObjects) {
  XmlRpcValue tree, bed = rigid("cloth");
  bed["box"] = list(2, 1, 0.5);
  tree["objects"] = list(object("cloth"), bed);
  expectIn("~objects[1]/name is 'cloth', which is another object's name", refusalOf(tree));
  XmlRpcValue cloth = object("cloth"), hem = object("hem");
  hem["triangles"] = list(list(0, 1));
  cloth["parts"] = list(hem);
  bed["name"] = "cloth:hem";
  tree["objects"] = list(cloth, bed);
  expectIn("'cloth:hem', which looks like a part of 'cloth'", refusalOf(tree));
  bed["name"] = "*";
  expectIn("~objects[0]/name is '*'", refusalOfOne(bed));
}

TEST_F(RigidObjects, ARadiusExcludesWhatItExcludesForOthers) {
  XmlRpcValue tree, bed = rigid("bed");
  bed["box"] = list(2, 1, 0.5);
  bed["radius_m"] = 0.5;
  tree["objects"] = list(bed);
  tree["motion"] = "swept";
  expectIn("~motion: swept is not supported with radius_m, which 'bed' has", refusalOf(tree));
}

}  // namespace
}  // namespace deformable_contact_monitor
