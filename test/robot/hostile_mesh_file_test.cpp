// Mesh files made to do harm: their link is refused with the reason, the others go on.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cstring>

#include "robot/robot_geometry.h"
#include "robot_test_support.h"

namespace deformable_contact_monitor {
namespace {

const std::string kGeometry = "<instance_geometry url=\"#g\"/>";
const std::string kTriangles =
    "<triangles count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
    "offset=\"0\"/><p>0 1 2</p></triangles>";
const std::string kObjVertices = "v 0 0 0\nv 1 0 0\nv 0 2 3\n";

struct Collada {
  std::string nodes = "<node>" + kGeometry + "</node>";  // of the scene
  std::string libraries = "";
  std::string triangles = kTriangles;
  std::string asset = "<asset/>";

  // Returns a COLLADA file with three vertices.
  std::string text() const {
    return "<?xml version=\"1.0\"?><COLLADA "
           "xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">" +
           asset +
           "<library_geometries><geometry id=\"g\"><mesh><source id=\"p\">"
           "<float_array id=\"q\" count=\"9\">0 0 0 1 0 0 0 2 3</float_array><technique_common>"
           "<accessor source=\"#q\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
           "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
           "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
           "source=\"#p\"/></vertices>" +
           triangles + "</mesh></geometry></library_geometries>" + libraries +
           "<library_visual_scenes><visual_scene id=\"s\">" + nodes +
           "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/>"
           "</scene></COLLADA>";
  }
};

std::string instance(const std::string& id) { return "<instance_node url=\"#" + id + "\"/>"; }

// Library nodes n0, n1, ... of which each instances the next so many times, the last the geometry.
std::string chainOfNodes(int count, int instances) {
  std::string nodes;
  for (int i = 0; i < count; ++i) {
    nodes += "<node id=\"n" + std::to_string(i) + "\">";
    for (int k = 0; k < instances; ++k) {
      nodes += i + 1 < count ? instance("n" + std::to_string(i + 1)) : kGeometry;
    }
    nodes += "</node>";
  }
  return "<library_nodes>" + nodes + "</library_nodes>";
}

// A source of so many names or numbers.
std::string source(const std::string& id, const std::string& array, int count, int stride,
                   const std::string& values) {
  return "<source id=\"" + id + "\"><" + array + " id=\"" + id + "a\" count=\"" +
         std::to_string(count * stride) + "\">" + values + "</" + array +
         "><technique_common><accessor source=\"#" + id + "a\" count=\"" + std::to_string(count) +
         "\" stride=\"" + std::to_string(stride) +
         "\"><param name=\"X\" type=\"float\"/></accessor></technique_common></source>";
}

std::string skin(const std::string& id, const std::string& deformed) {
  return "<controller id=\"" + id + "\"><skin source=\"#" + deformed + "\">" +
         source(id + "j", "Name_array", 1, 1, "bone") + source(id + "w", "float_array", 1, 1, "1") +
         source(id + "m", "float_array", 1, 16, "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1") +
         "<joints><input semantic=\"JOINT\" source=\"#" + id +
         "j\"/><input semantic=\"INV_BIND_MATRIX\" source=\"#" + id +
         "m\"/></joints><vertex_weights count=\"3\"><input semantic=\"JOINT\" source=\"#" + id +
         "j\" offset=\"0\"/><input semantic=\"WEIGHT\" source=\"#" + id +
         "w\" offset=\"1\"/><vcount>1 1 1</vcount><v>0 0 0 0 -1 0</v></vertex_weights></skin>"
         "</controller>";
}

class HostileMeshFile : public ::testing::Test {
 protected:
  // Loads a robot of a link with that file and a good one; returns the first.
  LinkGeometry load(const std::string& path) {
    const std::string urdf =
        "<robot name=\"r\"><link name=\"bad\"><collision><geometry><mesh filename=\"" + path +
        "\"/></geometry></collision></link><link name=\"good\"><collision><geometry>"
        "<mesh filename=\"" +
        folder_.write("good.obj", kObjVertices + "f 1 2 3\n") +
        "\"/></geometry></collision></link><joint name=\"j\" type=\"fixed\">"
        "<parent link=\"bad\"/><child link=\"good\"/></joint></robot>";
    const RobotGeometry robot =
        loadRobotGeometry(urdf, {}, [](const std::string& uri) { return uri; });
    EXPECT_EQ(robot.links.size(), 2U);
    EXPECT_EQ(robot.links.back().problem, "");
    EXPECT_EQ(robot.links.back().mesh.triangleCount(), 1U);
    return robot.links.front();
  }

  // Why the link of a file with this text has no geometry.
  std::string refusal(const std::string& name, const std::string& text) {
    const std::string path = folder_.write(name, text);
    return whatIsWrongWith(path);
  }

  std::string whatIsWrongWith(const std::string& path) {
    const LinkGeometry link = load(path);
    EXPECT_EQ(link.mesh.triangleCount(), 0U);
    const std::string start = "link 'bad': " + path + ": " + path + ": ";
    EXPECT_EQ(link.problem.find(start), 0U) << link.problem;
    return link.problem.substr(std::min(start.size(), link.problem.size()));
  }

  // Why a file cannot be read in that time.
  static std::string refusalWithin(std::chrono::milliseconds time, const std::string& path) {
    MeshReading reading;
    reading.file_time = time;
    try {
      readLinkMeshFile(path, reading);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "it was read";
  }

  // The triangle, if all is well.
  void expectTheTriangle(const std::string& name, const std::string& text) {
    const LinkGeometry link = load(folder_.write(name, text));
    EXPECT_EQ(link.problem, "");
    EXPECT_EQ(link.mesh.triangleCount(), 1U);
  }

  std::string refusalOfTriangles(const std::string& triangles) {
    Collada collada;
    collada.triangles = triangles;
    return refusal("t.dae", collada.text());
  }

  const TemporaryFolder folder_;
};

// Assimp would take 1 m for a length that it cannot read.
TEST_F(HostileMeshFile, AUnitThatIsNoLength) {
  Collada collada;
  for (const std::string meter : {" 0.001 ", "", "0", "-1", "mm", "0,001", "nan"}) {
    collada.asset = "<asset><unit meter=\"" + meter + "\"/></asset>";
    EXPECT_NE(refusal("t.dae", collada.text()).find("is no length above 0"), std::string::npos)
        << meter;
  }
  for (const std::string unit : {"<unit/>", "<unit meter=\"1e-3\"/>", "<unit meter=\"2.5\"/>"}) {
    collada.asset = "<asset>" + unit + "</asset>";
    expectTheTriangle("t.dae", collada.text());
  }
}

// Assimp crashes there.
TEST_F(HostileMeshFile, ANodeThatSkews) {
  Collada collada;
  collada.nodes = "<node><skew>30 1 0 0 0 1 0</skew>" + kGeometry + "</node>";
  EXPECT_NE(refusal("t.dae", collada.text()).find("<skew> is not supported"), std::string::npos);
}

// Assimp follows such nodes until its stack overflows. The reader process crashes, and its parent
// says so.
TEST_F(HostileMeshFile, ANodeThatInstancesItself) {
  Collada collada;
  collada.nodes = "<node id=\"a\">" + kGeometry + instance("a") + "</node>";
  EXPECT_NE(refusal("t.dae", collada.text()), "");
}

TEST_F(HostileMeshFile, ANodeThatInstancesWhatItIsIn) {
  Collada collada;
  collada.nodes = "<node id=\"a\">" + kGeometry + "<node>" + instance("a") + "</node></node>";
  EXPECT_NE(refusal("t.dae", collada.text()), "");
  // Assimp takes names where there is no such id.
  collada.nodes = "<node name=\"a\">" + kGeometry + "<node>" + instance("a") + "</node></node>";
  EXPECT_NE(refusal("t.dae", collada.text()), "");
}

TEST_F(HostileMeshFile, NodesThatInstanceEachOther) {
  Collada collada;
  collada.nodes = "<node>" + instance("a") + "</node>";
  collada.libraries = "<library_nodes><node id=\"a\">" + instance("b") + "</node><node id=\"b\">" +
                      instance("a") + kGeometry + "</node></library_nodes>";
  EXPECT_NE(refusal("t.dae", collada.text()), "");
}

TEST_F(HostileMeshFile, InstancesOfInstances) {
  Collada collada;
  collada.nodes = "<node>" + instance("n0") + "</node>";
  collada.libraries = chainOfNodes(10, 10);
  ASSERT_LT(collada.text().size(), 5000U);
  EXPECT_NE(refusal("t.dae", collada.text()), "");  // 10^10 nodes
  collada.libraries = chainOfNodes(100'000, 1);
  EXPECT_NE(refusal("t.dae", collada.text()), "");
}

TEST_F(HostileMeshFile, InstancesWithinReasonAreRead) {
  Collada collada;
  collada.nodes = "<node>" + instance("n0") + "</node><node>" + instance("n1") + "</node>";
  collada.libraries = chainOfNodes(4, 5);
  const LinkGeometry link = load(folder_.write("t.dae", collada.text()));
  EXPECT_EQ(link.problem, "");
  EXPECT_EQ(link.mesh.triangleCount(), 5U * 5 * 5 * 5 + 5 * 5 * 5);
  // Nodes of the library go before others of that name, or even of that id.
  for (const std::string name : {"name", "id"}) {
    collada.nodes = "<node " + name + "=\"a\">" + instance("a") + "</node>";
    collada.libraries = "<library_nodes><node id=\"a\">" + kGeometry + "</node></library_nodes>";
    expectTheTriangle("u.dae", collada.text());
  }
}

// Assimp follows such skins for ever, until its time is over.
TEST_F(HostileMeshFile, SkinsThatDeformThemselves) {
  Collada collada;
  collada.nodes = "<node><instance_controller url=\"#c\"/></node>";
  for (const std::string& skins : {skin("c", "c"), skin("c", "d") + skin("d", "c")}) {
    collada.libraries = "<library_controllers>" + skins + "</library_controllers>";
    const std::string path = folder_.write("t.dae", collada.text());
    EXPECT_EQ(refusalWithin(std::chrono::milliseconds(300), path),
              path + ": takes longer than 0.3 s to read");
  }
  collada.libraries = "<library_controllers>" + skin("c", "g") + "</library_controllers>";
  expectTheTriangle("u.dae", collada.text());
}

TEST_F(HostileMeshFile, ColladaIndicesThatAreNone) {
  for (const std::string index :
       {"-2", "-1", "2147483648", "4294967295", "4294967297", "18446744073709551617"}) {
    std::string triangles = kTriangles;
    triangles.replace(triangles.find("0 1 2"), 5, "0 1 " + index);
    EXPECT_EQ(refusalOfTriangles(triangles), "line 1: <p> holds " + index + ", which is no index");
  }
  std::string triangles = kTriangles;
  triangles.replace(triangles.find("0 1 2"), 5, "0 1 3");  // of three
  EXPECT_NE(refusalOfTriangles(triangles), "");
  const auto polygon = [](const std::string& count) {
    return "<polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><vcount>" +
           count + "</vcount><p>0 1 2</p></polylist>";
  };
  for (const std::string count : {"-3", "+3", "4294967299"}) {
    EXPECT_EQ(refusalOfTriangles(polygon(count)),
              "line 1: <vcount> holds " + count + ", which is no index");
  }
  Collada collada;
  collada.triangles = polygon("3");
  expectTheTriangle("u.dae", collada.text());
}

TEST_F(HostileMeshFile, ObjIndicesThatAreNone) {
  for (const std::string index :
       {"4294967299", "4294967295", "18446744073709551619", "2147483649", "0", "-4"}) {
    EXPECT_EQ(refusal("t.obj", kObjVertices + "f 1 2 " + index + "\n"),
              "line 4: vertex index '" + index +
                  "' is out of range; there are 3 vertices up to here, the first is 1");
  }
  EXPECT_EQ(refusal("t.obj", kObjVertices + "f 1 2 4\n"),
            "line 4: the face refers to vertex 4, but there are 3 vertices");
  EXPECT_EQ(refusal("t.obj", kObjVertices + "f 1 2 1.5\n"),
            "line 4: a vertex index expected, but there is '1.5'");
  EXPECT_EQ(refusal("t.obj", kObjVertices + "  f 1/1 2/1 \\\r\n99999999999/1").find("line 5: "),
            0U);
  expectTheTriangle("u.obj", "# 4294967299\no 4294967299\n" + kObjVertices + "f 1 2 -1\n");
}

TEST_F(HostileMeshFile, AFaceOfManyCorners) {
  constexpr int kCorners = 600'000;
  std::string face = "f";
  for (int i = 0; i < kCorners; ++i) face += " " + std::to_string(i % 3 + 1);
  const auto expectAFan = [](const LinkGeometry& link) {
    EXPECT_EQ(link.problem, "");
    EXPECT_EQ(link.mesh.triangleCount(), kCorners - 2U);
    ASSERT_EQ(link.notes.size(), 1U);
    EXPECT_NE(link.notes[0].find("cross themselves"), std::string::npos);
  };
  expectAFan(load(folder_.write("t.obj", kObjVertices + face + "\n")));
  std::string polygon =
      "<polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
      "offset=\"0\"/><vcount>600000</vcount><p>";
  for (int i = 0; i < kCorners; ++i) polygon += std::to_string(i % 3) + " ";
  Collada collada;
  collada.triangles = polygon + "</p></polylist>";
  expectAFan(load(folder_.write("t.dae", collada.text())));
}

// The file has few nodes, but their instances add up to 16 million triangles.
TEST_F(HostileMeshFile, MoreTrianglesThanFit) {
  Collada collada;
  collada.nodes = "<node>" + instance("n0") + "</node>";
  collada.libraries = chainOfNodes(3, 20);
  collada.triangles =
      "<triangles count=\"2000\"><input semantic=\"VERTEX\" source=\"#v\" "
      "offset=\"0\"/><p>";
  for (int i = 0; i < 2000; ++i) collada.triangles += "0 1 2 ";
  collada.triangles += "</p></triangles>";
  const std::string path = folder_.write("t.dae", collada.text());
  // A slow build on a busy machine needs more than the usual time.
  EXPECT_EQ(refusalWithin(std::chrono::hours(1), path),
            path + ": more than 256 MiB of vertices and triangles");
}

TEST_F(HostileMeshFile, MoreMemoryThanThereIs) {
  std::string triangles = kTriangles;
  triangles.replace(triangles.find("\"1\""), 3, "\"1000000000\"");
  const std::string refused = refusalOfTriangles(triangles);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  EXPECT_NE(refused, "");  // without that limit, the count is wrong
#else
  EXPECT_EQ(refused, "takes more than 2048 MiB of memory to read");
#endif
}

TEST_F(HostileMeshFile, OnlyTheFileItselfIsOpened) {
  const std::string fifo = (folder_.path() / "fifo").string();
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  for (const std::string& other : {fifo, std::string("fifo"), std::string("/dev/zero")}) {
    expectTheTriangle("t.obj", "mtllib " + other + "\n" + kObjVertices + "usemtl m\nf 1 2 3\n");
    Collada collada;
    collada.libraries = "<library_images><image id=\"i\"><init_from>" + other +
                        "</init_from></image></library_images>";
    expectTheTriangle("t.dae", collada.text());
  }
}

TEST_F(HostileMeshFile, WhatIsNoRegularFileIsNotOpened) {
  const auto path = [&](const std::string& name) { return (folder_.path() / name).string(); };
  for (const std::string name : {"f.stl", "f.dae", "f.obj"}) {
    ASSERT_EQ(mkfifo(path(name).c_str(), 0600), 0);
    EXPECT_EQ(whatIsWrongWith(path(name)), "is not a regular file, but a FIFO");
  }
  std::filesystem::create_symlink("/dev/zero", path("zero.stl"));
  EXPECT_EQ(whatIsWrongWith(path("zero.stl")), "is not a regular file, but a device");
  const int end = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path("s.stl").c_str(), sizeof(address.sun_path) - 1);
  ASSERT_EQ(bind(end, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  EXPECT_EQ(whatIsWrongWith(path("s.stl")), "is not a regular file, but a socket");
  close(end);
  std::filesystem::create_directory(path("d.stl"));
  EXPECT_EQ(whatIsWrongWith(path("d.stl")), "is not a regular file, but a folder");
}

TEST_F(HostileMeshFile, AFileLargerThanIsRead) {
  const std::string path = folder_.write("sparse.stl", "solid");
  std::filesystem::resize_file(path, std::uintmax_t{1} << 40);
  EXPECT_EQ(whatIsWrongWith(path), "is larger than 512 MiB");
}

}  // namespace
}  // namespace deformable_contact_monitor
