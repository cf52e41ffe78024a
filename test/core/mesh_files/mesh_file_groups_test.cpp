// Tests which triangles the groups of mesh files have.
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "mesh_file_fixture.h"

namespace deformable_contact_monitor {
namespace {

using Names = std::vector<std::string>;
using Groups = std::vector<TriangleRanges>;

class MeshFileGroups : public MeshFileTest {
 protected:
  static Groups groupsOf(const std::string& file, const Names& names) {
    Groups groups(7);  // what it had is replaced
    const TriangleMesh mesh = readMeshGroups(file, names, &groups);
    const TriangleMesh plain = readMeshFile(file);
    EXPECT_EQ(mesh.vertices, plain.vertices);
    EXPECT_EQ(mesh.triangles, plain.triangles);
    return groups;
  }

  // Returns the message without the path.
  static std::string refusalOf(const std::string& file, const Names& names) {
    try {
      Groups groups;
      readMeshGroups(file, names, &groups);
    } catch (const std::runtime_error& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.compare(0, file.size() + 2, file + ": "), 0) << text;
      return text.substr(file.size() + 2);
    }
    ADD_FAILURE() << file << " was read";
    return "";
  }
};

constexpr char kCorners[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\n";

TEST_F(MeshFileGroups, OfAnObjFileGoOnToTheNextLineOfTheirKind) {
  const std::string file = write("a.obj", std::string("f 1 2 3\n") + kCorners +
                                              "o cloth\ng hem left\nf 1 2 3 4\nf 2 3 5\n"
                                              "g right right  # a comment\nf 1 2 5\n"
                                              "o table\nf 3 4 5\ng hem\nf 1 3 5\ng\nf 1 4 5\n");
  EXPECT_EQ(groupsOf(file, {"hem", "left", "right", "cloth", "table"}),
            (Groups{{{1, 3}, {6, 6}}, {{1, 3}}, {{4, 5}}, {{1, 4}}, {{5, 7}}}));
  EXPECT_EQ(groupsOf(file, {"left", "left"}), (Groups{{{1, 3}}, {{1, 3}}}));
  EXPECT_EQ(groupsOf(file, {}), Groups());
}

TEST_F(MeshFileGroups, AFaceIsOnceInAGroupThatIsAnObjectToo) {
  const std::string file =
      write("a.obj", std::string(kCorners) + "o hem\ng hem\nf 1 2 3\nf 1 2 4\ng\nf 1 2 5\n");
  EXPECT_EQ(groupsOf(file, {"hem"}), (Groups{{{0, 2}}}));
}

TEST_F(MeshFileGroups, UnknownAndEmptyOnesAreRefusedByName) {
  const std::string file =
      write("a.obj", std::string(kCorners) + "g hem\nf 1 2 3\ng none\ng \x1b[1m\nf 1 2 4\n");
  EXPECT_EQ(refusalOf(file, {"hem", "ham"}), "has no group 'ham'; it has 'hem', 'none', '?[1m'");
  EXPECT_EQ(refusalOf(file, {"none"}), "group 'none' has no triangle");
  std::string many = kCorners;
  for (int i = 0; i < 1000; ++i) many += "g part" + std::to_string(i) + "\nf 1 2 3\n";
  const std::string refused = refusalOf(write("b.obj", many), {"part1000"});
  EXPECT_NE(refused.find("'part9', others"), std::string::npos) << refused;
  EXPECT_LT(refused.size(), 200U);
  const std::string off = write("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  EXPECT_EQ(refusalOf(off, {"hem"}), "has no group 'hem'; it has none");
  EXPECT_EQ(groupsOf(off, {}), Groups());
}

constexpr char kGroupsHead[] =
    "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\n"
    "property float y\nproperty float z\n";
constexpr char kPlyFaces[] = "element face 4\nproperty list uchar int vertex_indices\n";

TEST_F(MeshFileGroups, OfAPlyFileAreFacesWithAValue) {
  const std::string file =
      write("a.ply", std::string(kGroupsHead) +
                         "element face 4\nproperty int label\nproperty list uchar int "
                         "vertex_indices\nproperty double weight\nend_header\n"
                         "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 1\n"
                         "2 4 0 1 2 3 0.5\n-1 3 1 2 4 7\n2 3 0 1 4 7\n3 3 0 3 4 nan\n");
  EXPECT_EQ(groupsOf(file, {"label=2", "label=-1", "label=3", "weight=7"}),
            (Groups{{{0, 1}, {3, 3}}, {{2, 2}}, {{4, 4}}, {{2, 3}}}));
  for (const char* name : {"label", "label=", "label=2.0", "label=x", "=2", "x=0", "label=16777216",
                           "vertex_indices=3", "weight=99999999999"}) {
    EXPECT_EQ(refusalOf(file, {name}),
              std::string("has no group '") + name + "'; it has 'label=VALUE', 'weight=VALUE'");
  }
  EXPECT_EQ(refusalOf(file, {"label=4"}), "group 'label=4' has no triangle");
  EXPECT_EQ(refusalOf(file, {"weight=0"}), "group 'weight=0' has no triangle");
}

TEST_F(MeshFileGroups, OfVerticesAreTrianglesWithAllThree) {
  const std::string faces_first =
      std::string("ply\nformat ascii 1.0\n") + kPlyFaces +
      "element vertex 5\nproperty float x\nproperty float y\nproperty float z\n"
      "property float part\nend_header\n4 0 1 2 3\n3 1 2 4\n3 0 3 4\n3 2 1 0\n"
      "0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 0\n2 0 1 nan\n";
  const std::string file = write("a.ply", faces_first);
  EXPECT_EQ(groupsOf(file, {"part=1"}), (Groups{{{0, 0}, {4, 4}}}));
  EXPECT_EQ(refusalOf(file, {"part=0"}), "group 'part=0' has no triangle");
}

TEST_F(MeshFileGroups, AFacesPropertyGoesBeforeAVertexsOfThatName) {
  const std::string file = write(
      "a.ply", std::string(kGroupsHead) + "property uchar part\n" + kPlyFaces +
                   "property uchar part\nend_header\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n2 0 1 1\n"
                   "3 0 1 2 5\n3 1 2 4 1\n3 0 1 4 5\n3 0 3 4 6\n");
  EXPECT_EQ(groupsOf(file, {"part=1", "part=5"}), (Groups{{{1, 1}}, {{0, 0}, {2, 2}}}));
}

TEST_F(MeshFileGroups, OfABinaryFileToo) {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
      "property float y\nproperty float z\nelement face 2\nproperty short part\n"
      "property list uchar uchar vertex_indices\nend_header\n";
  bytes += std::string(36, '\0') + std::string("\x02\x01\x03\x00\x01\x02", 6) +
           std::string("\xFF\xFF\x03\x02\x01\x00", 6);
  const std::string file = write("a.ply", bytes);
  EXPECT_EQ(groupsOf(file, {"part=258", "part=-1"}), (Groups{{{0, 0}}, {{1, 1}}}));
  // Counts are compared with the file's size, whoever asks.
  bytes.replace(bytes.find("vertex 3"), 8, "vertex 999999999");
  EXPECT_NE(refusalOf(write("b.ply", bytes), {"part=1"}).find("too short"), std::string::npos);
}

}  // namespace
}  // namespace deformable_contact_monitor
