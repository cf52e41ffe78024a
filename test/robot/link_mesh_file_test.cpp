// Mesh files of links: formats, hierarchies, units, up axes, and files that are none.
#include <array>
#include <random>
#include <stdexcept>

#include "core/mesh_file.h"
#include "robot/link_mesh_files.h"
#include "robot_test_support.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

const std::string kTurned =
    "<node id=\"a\"><translate>0 0 5</translate><rotate>1 0 0 90</rotate><scale>1 2 1</scale>"
    "<instance_geometry url=\"#g\"/></node>";
const std::string kMirrored =
    "<node id=\"b\"><matrix>-1 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1</matrix>"
    "<instance_geometry url=\"#g\"/></node>";

// One triangle (0 0 0), (1 0 0), (0 2 3), in the given nodes.
std::string colladaText(const std::string& asset, const std::string& nodes) {
  return "<?xml version=\"1.0\"?><COLLADA "
         "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>" +
         asset +
         "</asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\">"
         "<float_array id=\"q\" count=\"9\">0 0 0 1 0 0 0 2 3</float_array><technique_common>"
         "<accessor source=\"#q\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
         "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
         "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
         "source=\"#p\"/></vertices><triangles count=\"1\"><input semantic=\"VERTEX\" "
         "source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry>"
         "</library_geometries><library_visual_scenes><visual_scene id=\"s\">" +
         nodes +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/>"
         "</scene></COLLADA>";
}

std::string replaced(std::string text, const std::string& from, const std::string& by) {
  return text.replace(text.find(from), from.size(), by);
}

void expectCorners(const Corners& expected, const Corners& actual) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_LT((expected[k] - actual[k]).norm(), 1e-5) << k << ": " << actual[k].transpose();
  }
}

std::string failure(const std::string& path) {
  try {
    readLinkMeshFile(path);
  } catch (const std::runtime_error& e) {
    return e.what();
  }
  return "";
}

TEST(LinkMeshFile, ColladaUnitsCountAndUpAxesDoNot) {
  const TemporaryFolder folder;
  for (const auto& [unit, metres] : {std::pair<std::string, double>{"", 1},
                                     {"<unit meter=\"1\"/>", 1},
                                     {"<unit name=\"centimeter\" meter=\"0.01\"/>", 0.01},
                                     {"<unit meter=\"10\"/>", 10}}) {
    for (const std::string up : {"", "X_UP", "Y_UP", "Z_UP"}) {
      SCOPED_TRACE(unit + " " + up);
      const std::string axis = up.empty() ? "" : "<up_axis>" + up + "</up_axis>";
      const auto triangles = cornersOf(
          readLinkMeshFile(folder.write("t.dae", colladaText(unit + axis, kTurned + kMirrored))));
      ASSERT_EQ(triangles.size(), 2U);
      const double s = metres;
      // (x y z) -> (x, -z, 2 y + 5), by hand.
      expectCorners({Eigen::Vector3d(0, 0, 5) * s, Eigen::Vector3d(1, 0, 5) * s,
                     Eigen::Vector3d(0, -3, 9) * s},
                    triangles[0]);
      // Mirrored: the second and third corner change places.
      expectCorners({Eigen::Vector3d(0, 0, 0) * s, Eigen::Vector3d(0, 2, 3) * s,
                     Eigen::Vector3d(-1, 0, 0) * s},
                    triangles[1]);
    }
  }
}

TEST(LinkMeshFile, NestedNodesMultiply) {
  const TemporaryFolder folder;
  const std::string nodes =
      "<node><scale>2 2 2</scale><node><translate>1 0 0</translate>"
      "<instance_geometry url=\"#g\"/></node></node>";
  const auto triangles = cornersOf(readLinkMeshFile(folder.write("t.dae", colladaText("", nodes))));
  ASSERT_EQ(triangles.size(), 1U);
  expectCorners({Eigen::Vector3d(2, 0, 0), Eigen::Vector3d(4, 0, 0), Eigen::Vector3d(2, 4, 6)},
                triangles[0]);
}

TEST(LinkMeshFile, ObjPolygonsAreTriangulatedAndPointsAndLinesDropped) {
  const TemporaryFolder folder;
  const std::string path = folder.write(
      "t.OBJ", "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.5 0\nv 0 2 0\nv 5 5 5\np 6\nl 1 6\nf 1 2 3 4 5\n");
  const auto triangles = cornersOf(readLinkMeshFile(path));
  EXPECT_EQ(triangles.size(), 3U);
  EXPECT_NEAR(surfaceArea(triangles), 4 - 1.5, 1e-6);  // concave: ears, no fan over the notch
}

// An L whose notch touches the line of an edge, from each of its corners on. Assimp alone covers
// the notch from one of them.
TEST(LinkMeshFile, ColladaPolygonsAreTheSurfaceOfTheSamePolygonsInObj) {
  const TemporaryFolder folder;
  const std::array<std::string, 6> outline = {"0 0 0", "2 0 0", "2 1 0", "1 1 0", "1 2 0", "0 2 0"};
  for (std::size_t start = 0; start < outline.size(); ++start) {
    SCOPED_TRACE(start);
    std::string text = colladaText("", kTurned + kMirrored), numbers, obj, face = "f";
    for (std::size_t i = 0; i < outline.size(); ++i) {
      numbers += outline[(start + i) % outline.size()] + " ";
      obj += "v " + outline[(start + i) % outline.size()] + "\n";
      face += " " + std::to_string(i + 1);
    }
    text = replaced(text, "count=\"9\">0 0 0 1 0 0 0 2 3", "count=\"18\">" + numbers);
    text = replaced(text, "count=\"3\" stride", "count=\"6\" stride");
    text = replaced(text, "<triangles count=\"1\">", "<polylist count=\"1\">");
    text = replaced(text, "<p>0 1 2</p></triangles>",
                    "<vcount>6</vcount><p>0 1 2 3 4 5</p></polylist>");
    const auto from_obj = cornersOf(readLinkMeshFile(folder.write("l.obj", obj + face + "\n")));
    const auto from_dae = cornersOf(readLinkMeshFile(folder.write("l.dae", text)));
    EXPECT_NEAR(surfaceArea(from_obj), 3, 1e-6);
    ASSERT_EQ(from_dae.size(), 2 * from_obj.size());
    for (std::size_t t = 0; t < from_obj.size(); ++t) {
      const auto moved = [&](int k, double x_sign) {
        const Eigen::Vector3d& v = from_obj[t][k];
        return x_sign > 0 ? Eigen::Vector3d(v.x(), -v.z(), 2 * v.y() + 5)
                          : Eigen::Vector3d(-v.x(), v.y(), v.z());
      };
      expectCorners({moved(0, 1), moved(1, 1), moved(2, 1)}, from_dae[t]);
      expectCorners({moved(0, -1), moved(2, -1), moved(1, -1)}, from_dae[from_obj.size() + t]);
    }
  }
}

TEST(LinkMeshFile, BinaryStlKeepsEveryBitAlsoWhereItsHeaderSaysSolid) {
  std::vector<float> corners;
  std::mt19937 dice(1);
  for (int i = 0; i < 900; ++i) corners.push_back(static_cast<float>(dice()) * 1e-9F);
  // Degenerate triangles stay: their ids are those of the file.
  for (int i = 0; i < 9; ++i) corners.push_back(0.125F);
  const TemporaryFolder folder;
  const auto triangles =
      cornersOf(readLinkMeshFile(folder.write("t.STL", binaryStl("solid cad", corners))));
  ASSERT_EQ(triangles.size(), 101U);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_EQ(triangles[i / 9][i / 3 % 3][static_cast<long>(i % 3)], corners[i]);
  }
}

TEST(LinkMeshFile, AsciiStl) {
  const TemporaryFolder folder;
  const auto triangles = cornersOf(readLinkMeshFile(
      folder.write("t.stl",
                   "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                   "vertex 0 1 0.5\nendloop\nendfacet\nendsolid a\n")));
  ASSERT_EQ(triangles.size(), 1U);
  expectCorners({Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0.5)},
                triangles[0]);
}

// The vertices and triangles of a file are the same as a link and elsewhere, and so are the notes.
void expectAsReadMeshFile(const std::string& path) {
  SCOPED_TRACE(path);
  MeshFileReport report;
  std::string error;
  TriangleMesh expected;
  try {
    expected = readMeshFile(path, &report);
  } catch (const std::runtime_error& refused) {
    error = refused.what();
  }
  if (!error.empty()) {
    const std::string line = path + ":";
    const bool has_line = error.compare(0, line.size(), line) == 0 && error[line.size()] != ' ';
    EXPECT_EQ(failure(path), has_line ? path + ": line " + error.substr(line.size()) : error);
    return;
  }
  const SourceMesh mesh = readLinkMeshFile(path);
  EXPECT_EQ(mesh.note, report.notes.empty() ? "" : report.notes[0]);
  ASSERT_EQ(mesh.vertices.size(), expected.vertexCount());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3f v = expected.vertex(i);
    if (isFinite(v)) {
      ASSERT_EQ(mesh.vertices[i], Eigen::Vector3d(v.x, v.y, v.z));
    } else {
      ASSERT_FALSE(mesh.vertices[i].allFinite());
    }
  }
  ASSERT_EQ(mesh.triangles.size(), expected.triangleCount());
  for (std::size_t i = 0; i < expected.triangles.size(); ++i) {
    ASSERT_EQ(mesh.triangles[i / 3][i % 3], expected.triangles[i]);
  }
}

TEST(LinkMeshFile, FilesAreReadAsEverywhere) {
  const TemporaryFolder folder;
  const std::string vertices = "0 0 0\n2 0 0\n2 1 0\n0.1 0.1 0\n1 2 0\n0 2 1e-3\n";
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0.1\nvertex 0 1 0\n";
  const std::string stl = binaryStl("cad", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"a.off", "OFF\n6 2 0\n" + vertices + "6 1 2 3 4 5 0\n3 0 1 5\n"},
           {"a.PLY",
            "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\n"
            "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
            "end_header\n" +
                vertices + "6 0 1 2 -1 3 4\n"},
           {"two_words.stl", "solid c\n" + facet + "end loop\nend facet\nend solid c\n"},
           {"cut.stl", "solid c\n" + facet + "endloop\n"},
           {"trailing.stl", stl + "1234567"},
           {"uncounted.stl", stl + std::string(50, 'x')},
           {"bent.obj", "v 0 0 0\nv 1 0 0\nv 1 1 9\nv 0 1 0\nf 1 2 3 4\n"},
           {"nan.obj", "v 0 0 0\nv 1 0 -1.#IND\nv 1 1 9\nf 1 2 3\n"},
           {"bad.obj", "v 0 0 0\nf 1 2 x\n"},
           {"wide.obj", "\xFF\xFEv" + std::string(1, '\0') + " "},
           {"page.ply", "<html>ply</html>"}}) {
    expectAsReadMeshFile(folder.write(name, text));
  }
  EXPECT_EQ(failure(folder.write("cut.stl", "solid c\n" + facet + "endloop\n")),
            (folder.path() / "cut.stl: line 8: 'endfacet' expected, but the file ends").string());
}

TEST(LinkMeshFile, FieldFilesAreReadAsEverywhere) {
  DCM_REQUIRE_TEST_DATA();
  for (const auto& entry : std::filesystem::directory_iterator(testDataFile("field/meshes"))) {
    expectAsReadMeshFile(entry.path());
  }
  expectAsReadMeshFile(testDataFile("field/urdf/lfs.stl"));
}

TEST(LinkMeshFile, FilesOfOtherKindsAreRefusedWithTheirKind) {
  const TemporaryFolder folder;
  const std::string good = colladaText("", kTurned);
  for (const auto& [text, kind] : std::vector<std::pair<std::string, std::string>>{
           {"version https://git-lfs.github.com/spec/v1\noid sha256:ab\nsize 684\n",
            "is a Git LFS pointer"},
           {"<?xml version=\"1.0\"?>\n<!DOCTYPE html><html><body/></html>", "is an HTML page"},
           {"\xFF\xFE<" + std::string(1, '\0'), "is UTF-16 text"},
           {"PK\3\4 COLLADA", "is a zip archive"},
           {" \n", "holds nothing but blanks"},
           {"", "is empty"}}) {
    for (const char* name : {"a.stl", "a.obj", "a.dae", "a.ply", "a.off"}) {
      const std::string path = folder.write(name, text);
      const bool is_xml = path.substr(path.size() - 4) == ".dae";
      EXPECT_EQ(failure(path).find(path + (is_xml ? ": line 1: " : ": ") + kind), 0U)
          << failure(path);
    }
  }
  // XML allows nothing ahead of its declaration, but programs write it.
  const auto triangles =
      cornersOf(readLinkMeshFile(folder.write("a.dae", "<!-- made -->\n" + good)));
  EXPECT_EQ(triangles.size(), 1U);
}

TEST(LinkMeshFile, WhatIsNoMeshIsRefusedByName) {
  const TemporaryFolder folder;
  const std::string missing = (folder.path() / "missing.stl").string();
  EXPECT_EQ(failure(missing), missing + ": no such file");
  std::filesystem::create_directory(folder.path() / "folder.stl");
  EXPECT_NE(failure((folder.path() / "folder.stl").string()).find("not a regular file"),
            std::string::npos);
  for (const char* name : {"empty.stl", "empty.dae", "empty.obj"}) {
    const std::string path = folder.write(name, "");
    EXPECT_EQ(failure(path).find(path + ": "), 0U) << failure(path);
  }
  const std::string garbage(5000, '\x8f');
  for (const char* name : {"g.stl", "g.dae", "g.obj"}) {
    const std::string path = folder.write(name, garbage);
    EXPECT_EQ(failure(path).find(path + ": "), 0U) << failure(path);
  }
  EXPECT_NE(failure(folder.write("a.fbx", "x")).find("'.fbx' is no mesh format"),
            std::string::npos);
  EXPECT_NE(failure(folder.write("a", "x")).find("'' is no mesh format"), std::string::npos);
  EXPECT_NE(failure(folder.write("points.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\np 1\nl 1 2\n")), "");
  EXPECT_NE(failure(folder.write("t.dae", colladaText("", ""))), "");
}

TEST(LinkMeshFile, ColladaThatAssimpWouldCrashOrHangOnIsRefusedWithItsLine) {
  const TemporaryFolder folder;
  const std::string good = colladaText("", kTurned);
  const auto failureOf = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    const std::string path = folder.write("t.dae", text);
    const std::string message = failure(path);
    EXPECT_EQ(message.find(path + ": line 1: "), 0U) << message;
    return message.substr(std::min(message.size(), (path + ": line 1: ").size()));
  };
  EXPECT_EQ(failureOf(" count=\"9\"", ""), "an accessor needs 9 numbers, but array 'q' has 0");
  EXPECT_EQ(failureOf("count=\"3\"", "count=\"4\""),
            "an accessor needs 12 numbers, but array 'q' has 9");
  EXPECT_EQ(failureOf("count=\"9\"", "count=\"9a\""), "count=\"9a\" is no count");
  EXPECT_EQ(failureOf("<p>0 1 2", "<p>0 1 a"), "<p> holds more than integers");
  EXPECT_EQ(failureOf("</COLLADA>", ""), "not well-formed XML: XML_ERROR_PARSING");
}

TEST(LinkMeshFile, DamagedFilesNeverCrash) {
  DCM_REQUIRE_TEST_DATA();
  const TemporaryFolder folder;
  std::mt19937 dice(7);
  const std::string dae = colladaText("<unit meter=\"0.01\"/>", kTurned + kMirrored);
  const std::string stl =
      readText(testDataFile("robots/panda_description/meshes/collision/finger.stl"));
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 -2 -3\n";
  ::testing::internal::CaptureStderr();
  int refused = 0, read = 0;
  for (int i = 0; i < 600; ++i) {
    std::string text = i % 3 == 0 ? dae : (i % 3 == 1 ? stl : obj);
    for (int flips = 0; flips < 1 + i % 4; ++flips) {
      text[dice() % text.size()] ^= static_cast<char>(1U << (dice() % 8));
    }
    if (i % 5 == 0) text.resize(dice() % text.size());
    const char* name = i % 3 == 0 ? "f.dae" : (i % 3 == 1 ? "f.stl" : "f.obj");
    const std::string refusal = failure(folder.write(name, text));
    EXPECT_EQ(refusal.find("its reader"), std::string::npos) << refusal;  // it died
    refusal.empty() ? ++read : ++refused;
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_GT(read, 50);
  EXPECT_GT(refused, 50);
}

}  // namespace
}  // namespace deformable_contact_monitor
