// Writes the scenes that measure_trade's figures are of, as far as they are no files already, into
// a folder: the Panda's links, posed; states of a cloth that sinks onto them; a huge floor
// triangle.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

#include "core/mesh_files/mesh_file.h"
#include "core/predicates/triangle.h"
#include "core/rules/posed_vertex.h"
#include "panda_scene.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/output_file.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kStates = 20;

// In the scene frame.
void writeOff(const std::filesystem::path& file, const TriangleMesh& mesh,
              const RigidTransform& pose) {
  std::string text = "OFF\n" + std::to_string(mesh.vertexCount()) + " " +
                     std::to_string(mesh.triangleCount()) + " 0\n";
  char line[100];
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    const float* x = &mesh.vertices[i];
    const Vec3f v = apply(pose, {x[0], x[1], x[2]});
    std::snprintf(line, sizeof line, "%.9g %.9g %.9g\n", v.x, v.y, v.z);
    text += line;
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    std::snprintf(line, sizeof line, "3 %u %u %u\n", mesh.triangles[i], mesh.triangles[i + 1],
                  mesh.triangles[i + 2]);
    text += line;
  }
  OutputFile(file.string()).write(text);
}

void writePanda(const std::filesystem::path& folder) {
  const Scene scene = pandaAndCloth();
  for (BodyId id = 1; id < scene.bodyCount(); ++id) {
    const Body& link = scene.body(id);
    writeOff(folder / (link.name + ".off"), link.mesh, link.pose);
  }
  for (int i = 0; i < kStates; ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "cloth_%02d.off", i);
    const float height = 1.2F - 0.03F * static_cast<float>(i);  // above all links to the elbow
    writeOff(folder / name, clothGrid(87, 1.2F, height, 0.12F), scene.body(0).pose);
  }
}

// Under cloth_ball92, through its lowest vertices.
void writeFloor(const std::filesystem::path& file) {
  const TriangleMesh cloth = readMeshFile(testDataFile("cloth-ball/cloth_ball92.ply"));
  const auto [least, most] = std::minmax_element(cloth.vertices.begin(), cloth.vertices.end());
  const float size = 50 * (*most - *least);
  float low = *most;
  for (std::size_t i = 1; i < cloth.vertices.size(); i += 3) low = std::min(low, cloth.vertices[i]);
  low += 0.01F * (*most - *least);
  writeOff(file, meshOf({{{{-size, low, -size}, {size, low, -size}, {0, low, size}}}}),
           RigidTransform());
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  if (argc != 2) {
    std::fputs("usage: trade_scene_files FOLDER\n", stderr);
    return 2;
  }
  return dcm::runTool("trade_scene_files", [argv] {
    const std::filesystem::path folder = argv[1];
    std::filesystem::create_directories(folder / "panda");
    dcm::writePanda(folder / "panda");
    dcm::writeFloor(folder / "floor.off");
    return 0;
  });
}
