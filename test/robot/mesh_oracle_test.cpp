// Every mesh of the real robots against geometric_shapes, which MoveIt reads them with.
#include <geometric_shapes/mesh_operations.h>
#include <geometric_shapes/shapes.h>

#include <memory>
#include <set>

#include "robot/link_mesh_files.h"
#include "robot_test_support.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

std::vector<Corners> cornersOf(const shapes::Mesh& mesh) {
  std::vector<Corners> corners;
  const auto vertex = [&](unsigned i) {
    const double* v = &mesh.vertices[3 * std::size_t{mesh.triangles[i]}];
    return Eigen::Vector3d(v[0], v[1], v[2]);
  };
  for (unsigned i = 0; i < 3 * mesh.triangle_count; i += 3) {
    corners.push_back({vertex(i), vertex(i + 1), vertex(i + 2)});
  }
  return corners;
}

TEST(MeshOracle, EveryMeshOfTheRobotsIsWhatMoveItSees) {
  DCM_REQUIRE_TEST_DATA();
  std::set<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(testDataFile("robots"))) {
    const std::string ending = entry.path().extension().string();
    if (ending == ".stl" || ending == ".STL" || ending == ".dae") files.insert(entry.path());
  }
  ASSERT_GT(files.size(), 60U);
  int compared = 0;
  for (const std::string& file : files) {
    SCOPED_TRACE(file);
    const std::unique_ptr<shapes::Mesh> oracle(
        shapes::createMeshFromResource("file://" + std::filesystem::canonical(file).string()));
    if (!oracle) {
      EXPECT_THROW(readLinkMeshFile(file), std::runtime_error);
      continue;
    }
    ++compared;
    EXPECT_TRUE(sameTriangles(cornersOf(*oracle), cornersOf(readLinkMeshFile(file)), 2e-6));
  }
  EXPECT_GT(compared, 60);
}

}  // namespace
}  // namespace deformable_contact_monitor
