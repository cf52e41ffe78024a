// Tests of what each type of object needs, and what is said where it is missing.
#include "monitor/rules/object_types.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "monitor/input/optional_messages.h"
#include "parameter_trees.h"

namespace deformable_contact_monitor {
namespace {

class ObjectTypes : public ::testing::Test {
 protected:
  ObjectTypes() {
    std::ofstream(faces_) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4 3\n";
    std::ofstream(cells_) << "0 1 2 3\n1 2 3 4\n";
  }
  ~ObjectTypes() override {
    std::filesystem::remove(faces_);
    std::filesystem::remove(cells_);
  }

  static XmlRpcValue typed(const std::string& name, const std::string& type) {
    XmlRpcValue value = object(name);
    value["type"] = type;
    return value;
  }

  const std::string faces_ =
      std::filesystem::temp_directory_path() / ("faces_" + std::to_string(getpid()) + ".obj");
  const std::string cells_ = faces_ + ".cells";
};

TEST_F(ObjectTypes, WhatEachNeedsArrives) {
  XmlRpcValue tree, shape = typed("shape", "shape_mesh"), cloud = typed("cloud", "point_cloud");
  shape["frame_id"] = "table";
  cloud["faces"] = "file://" + faces_;
  XmlRpcValue marker_array = typed("fabric", "marker_array");
  marker_array["marker"]["ns"] = "cloth";
  marker_array["marker"]["id"] = -2;
  XmlRpcValue tetrahedra = typed("liver", "tetrahedra");
  tetrahedra["cells"] = "file://" + cells_;
  tree["objects"] = list(object("cloth"), typed("mesh", "deformable_mesh"), shape,
                         typed("marker", "marker"), cloud, marker_array, tetrahedra);
  std::vector<std::string> warnings;
  const MonitorParameters p = parse(tree, &warnings);
  EXPECT_TRUE(warnings.empty());
  std::vector<MeshType> types;
  for (const ObjectParameters& object : p.objects) types.push_back(object.type);
  EXPECT_EQ(types,
            (std::vector<MeshType>{MeshType::kDeformableMesh, MeshType::kDeformableMesh,
                                   MeshType::kShapeMesh, MeshType::kMarker, MeshType::kPointCloud,
                                   MeshType::kMarkerArray, MeshType::kTetrahedra}));
  ASSERT_NE(p.objects[6].faces, nullptr);
  EXPECT_EQ(p.objects[6].faces->point_count, 5U);
  EXPECT_EQ(p.objects[6].faces->triangles.size(), 18U);
  EXPECT_EQ(p.objects[5].marker, MarkerName("cloth", -2));
  EXPECT_EQ(p.objects[2].frame_id, "table");
  ASSERT_NE(p.objects[4].faces, nullptr);
  EXPECT_EQ(p.objects[4].faces->point_count, 4U);
  EXPECT_EQ(p.objects[4].faces->triangles, (std::vector<std::uint32_t>{0, 1, 3, 0, 3, 2}));
}

TEST_F(ObjectTypes, AllThatIsMissingIsListedTogether) {
  XmlRpcValue tree, relative = typed("relative", "point_cloud"), absent = relative,
                    package = relative, broken = relative, empty = typed("cloud", "point_cloud");
  empty["faces"] = "";
  relative["faces"] = "cloth.obj";
  absent["name"] = "absent";
  absent["faces"] = "/no/such/cloth.obj";
  package["name"] = "package";
  package["faces"] = "package://no_such_package/cloth.obj";
  broken["name"] = "broken";
  broken["faces"] = faces_;
  std::ofstream(faces_) << "v 0 0 0\nf 1 2 3\n";
  tree["objects"] = list(typed("mesh", "mesh"), typed("shape", "shape_mesh"), empty, relative,
                         absent, package, broken);
  const std::string all = refusalOf(tree);
  expectIn("7 bad parameter(s)", all);
  for (const std::string& problem :
       {std::string(
            "~objects[0]/type is 'mesh', must be one of: deformable_mesh, shape_mesh, "
            "marker, point_cloud, marker_array, tetrahedra, polygon_mesh, points, polyline, "
            "rigid"),
        std::string("~objects[1]/frame_id is missing"), std::string("~objects[2]/faces is empty"),
        std::string("~objects[3]/faces is 'cloth.obj': neither package://, file:// nor"),
        std::string("~objects[4]/faces is '/no/such/cloth.obj': no such file"),
        std::string("~objects[5]/faces is 'package://no_such_package/cloth.obj': package"),
        "~objects[6]/faces is '" + faces_ + "': " + faces_ + ":2"}) {
    expectIn(problem, all);
  }
}

TEST_F(ObjectTypes, ACloudWithoutFacesIsADepthCamera) {
  XmlRpcValue tree, plain = typed("a", "point_cloud"), set = typed("b", "point_cloud"),
                    faces = typed("c", "point_cloud");
  set["max_depth_jump"] = 0.25;
  set["min_seen"] = 1;
  faces["faces"] = "file://" + faces_;
  faces["min_seen"] = 0.5;
  tree["objects"] = list(plain, set, faces);
  std::vector<std::string> warnings;
  const MonitorParameters p = parse(tree, &warnings);
  EXPECT_EQ(p.objects[0].faces, nullptr);
  EXPECT_EQ(p.objects[0].depth.max_depth_jump, 0.05);
  EXPECT_EQ(p.objects[0].depth.min_seen, 0.01);
  EXPECT_EQ(p.objects[1].depth.max_depth_jump, 0.25);
  EXPECT_EQ(p.objects[1].depth.min_seen, 1);
  ASSERT_EQ(warnings.size(), 1U);
  expectIn("~objects[2]/min_seen", warnings[0]);

  XmlRpcValue wide = typed("d", "point_cloud"), unseen = wide, parts = wide;
  wide["max_depth_jump"] = 1.5;
  unseen["name"] = "e";
  unseen["min_seen"] = -0.1;
  parts["name"] = "f";
  parts["parts"] = list(object("hem"));
  parts["parts"][0]["indices_file"] = cells_;
  tree["objects"] = list(wide, unseen, parts);
  const std::string all = refusalOf(tree);
  expectIn("~objects[0]/max_depth_jump", all);
  expectIn("~objects[1]/min_seen", all);
  expectIn("~objects[2]/parts are not supported for a point_cloud without faces", all);
}

TEST_F(ObjectTypes, APolylineComesInTheMessageThatIsNamed) {
  const std::pair<const char*, MeshType> messages[] = {{nullptr, MeshType::kPolyline},
                                                       {"point_cloud", MeshType::kPolyline},
                                                       {"pose_array", MeshType::kPolylinePoses},
#ifdef DCM_HAS_NAV_MSGS
                                                       {"path", MeshType::kPolylinePath},
#endif
                                                       {"marker", MeshType::kPolylineMarker}};
  XmlRpcValue tree, rope = typed("rope", "polyline"), grains = typed("grains", "points");
  rope["radius_m"] = 0.004;
  grains["radius_m"] = 0;
  for (const auto& [message, type] : messages) {
    if (message != nullptr) rope["message"] = message;
    tree["objects"] = list(rope, grains);
    std::vector<std::string> warnings;
    const MonitorParameters p = parse(tree, &warnings);
    EXPECT_TRUE(warnings.empty());
    EXPECT_EQ(p.objects[0].type, type);
    EXPECT_EQ(p.objects[0].radius_m, 0.004F);
    EXPECT_EQ(p.objects[1].type, MeshType::kPoints);
  }
  grains["message"] = "point_cloud";
  tree["objects"] = list(grains);
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  expectIn("~objects[0]/message", warnings[0]);
}

TEST_F(ObjectTypes, PointsAndPolylinesNeedARadius) {
  XmlRpcValue tree, bad = typed("bad", "polyline");
  bad["message"] = "line_strip";
  tree["objects"] = list(typed("rope", "polyline"), typed("grains", "points"), bad);
  const std::string all = refusalOf(tree);
  expectIn("4 bad parameter(s)", all);
  expectIn("~objects[0]/radius_m is missing: points and polylines have no thickness", all);
  expectIn("~objects[1]/radius_m is missing", all);
  expectIn(
      "~objects[2]/message is 'line_strip', must be one of: point_cloud, pose_array, path, "
      "marker",
      all);
}

TEST_F(ObjectTypes, EachMayHaveItsStampsCorrected) {
  XmlRpcValue tree, late = object("late"), early = typed("early", "marker");
  late["stamp_offset_s"] = -0.25;
  early["stamp_offset_s"] = 5;
  tree["objects"] = list(object("cloth"), late, early);
  const MonitorParameters p = parse(tree);
  EXPECT_EQ(p.objects[0].stamp_offset_s, 0);
  EXPECT_EQ(p.objects[1].stamp_offset_s, -0.25);
  EXPECT_EQ(p.objects[2].stamp_offset_s, 5);
  late["stamp_offset_s"] = -5.5;
  tree["objects"] = list(late);
  expectIn("~objects[0]/stamp_offset_s", refusalOf(tree));
}

TEST_F(ObjectTypes, AMarkerOfAnArrayNeedsItsName) {
  XmlRpcValue tree, whole = typed("a", "marker_array"), nameless = typed("b", "marker_array"),
                    half = typed("c", "marker_array"), text = typed("d", "marker_array");
  whole["marker"]["id"] = 0;
  whole["marker"]["name"] = "cloth";
  half["marker"]["ns"] = "cloth";
  text["marker"]["id"] = "two";
  tree["objects"] = list(whole);
  std::vector<std::string> warnings;
  EXPECT_EQ(parse(tree, &warnings).objects[0].marker, MarkerName("", 0));
  ASSERT_EQ(warnings.size(), 1U);
  expectIn("~objects[0]/marker/name", warnings[0]);
  tree["objects"] = list(whole, nameless, half, text);
  const std::string all = refusalOf(tree);
  expectIn("3 bad parameter(s)", all);
  expectIn("~objects[1]/marker is missing", all);
  expectIn("~objects[2]/marker is missing: give the marker's name", all);
  expectIn("~objects[3]/marker/id is", all);
}

TEST_F(ObjectTypes, ABadFileOfCellsIsAProblemAtStart) {
  XmlRpcValue tree, missing = typed("a", "tetrahedra"), absent = typed("b", "tetrahedra"),
                    device = typed("c", "tetrahedra"), bad = typed("d", "tetrahedra");
  absent["cells"] = "/no/such/cells.txt";
  device["cells"] = "/dev/zero";
  bad["cells"] = cells_;
  std::ofstream(cells_) << "0 1 2 3\n0 1 2 3 4\n";
  tree["objects"] = list(missing, absent, device, bad);
  const std::string all = refusalOf(tree);
  expectIn("4 bad parameter(s)", all);
  expectIn("~objects[0]/cells is missing: give the file", all);
  expectIn("~objects[1]/cells is '/no/such/cells.txt': ", all);
  expectIn("~objects[2]/cells is '/dev/zero': ", all);
  expectIn("~objects[3]/cells is '" + cells_ + "': line 2 is '0 1 2 3 4', must be the four", all);
}

TEST_F(ObjectTypes, WhatATypeDoesNotNeedIsAWarning) {
  XmlRpcValue tree, marker = typed("marker", "marker");
  marker["frame_id"] = "table";
  marker["faces"] = faces_;
  tree["objects"] = list(marker);
  std::vector<std::string> warnings;
  parse(tree, &warnings);
  ASSERT_EQ(warnings.size(), 2U);
  expectIn("~objects[0]/faces ", warnings[0] + warnings[1]);
  expectIn("~objects[0]/frame_id ", warnings[0] + warnings[1]);
}

}  // namespace
}  // namespace deformable_contact_monitor
