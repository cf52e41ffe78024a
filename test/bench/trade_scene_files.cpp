// Writes the scenes that measure_trade's figures are of, as far as they are no files already, into
// a folder: the Panda's links, posed; states of a cloth that sinks onto them, of one of a million
// triangles, of a T-shirt; the PR2's links and a blanket that sinks onto its arms; a huge floor
// triangle; two soups that all but touch everywhere; what the cloth simulations' files hold, its
// largest part and the rest.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "core/analysis/mesh_components.h"
#include "core/mesh_file.h"
#include "core/predicates/triangle.h"
#include "core/rules/posed_vertex.h"
#include "robot_scenes.h"
#include "scenes.h"
#include "test_data.h"
#include "tools/common/output_file.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kStates = 20;

// The vertices are in the scene frame.
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

// A file of one of several states.
std::filesystem::path numbered(const std::filesystem::path& folder, const char* name, int number) {
  char text[40];
  std::snprintf(text, sizeof text, "%s_%02d.off", name, number);
  return folder / text;
}

// All but body 0.
void writeRobot(const std::filesystem::path& folder, const Scene& scene) {
  std::filesystem::create_directories(folder);
  for (BodyId id = 1; id < scene.bodyCount(); ++id) {
    const Body& link = scene.body(id);
    writeOff(folder / (link.name + ".off"), link.mesh, link.pose);
  }
}

void writePanda(const std::filesystem::path& folder) {
  const Scene scene = pandaAndCloth();
  writeRobot(folder, scene);
  for (int i = 0; i < kStates; ++i) {
    const float height = 1.2F - 0.03F * static_cast<float>(i);  // above all links to the elbow
    writeOff(numbered(folder, "cloth", i), clothGrid(87, 1.2F, height, 0.12F), scene.body(0).pose);
  }
}

void writePr2(const std::filesystem::path& folder) {
  for (int i = 0; i < kStates; ++i) {
    const Scene scene = pr2AndBlanket(0.95F - 0.015F * static_cast<float>(i));
    if (i == 0) writeRobot(folder, scene);
    const Body& blanket = scene.body(0);
    writeOff(numbered(folder, "blanket", i), blanket.mesh, blanket.pose);
  }
}

// 999 698 triangles.
void writeMillion(const std::filesystem::path& folder) {
  const RigidTransform pose = pandaAndCloth(1).body(0).pose;
  for (int i = 0; i < 4; ++i) {
    const float height = 0.95F - 0.1F * static_cast<float>(i);
    writeOff(numbered(folder, "million", i), clothGrid(707, 1.2F, height, 0.12F), pose);
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

// States of the T-shirt, 0.7 m long, that sink onto the Panda's hand and elbow.
void writeShirts(const std::filesystem::path& folder) {
  constexpr float kLengthM = 0.7F;
  const RigidTransform pose = pandaAndCloth(1).body(0).pose;
  std::array<float, 3> least, most;
  for (int i = 0; i < kStates; ++i) {
    char name[40];
    std::snprintf(name, sizeof name, "tshirt/%03d.obj", i);
    TriangleMesh mesh = readMeshFile(testDataFile(name));
    for (int axis = 0; axis < 3 && i == 0; ++axis) {
      least[axis] = most[axis] = mesh.vertices[axis];
      for (std::size_t v = axis; v < mesh.vertices.size(); v += 3) {
        least[axis] = std::min(least[axis], mesh.vertices[v]);
        most[axis] = std::max(most[axis], mesh.vertices[v]);
      }
    }
    const float size = std::max({most[0] - least[0], most[1] - least[1], most[2] - least[2]});
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const std::size_t axis = v % 3;
      mesh.vertices[v] = (mesh.vertices[v] - (least[axis] + most[axis]) / 2) * (kLengthM / size);
      mesh.vertices[v] += axis == 2 ? 1.2F - 0.03F * static_cast<float>(i) : 0.65F;
    }
    writeOff(numbered(folder, "shirt", i), mesh, pose);
  }
}

void writeSoups(const std::filesystem::path& folder) {
  constexpr int kLayers = 25, kInLayer = 160;
  for (const int along : {0, 1}) {
    const TriangleMesh soup = sliverSoup(along, kLayers, kInLayer, 1e-4F);
    const char* const name = along == 0 ? "soup_x.off" : "soup_y.off";
    writeOff(folder / name, soup, RigidTransform());
  }
}

// The largest part of each state; what else the first holds stands still.
void writeParts(const std::filesystem::path& folder, const std::string& name,
                const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    Scene scene;
    scene.addBody(file, readMeshFile(testDataFile(file)));
    BodyComponents parts;
    parts.update(scene.body(0), noLimit());
    const MeshComponents& of = parts.get();
    std::uint32_t largest = 0;
    for (std::uint32_t c = 0; c < of.count(); ++c) {
      if (of.first[c + 1] - of.first[c] > of.first[largest + 1] - of.first[largest]) largest = c;
    }
    TriangleMesh cloth = scene.body(0).mesh, rest = cloth;
    cloth.triangles.clear();
    rest.triangles.clear();
    for (std::size_t t = 0; t < of.of_triangle.size(); ++t) {
      const auto* const corners = &scene.body(0).mesh.triangles[3 * t];
      auto& part = of.of_triangle[t] == largest ? cloth.triangles : rest.triangles;
      part.insert(part.end(), corners, corners + 3);
    }
    const std::string stem = std::filesystem::path(file).stem().string();
    writeOff(folder / (name + "_cloth_" + stem + ".off"), cloth, RigidTransform());
    if (file != files.front() || rest.triangles.empty()) continue;
    writeOff(folder / (name + "_rest.off"), rest, RigidTransform());
  }
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
    dcm::writePanda(folder / "panda");
    dcm::writePr2(folder / "pr2");
    dcm::writeFloor(folder / "floor.off");
    dcm::writeMillion(folder);
    dcm::writeShirts(folder / "panda");
    dcm::writeSoups(folder);
    dcm::writeParts(folder, "ball", {"cloth-ball/cloth_ball92.ply", "cloth-ball/cloth_ball93.ply"});
    dcm::writeParts(folder, "funnel", {"cloth-funnel/227.ply", "cloth-funnel/228.ply"});
    return 0;
  });
}
