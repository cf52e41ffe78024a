// Tests the way from URDF text to link meshes: order, origins, scales, options, and the messages
// that reject a description.
#include "robot/robot_geometry.h"

#include <cmath>
#include <random>
#include <stdexcept>

#include "refusal.h"
#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

constexpr char kOneTriangleObj[] = "v 0 0 0\nv 1 0 0\nv 0 2 0.5\nf 1 2 3\n";

std::string noFiles(const std::string& uri) { throw std::runtime_error("no files here: " + uri); }

std::string samePath(const std::string& uri) { return uri; }

std::string box(const std::string& size, const std::string& origin = "") {
  return "<collision>" + origin + "<geometry><box size=\"" + size + "\"/></geometry></collision>";
}

std::string mesh(const std::string& file, const std::string& scale = "",
                 const std::string& origin = "") {
  const std::string attribute = scale.empty() ? "" : " scale=\"" + scale + "\"";
  return "<collision>" + origin + "<geometry><mesh filename=\"" + file + "\"" + attribute +
         "/></geometry></collision>";
}

LinkGeometry loadLink(const std::string& content, const ResourceResolver& resolve = noFiles) {
  const RobotGeometry robot = loadRobotGeometry(oneLinkUrdf(content), {}, resolve);
  EXPECT_EQ(robot.links.size(), 1U);
  return robot.links.empty() ? LinkGeometry{} : robot.links.front();
}

std::string refusalOf(const std::string& urdf, const RobotGeometryOptions& options = {}) {
  return refusal([&] { loadRobotGeometry(urdf, options, noFiles); });
}

// Three links named against the alphabet, the second without geometry.
std::string threeLinks() {
  return "<robot name=\"r\">\n<link name=\"zulu\">" + box("1 1 1") +
         "</link>\n<link name=\"mike\"/>\n<link name=\"alpha\">" + box("2 2 2") + "</link>\n" +
         "<joint name=\"j1\" type=\"fixed\"><parent link=\"zulu\"/><child link=\"mike\"/></joint>\n"
         "<joint name=\"j2\" type=\"fixed\"><parent link=\"mike\"/><child "
         "link=\"alpha\"/></joint>\n"
         "</robot>\n";
}

void expectLinks(const RobotGeometry& robot, const std::vector<std::string>& names) {
  std::vector<std::string> actual;
  for (const LinkGeometry& link : robot.links) actual.push_back(link.link);
  EXPECT_EQ(actual, names);
}

TEST(RobotGeometry, LinksWithGeometryInDocumentOrder) {
  const RobotGeometry robot = loadRobotGeometry(threeLinks(), {}, noFiles);
  EXPECT_EQ(robot.robots.at(0).name, "r");
  EXPECT_EQ(robot.root_link, "zulu");
  expectLinks(robot, {"zulu", "alpha"});
  EXPECT_EQ(robot.links[0].source, "box 1 x 1 x 1 m");
}

TEST(RobotGeometry, StopsBetweenElements) {
  int asked = 0;
  MeshReading reading;
  reading.stop = [&asked] { return ++asked == 2; };
  EXPECT_THROW(loadRobotGeometry(threeLinks(), {}, noFiles, reading), ReadingStopped);
  EXPECT_EQ(asked, 2);
}

TEST(RobotGeometry, OptionsChooseLinksAndAreChecked) {
  RobotGeometryOptions options;
  options.links = {"alpha", "mike"};
  expectLinks(loadRobotGeometry(threeLinks(), options, noFiles), {"alpha"});
  options.links = {"alpha", "zulu"};
  options.ignored_links = {"alpha"};
  expectLinks(loadRobotGeometry(threeLinks(), options, noFiles), {"zulu"});
  options.links = {"alhpa", "bravo", "zullu"};
  EXPECT_EQ(refusalOf(threeLinks(), options),
            "links: 'alhpa' (did you mean 'alpha'?), 'bravo', 'zullu' (did you mean 'zulu'?): no "
            "such link in robot 'r'");
  options.links = {"alpha", "bravo", "yankee"};
  EXPECT_EQ(refusalOf(threeLinks(), options),
            "links: 'bravo', 'yankee': no such link in robot 'r'");
  options.links.clear();
  options.ignored_links = {"bravo"};
  EXPECT_EQ(refusalOf(threeLinks(), options), "ignored_links: 'bravo': no such link in robot 'r'");
}

TEST(RobotGeometry, CollisionOrVisual) {
  const std::string content =
      box("1 1 1") + "<visual><geometry><sphere radius=\"1\"/></geometry></visual>";
  RobotGeometryOptions options;
  EXPECT_EQ(loadRobotGeometry(oneLinkUrdf(content), options, noFiles).links[0].mesh.triangleCount(),
            12U);
  options.kind = GeometryKind::kVisual;
  EXPECT_EQ(loadRobotGeometry(oneLinkUrdf(content), options, noFiles).links[0].mesh.triangleCount(),
            1280U);
}

// Links with collision geometry, visual geometry, both, and none.
std::string linksOfEachKind() {
  const std::string visual = "<visual><geometry><sphere radius=\"1\"/></geometry></visual>";
  std::string urdf = "<robot name=\"r\"><link name=\"root\"/>";
  for (const auto& [name, content] :
       std::vector<std::pair<std::string, std::string>>{{"solid", box("1 1 1")},
                                                        {"tip", visual},
                                                        {"both", visual + box("1 1 1")},
                                                        {"cover", visual},
                                                        {"frame", ""}}) {
    urdf += "<link name=\"" + name + "\">" + content + "</link><joint name=\"j_" + name +
            "\" type=\"fixed\"><parent link=\"root\"/><child link=\"" + name + "\"/></joint>";
  }
  return urdf + "</robot>";
}

TEST(RobotGeometry, LinksWithGeometryOfTheOtherKindAreNamed) {
  RobotGeometryOptions options;
  const std::string advice = "; set geometry to collision_or_visual to monitor them";
  RobotGeometry robot = loadRobotGeometry(linksOfEachKind(), options, noFiles);
  expectLinks(robot, {"solid", "both"});
  EXPECT_EQ(robot.unmonitored_links, (std::vector<std::string>{"tip", "cover"}));
  EXPECT_EQ(geometryWarnings(robot),
            std::vector<std::string>{"links with visual but no collision geometry are not "
                                     "monitored: 'tip', 'cover'" +
                                     advice});
  options.kind = GeometryKind::kVisual;
  robot = loadRobotGeometry(linksOfEachKind(), options, noFiles);
  expectLinks(robot, {"tip", "both", "cover"});
  EXPECT_EQ(geometryWarnings(robot),
            std::vector<std::string>{"links with collision but no visual geometry are not "
                                     "monitored: 'solid'" +
                                     advice});
  options.kind = GeometryKind::kCollisionOrVisual;
  robot = loadRobotGeometry(linksOfEachKind(), options, noFiles);
  expectLinks(robot, {"solid", "tip", "both", "cover"});
  EXPECT_EQ(robot.links[1].mesh.triangleCount(), 1280U);
  EXPECT_EQ(robot.links[2].mesh.triangleCount(), 12U);  // the collision geometry of both
  EXPECT_TRUE(geometryWarnings(robot).empty());
  // Links that nobody wants are not named.
  options.kind = GeometryKind::kCollision;
  options.ignored_links = {"tip"};
  EXPECT_EQ(loadRobotGeometry(linksOfEachKind(), options, noFiles).unmonitored_links,
            std::vector<std::string>{"cover"});
  options.links = {"solid", "tip"};
  EXPECT_TRUE(loadRobotGeometry(linksOfEachKind(), options, noFiles).unmonitored_links.empty());
}

// A collision element that cannot be read is a problem, and no reason to use another one.
TEST(RobotGeometry, VisualGeometryStandsInForNoBadCollisionGeometry) {
  RobotGeometryOptions options;
  options.kind = GeometryKind::kCollisionOrVisual;
  const RobotGeometry robot = loadRobotGeometry(
      oneLinkUrdf(mesh("/no.stl") + "<visual><geometry><sphere radius=\"1\"/></geometry></visual>"),
      options, noFiles);
  ASSERT_EQ(robot.links.size(), 1U);
  EXPECT_EQ(robot.links[0].problem, "link 'l': /no.stl: no files here: /no.stl");
}

TEST(RobotGeometry, CommentsAheadOfTheDeclarationAreTaken) {
  const std::string declaration = "<?xml version=\"1.0\"?>";
  const std::string robot = "\n<robot name=\"r\"><link name=\"a\"/>\n</robot>";
  for (const std::string& start :
       {std::string(), std::string("\n \t"), std::string("<!-- exported\nby <a> tool -->\n"),
        std::string("<!-- one --><!-- <?xml ?> two -->\r\n"), std::string("\xEF\xBB\xBF<!---->"),
        std::string("<?xml-model href=\"x\"?><!-- x -->")}) {
    EXPECT_EQ(loadRobotGeometry(start + declaration + robot, {}, noFiles).robots.at(0).name, "r")
        << start;
    EXPECT_EQ(loadRobotGeometry(start + robot, {}, noFiles).robots.at(0).name, "r") << start;
  }
  // Lines are those of the text.
  EXPECT_EQ(refusalOf("<!-- a\n\n-->\n" + declaration + "\n<robot name=\"r\">\n<link/></robot>"),
            "robot description, line 6: link without a name");
  EXPECT_NE(refusalOf("<!-- not closed" + declaration + robot), "");
  EXPECT_NE(refusalOf("text" + declaration + robot), "");
}

TEST(RobotGeometry, DescriptionsOfOtherKindsAreRefusedWithTheirKind) {
  EXPECT_EQ(refusalOf("version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 6\n")
                .find("robot description, line 1: is a Git LFS pointer"),
            0U);
  EXPECT_EQ(refusalOf("<!DOCTYPE html><html><robot name=\"r\"/></html>")
                .find("robot description, line 1: is an HTML page"),
            0U);
}

// The path and the URI are the user's, and the reason is the file's.
TEST(RobotGeometry, AFileThatIsNoMeshIsNamedAsInTheDescription) {
  const TemporaryFolder folder;
  const std::string path = folder.write(
      "lfs.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 684\n");
  const LinkGeometry link =
      loadLink(mesh("package://arm/lfs.stl"), [&path](const std::string&) { return path; });
  EXPECT_EQ(link.problem,
            "link 'l': package://arm/lfs.stl: " + path +
                ": is a Git LFS pointer, not the file that it stands for; get that with 'git lfs "
                "pull'");
}

TEST(RobotGeometry, SeveralElementsMergeInOrder) {
  const LinkGeometry link = loadLink(
      box("2 2 2") +
      "<collision><geometry><cylinder radius=\"0.1\" length=\"1\"/></geometry></collision>" +
      box("2 2 2", "<origin xyz=\"10 0 0\"/>"));
  EXPECT_EQ(link.problem, "");
  EXPECT_EQ(link.source, "box 2 x 2 x 2 m; cylinder of radius 0.1 m, length 1 m; box 2 x 2 x 2 m");
  ASSERT_EQ(link.mesh.triangleCount(), 12U + 256U + 12U);
  const auto triangles = cornersOf(link.mesh);
  EXPECT_LE(triangles[11][0].x(), 1);
  EXPECT_LE(std::abs(triangles[12][0].x()), 0.11);
  EXPECT_GE(triangles[268][0].x(), 9);
}

TEST(RobotGeometry, OriginsAreRollPitchYawAboutFixedAxes) {
  // A box along x: pitch turns it down to -z, then yaw leaves it there; then it is moved.
  const LinkGeometry link = loadLink(
      box("4 1 0.5", "<origin xyz=\"1 2 3\" rpy=\"1.5707963267948966 1.5707963267948966 0\"/>"));
  const Bounds bounds = boundsOf(link.mesh);
  // roll: y -> z, z -> -y. pitch: x -> -z, z -> x. So x -> -z, y -> x, z -> -y.
  EXPECT_TRUE((bounds.high - bounds.low).isApprox(Eigen::Vector3d(1, 0.5, 4), 1e-6));
  EXPECT_TRUE(((bounds.high + bounds.low) / 2).isApprox(Eigen::Vector3d(1, 2, 3), 1e-6));
}

TEST(RobotGeometry, MeshIsScaledThenPosed) {
  const TemporaryFolder folder;
  const std::string file = folder.write("t.obj", kOneTriangleObj);
  const LinkGeometry link = loadLink(
      mesh(file, "2 3 4", "<origin xyz=\"0 0 1\" rpy=\"0 0 1.5707963267948966\"/>"), samePath);
  ASSERT_EQ(link.problem, "");
  EXPECT_EQ(link.source, file);
  const auto triangles = cornersOf(link.mesh);
  ASSERT_EQ(triangles.size(), 1U);
  EXPECT_LT((triangles[0][0] - Eigen::Vector3d(0, 0, 1)).norm(), 1e-6);
  EXPECT_LT((triangles[0][1] - Eigen::Vector3d(0, 2, 1)).norm(), 1e-6);
  EXPECT_LT((triangles[0][2] - Eigen::Vector3d(-6, 0, 3)).norm(), 1e-6);
}

TEST(RobotGeometry, VerticesAreRoundedOnce) {
  std::mt19937 dice(5);
  std::vector<float> read;
  for (int i = 0; i < 900; ++i) read.push_back(static_cast<float>(dice() >> 8) * 0x1p-24F);
  const TemporaryFolder folder;
  const LinkGeometry link = loadLink(mesh(folder.write("t.stl", binaryStl("", read)), "0.1 3 0.7",
                                          "<origin xyz=\"0.001 0.1 -0.3\"/>"),
                                     samePath);
  const double scale[3] = {0.1, 3, 0.7}, origin[3] = {0.001, 0.1, -0.3};
  ASSERT_EQ(link.mesh.triangles.size(), read.size() / 3);
  for (std::size_t i = 0; i < read.size(); ++i) {
    const double exact = scale[i % 3] * double{read[i]} + origin[i % 3];
    EXPECT_EQ(link.mesh.vertices[3 * link.mesh.triangles[i / 3] + i % 3],
              static_cast<float>(exact));
  }
}

TEST(RobotGeometry, MirroredScaleTurnsTheWindingRound) {
  const TemporaryFolder folder;
  std::string cube =
      "v -1 -1 -1\nv 1 -1 -1\nv -1 1 -1\nv 1 1 -1\nv -1 -1 1\nv 1 -1 1\nv -1 1 1\n"
      "v 1 1 1\nf 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
  const std::string file = folder.write("cube.obj", cube);
  for (const std::string scale : {"1 1 1", "-1 1 1", "1 -2 1", "1 1 -1", "-1 -1 1", "-1 -1 -1"}) {
    const LinkGeometry link = loadLink(mesh(file, scale), samePath);
    ASSERT_EQ(link.problem, "") << scale;
    EXPECT_TRUE(isClosed(link.mesh)) << scale;
    const double volume = scale == "1 -2 1" ? 16 : 8;
    EXPECT_NEAR(signedVolume(cornersOf(link.mesh)), volume, 1e-6) << scale;
  }
}

// Where links stand is TF's affair: of joints only their being well-formed counts.
TEST(RobotGeometry, MimicAndOtherJointsChangeNothing) {
  const auto withJoint = [](const std::string& type, const std::string& content) {
    const std::string end = "<parent link=\"a\"/><child link=\"b\"/>" + content + "</joint>";
    return loadRobotGeometry(
        "<robot name=\"r\"><link name=\"a\">" + box("1 1 1") + "</link><link name=\"b\">" +
            box("2 2 2") + "</link><joint name=\"j\" type=\"" + type + "\">" + end + "</robot>",
        {}, noFiles);
  };
  const std::string limit = "<limit lower=\"0\" upper=\"1\" effort=\"1\" velocity=\"1\"/>";
  const std::string origin = "<origin xyz=\"1 2 3\" rpy=\"1 0 0\"/>";
  const RobotGeometry fixed = withJoint("fixed", "");
  for (const std::string& content :
       {origin, limit, limit + "<mimic joint=\"j\"/>", limit + "<mimic joint=\"gone\"/>",
        limit + origin + "<mimic joint=\"gone\" multiplier=\"-2\" offset=\"1\"/>"}) {
    SCOPED_TRACE(content);
    const RobotGeometry robot = withJoint(content == origin ? "floating" : "revolute", content);
    expectLinks(robot, {"a", "b"});
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(robot.links[i].problem, "");
      EXPECT_EQ(robot.links[i].mesh.vertices, fixed.links[i].mesh.vertices);
      EXPECT_EQ(robot.links[i].mesh.triangles, fixed.links[i].mesh.triangles);
    }
  }
}

TEST(RobotGeometry, AFileThatIsMissingCostsNobodyElse) {
  const std::string urdf = "<robot name=\"r\"><link name=\"a\">" + box("1 1 1") +
                           mesh("package://gone/one.stl") + mesh("package://gone/two.stl") +
                           "</link><link name=\"b\">" + box("1 1 1") +
                           "</link><joint name=\"j\" type=\"fixed\"><parent link=\"a\"/>" +
                           "<child link=\"b\"/></joint></robot>";
  const RobotGeometry robot = loadRobotGeometry(urdf, {}, noFiles);
  expectLinks(robot, {"a", "b"});
  EXPECT_EQ(robot.links[0].problem,
            "link 'a': package://gone/one.stl: no files here: package://gone/one.stl; "
            "package://gone/two.stl: no files here: package://gone/two.stl");
  EXPECT_TRUE(robot.links[0].mesh.vertices.empty());
  EXPECT_TRUE(robot.links[0].mesh.triangles.empty());
  EXPECT_EQ(robot.links[1].problem, "");
  EXPECT_EQ(robot.links[1].mesh.triangleCount(), 12U);
}

TEST(RobotGeometry, SizesAndScalesThatAreNoneAreProblemsOfTheirLink) {
  const TemporaryFolder folder;
  const std::string file = folder.write("t.obj", kOneTriangleObj);
  const auto geometry = [](const std::string& shape) {
    return "<collision><geometry>" + shape + "</geometry></collision>";
  };
  for (const std::string& content : {box("0 1 1"),
                                     box("1 -1 1"),
                                     box("1 nan 1"),
                                     box("1 1"),
                                     box(""),
                                     box("1e999 1 1"),
                                     geometry("<sphere radius=\"-1\"/>"),
                                     geometry("<sphere radius=\"0\"/>"),
                                     geometry("<sphere radius=\"1,5\"/>"),
                                     geometry("<sphere/>"),
                                     geometry("<cylinder radius=\"0\" length=\"1\"/>"),
                                     geometry("<cylinder radius=\"1\"/>"),
                                     mesh(file, "0 1 1"),
                                     mesh(file, "nan 1 1"),
                                     mesh(file, "inf 1 1"),
                                     mesh(file, "1 1"),
                                     mesh(""),
                                     geometry("<mesh/>"),
                                     geometry("<capsule/>"),
                                     geometry(""),
                                     std::string("<collision/>"),
                                     box("1 1 1", "<origin xyz=\"a b c\"/>"),
                                     box("1 1 1", "<origin rpy=\"nan 0 0\"/>"),
                                     box("1 1 1") + geometry("")}) {
    const LinkGeometry link = loadLink(content, samePath);
    EXPECT_EQ(link.problem.find("link 'l': "), 0U) << content << " -> " << link.problem;
    EXPECT_TRUE(link.mesh.triangles.empty()) << content;
  }
  EXPECT_EQ(loadLink(box("0 1 1")).problem,
            "link 'l': box 0 x 1 x 1 m: box size x is 0, but must be a finite length greater than "
            "zero");
  const std::string no_radius = loadLink(geometry("<sphere/>")).problem;
  EXPECT_NE(no_radius.find("line 1"), std::string::npos) << no_radius;
  EXPECT_NE(no_radius.find("radius"), std::string::npos) << no_radius;
}

TEST(RobotGeometry, WhatGeometryDoesNotNeedMayBeMalformed) {
  const LinkGeometry link = loadLink(
      "<inertial><mass/></inertial><visual><geometry/><material/></visual>" + box("1 1 1"));
  EXPECT_EQ(link.problem, "");
  EXPECT_EQ(link.mesh.triangleCount(), 12U);
}

TEST(RobotGeometry, MalformedDescriptionsAreRefusedWithTheirLine) {
  EXPECT_EQ(refusalOf(""), "robot description: is empty");
  const std::string start = "<robot name=\"r\">\n";
  const std::string link = "<link name=\"a\"/>\n";
  const auto expectLine = [](int line, const std::string& urdf) {
    const std::string expected = "robot description, line " + std::to_string(line) + ": ";
    EXPECT_EQ(refusalOf(urdf).find(expected), 0U) << urdf << " -> " << refusalOf(urdf);
  };
  expectLine(1, "not xml at all");
  expectLine(2, start + "<link name=\"a\">\n</robot>");
  expectLine(1, "<sdf/>");
  expectLine(1, "<robot/>");
  expectLine(1, start + "</robot>");
  expectLine(2, start + "<link/></robot>");
  expectLine(3, start + link + "<link name=\"a\"/></robot>");
  expectLine(3, start + link + "<joint type=\"fixed\"/></robot>");
  expectLine(3, start + link + "<joint name=\"j\" type=\"odd\"/></robot>");
  expectLine(3, start + link + "<joint name=\"j\" type=\"fixed\"><parent link=\"a\"/>" +
                    "<child link=\"gone\"/></joint></robot>");
  expectLine(3, start + link + "<link name=\"b\" name=\"c\"/></robot>");
  expectLine(2, start + "<link name=\"a&#31;\"/></robot>");
  EXPECT_NE(refusalOf(start + link + "<link name=\"b\"/></robot>").find("root"), std::string::npos);
  // Without its macros, a xacro file is a robot that lacks links.
  EXPECT_EQ(refusalOf(start + link + "<xacro:include filename=\"arm.xacro\"/></robot>"),
            "robot description, line 3: <xacro:include> is xacro; run xacro on it first");
  expectLine(2, start + "<link name=\"${prefix}a\"/></robot>");
}

TEST(RobotGeometry, WarningsNameLinkAndFact) {
  const auto warnings = [](const std::string& content) {
    return geometryWarnings(loadRobotGeometry(oneLinkUrdf(content), {}, samePath));
  };
  EXPECT_TRUE(warnings(box("1 1 1")).empty());
  EXPECT_TRUE(warnings(box("0.001 0.0001 0.0001")).empty());
  ASSERT_EQ(warnings(box("11 1 1")).size(), 1U);
  EXPECT_EQ(warnings(box("11 1 1"))[0],
            "link 'l' (box 11 x 1 x 1 m): 11 m long; if its file is in millimetres, give the mesh "
            "a scale");
  ASSERT_EQ(warnings(box("0.0009 0.0009 0.0009")).size(), 1U);
  EXPECT_NE(warnings(box("0.0009 0.0009 0.0009"))[0].find("only 0.0009 m"), std::string::npos);
  std::string spheres;
  for (int i = 0; i < 157; ++i) {
    spheres += "<collision><geometry><sphere radius=\"1\"/></geometry></collision>";
  }
  ASSERT_EQ(warnings(spheres).size(), 1U);
  EXPECT_NE(warnings(spheres)[0].find("200960 triangles"), std::string::npos);
  const TemporaryFolder folder;
  const std::string bent =
      folder.write("bent.obj", "v 0 0 0\nv 1 0 0\nv 1 1 9\nv 0 1 0\nf 1 2 3 4\n");
  ASSERT_EQ(warnings(mesh(bent)).size(), 1U);
  EXPECT_EQ(warnings(mesh(bent))[0].find("link 'l': " + bent + ": 1 of 1 polygons of 4 or more"),
            0U);
  const std::string file = folder.write("t.obj", kOneTriangleObj);
  const std::vector<std::string> overflow = warnings(mesh(file, "1 1e39 1"));  // beyond float32
  ASSERT_EQ(overflow.size(), 1U);
  EXPECT_NE(overflow[0].find("1 vertices are not finite"), std::string::npos) << overflow[0];
}

}  // namespace
}  // namespace deformable_contact_monitor
