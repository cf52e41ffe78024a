// Tests that the mesh readers read every format bit for bit.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <random>
#include <sstream>

#include "mesh_file_fixture.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
using Indices = std::vector<std::uint32_t>;

std::string format(const char* how, double value) {
  char text[400];
  std::snprintf(text, sizeof text, how, value);
  return text;
}

// 40 vertices of every magnitude, with signed zeros, subnormals and infinities, 60 faces.
TriangleMesh sampleMesh() {
  std::mt19937 random(7);
  TriangleMesh mesh;
  mesh.vertices = {0.0F, -0.0F, 1e-45F, -1e-45F, kInfinity, -kInfinity, 3.4028235e38F, 1.5F, 0.1F};
  while (mesh.vertices.size() < 120) {
    const std::uint32_t bits = random();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    if (std::isfinite(value)) mesh.vertices.push_back(value);
  }
  while (mesh.triangles.size() < 180) mesh.triangles.push_back(random() % 40);
  return mesh;
}

void expectEqual(const TriangleMesh& read, const TriangleMesh& wanted) {
  EXPECT_EQ(bitsOf(read.vertices), bitsOf(wanted.vertices));
  EXPECT_EQ(read.triangles, wanted.triangles);
}

// Every corner a vertex of its own, as STL has it.
TriangleMesh unwelded(const TriangleMesh& mesh) {
  TriangleMesh soup;
  for (const std::uint32_t v : mesh.triangles) {
    soup.triangles.push_back(static_cast<std::uint32_t>(soup.triangles.size()));
    soup.vertices.insert(soup.vertices.end(), &mesh.vertices[3 * v], &mesh.vertices[3 * v] + 3);
  }
  return soup;
}

// Vertices and faces as lines, the same for OBJ and OFF but for what begins them.
std::string lines(const TriangleMesh& mesh, const char* before_vertex, const char* before_face,
                  std::uint32_t first_index) {
  std::string text;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    text += (i % 3 == 0 ? before_vertex : " ") + format("%.9g", mesh.vertices[i]);
    if (i % 3 == 2) text += "\n";
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    text += (i % 3 == 0 ? before_face : " ") + std::to_string(mesh.triangles[i] + first_index);
    if (i % 3 == 2) text += "\n";
  }
  return text;
}

std::string binaryStl(const TriangleMesh& mesh, const std::string& title) {
  std::string text = title;
  text.resize(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.triangleCount());
  text.append(reinterpret_cast<const char*>(&count), 4);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (i % 3 == 0) text += std::string(12, '\x7f');  // a normal that is none
    text.append(reinterpret_cast<const char*>(&mesh.vertices[3 * mesh.triangles[i]]), 12);
    if (i % 3 == 2) text += "\xff\xff";
  }
  return text;
}

std::string asciiStl(const TriangleMesh& mesh) {
  std::string text = "solid a facet of names\n";
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const float* v = &mesh.vertices[3 * mesh.triangles[i]];
    if (i % 3 == 0) text += "  facet normal nan -nan(ind) 1e999\n    outer loop\n";
    text +=
        "      vertex " + format("%.9g ", v[0]) + format("%.9g ", v[1]) + format("%.9g\n", v[2]);
    if (i % 3 == 2) text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid a facet of names\n";
}

TEST_F(MeshFileTest, RoundTripOfTextFormats) {
  const TriangleMesh mesh = sampleMesh();
  expectEqual(read("a.obj", lines(mesh, "v ", "f ", 1)), mesh);
  expectEqual(read("a.OFF", "OFF\n40 60 0\n" + lines(mesh, "", "3 ", 0)), mesh);
  expectEqual(read("a.stl", asciiStl(mesh)), unwelded(mesh));
}

TEST_F(MeshFileTest, CarriageReturns) {
  const TriangleMesh mesh = sampleMesh();
  const std::map<std::string, std::string> files = {
      {"a.obj", lines(mesh, "v ", "f ", 1)},
      {"a.off", "OFF\n40 60 0\n" + lines(mesh, "", "3 ", 0)},
      {"a.stl", asciiStl(mesh)}};
  for (const auto& [name, content] : files) {
    std::string with_cr;
    for (const char c : content) with_cr += c == '\n' ? std::string("\r\n") : std::string(1, c);
    expectEqual(read(name, with_cr), name == "a.stl" ? unwelded(mesh) : mesh);
  }
}

// The size decides, also where the title says "solid".
TEST_F(MeshFileTest, BinaryStl) {
  const TriangleMesh mesh = sampleMesh();
  expectEqual(read("a.stl", binaryStl(mesh, "made by a test")), unwelded(mesh));
  expectEqual(read("b.stl", binaryStl(mesh, "solid part\nfacet")), unwelded(mesh));
}

TEST_F(MeshFileTest, AsciiStlOfSeveralSolidsInCapitals) {
  const std::string one =
      "SOLID\nFACET NORMAL 0 0 1 OUTER LOOP VERTEX 0 0 0 VERTEX 1 0 0 VERTEX 0 1 0 ENDLOOP "
      "ENDFACET\nENDSOLID\n";
  const TriangleMesh mesh = read("a.stl", one + one);
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(mesh.vertices, (std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0,  //
                                               0, 0, 0, 1, 0, 0, 0, 1, 0}));
}

TEST_F(MeshFileTest, ObjStatements) {
  const TriangleMesh mesh = read("a.obj",
                                 "\xEF\xBB\xBF# made \\\n"
                                 "mtllib a.mtl\n"
                                 "f 1 2 3\n"  // before its vertices
                                 "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\n\n"
                                 "v 1 \\\r\n 1 0#corner\n\tv\t0 1 0\n"
                                 "g f 9 9 9\nvt 0 0\nvn 0 0 1\ns off\n"
                                 "f 1/1 2/1 3/1 4/1\n"
                                 "f -4//-1 -3//-1 \\\n-2//-1\n"
                                 "f 4/1/1 3/1/1 2/1/1\n"
                                 "l 1 2\np 1\n"
                                 "f 1 3 4");
  EXPECT_EQ(mesh.vertices, (std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}));
  EXPECT_EQ(mesh.triangles, (Indices{0, 1, 2, 0, 1, 2, 0, 2, 3, 0, 1, 2, 3, 2, 1, 0, 2, 3}));
}

TEST_F(MeshFileTest, OffVariants) {
  const Indices fan = {0, 1, 2, 0, 2, 3};
  const std::string faces = "4 0 1 2 3 255 0 0 # red\n";
  EXPECT_EQ(read("a.off", "OFF 4 1 4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n" + faces).triangles, fan);
  const TriangleMesh mesh = read("b.off",
                                 "# a comment\nCOFF # another\n\n4 1\n"
                                 "0 0 0 1 1 1 1\n# between\n1 0 0 1 1 1 1\n1 1 0 1 1 1 1\n"
                                 "0 1 0 1 1 1 1\n" +
                                     faces);
  EXPECT_EQ(mesh.triangles, fan);
  EXPECT_EQ(mesh.vertices, (std::vector<float>{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}));
}

// Cell by cell, with nothing but std::stringstream.
TriangleMesh naiveObj(const std::string& path) {
  TriangleMesh mesh;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind, a, b, c;
    words >> kind >> a >> b >> c;
    for (const std::string& word : {a, b, c}) {
      if (kind == "v") mesh.vertices.push_back(std::strtof(word.c_str(), nullptr));
      if (kind == "f") mesh.triangles.push_back(static_cast<std::uint32_t>(std::stoul(word) - 1));
    }
  }
  return mesh;
}

TEST_F(MeshFileTest, RealObjFiles) {
  DCM_REQUIRE_TEST_DATA();
  for (const char* name : {"tshirt/000.obj", "tshirt/019.obj", "hard-meshes/self_intersectA.obj"}) {
    const TriangleMesh naive = naiveObj(testDataFile(name));
    ASSERT_GE(naive.triangleCount(), 2745U);
    expectEqual(readMeshFile(testDataFile(name)), naive);
  }
}

std::string contentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// Both files have one layout: x y z, then a byte and three int32 a face.
TEST_F(MeshFileTest, RealPlyFiles) {
  DCM_REQUIRE_TEST_DATA();
  const std::string big = contentOf(testDataFile("cloth-ball/cloth_ball92.ply"));
  const TriangleMesh cloth = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  ASSERT_EQ(cloth.vertexCount(), 46598U);
  ASSERT_EQ(cloth.triangleCount(), 92230U);
  std::string bytes;
  for (const std::uint32_t bits : bitsOf(cloth.vertices)) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(bits >> shift);
  }
  for (std::size_t i = 0; i < cloth.triangles.size(); ++i) {
    if (i % 3 == 0) bytes += '\3';
    for (int shift = 24; shift >= 0; shift -= 8) {
      bytes += static_cast<char>(cloth.triangles[i] >> shift);
    }
  }
  EXPECT_TRUE(big.substr(big.find("end_header\n") + 11) == bytes);

  const std::string little = contentOf(testDataFile("cloth-funnel/227.ply"));
  const TriangleMesh funnel = readMeshFile(testDataFile("cloth-funnel/227.ply"));
  ASSERT_EQ(funnel.vertexCount(), 9450U);
  ASSERT_EQ(funnel.triangleCount(), 18484U);
  const char* at = little.data() + little.find("end_header\n") + 11;
  for (const float coordinate : funnel.vertices) {
    double value = 0;
    std::memcpy(&value, at, sizeof value);
    ASSERT_EQ(coordinate, static_cast<float>(value));
    at += sizeof value;
  }
}

TEST_F(MeshFileTest, RealStlFiles) {
  DCM_REQUIRE_TEST_DATA();
  const std::map<std::string, std::size_t> triangles = {{"40509.stl", 14370},
                                                        {"aatbase_3_binary.stl", 3660},
                                                        {"boxedSphere.stl", 65492},
                                                        {"cap.stl", 4496},
                                                        {"fin0.stl", 26},
                                                        {"fin1.stl", 28},
                                                        {"fin2.stl", 60},
                                                        {"naca0012.stl", 788},
                                                        {"flat_eight_point_star.stl", 16},
                                                        {"sphere.stl", 1280},
                                                        {"sphere_binary.stl", 1280},
                                                        {"tetrahedron.stl", 4},
                                                        {"three_cubes.stl", 36},
                                                        {"two_spheres.stl", 1600},
                                                        {"unit_cube.stl", 12},
                                                        {"unit_sphere.stl", 5120}};
  for (const auto& [name, count] : triangles) {
    EXPECT_EQ(readMeshFile(testDataFile("hard-meshes/" + name)).triangleCount(), count) << name;
  }
  // One mesh twice: the ascii file has six decimals of the binary one's floats.
  const TriangleMesh ascii = readMeshFile(testDataFile("hard-meshes/sphere.stl"));
  const TriangleMesh binary = readMeshFile(testDataFile("hard-meshes/sphere_binary.stl"));
  ASSERT_EQ(ascii.vertices.size(), binary.vertices.size());
  for (std::size_t i = 0; i < ascii.vertices.size(); ++i) {
    ASSERT_NEAR(ascii.vertices[i], binary.vertices[i], 1e-6);
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
