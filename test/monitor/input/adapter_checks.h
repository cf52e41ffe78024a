// Meshes and checks that the tests of adapters share.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "mesh_messages.h"
#include "monitor/input/mesh_adapters.h"
#include "monitor/input/mesh_input.h"
#include "refusal.h"

namespace deformable_contact_monitor {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline const ros::Time kReceived(50.5);

// Returns the bits of floats, so that NaN and the signs of zeros are compared as well.
inline std::vector<std::uint32_t> bitsOf(const std::vector<float>& values) {
  std::vector<std::uint32_t> bits(values.size());
  if (!values.empty()) std::memcpy(bits.data(), values.data(), 4 * values.size());
  return bits;
}

inline TriangleMesh randomMesh(std::mt19937* random) {
  TriangleMesh mesh;
  const std::size_t vertices = 3 * (2 + (*random)() % 10);  // rows of 3 are possible
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    std::uint32_t bits = (*random)();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    mesh.vertices.push_back(std::isnan(value) ? kNan : value);
  }
  mesh.vertices[(*random)() % mesh.vertices.size()] = kInfinity;
  mesh.vertices[(*random)() % mesh.vertices.size()] = -0.0F;
  for (std::size_t left = 1 + (*random)() % 20; left > 0; --left) {
    for (int corner = 0; corner < 3; ++corner) mesh.triangles.push_back((*random)() % vertices);
  }
  return mesh;
}

inline void expectSame(const DeformableMesh& message, const TriangleMesh& mesh) {
  EXPECT_EQ(bitsOf(message.vertices), bitsOf(mesh.vertices));
  EXPECT_EQ(message.triangles, mesh.triangles);
}

inline TriangleMesh square() { return {{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, {0, 1, 2, 1, 3, 2}}; }

inline PointCloudAdapter cloudAdapter(const TriangleMesh& faces) {
  return PointCloudAdapter(std::make_shared<const PointTriangles>(trianglesOf(faces)));
}

template <typename Adapter>
std::string refusalOf(Adapter&& adapter, const typename std::decay_t<Adapter>::Message& message,
                      const ros::Time& received = kReceived) {
  try {
    return adapter.adapt(message, received).problem;
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

// Accepts an adapter's meshes, and returns their triangles.
class Accepting {
 public:
  std::shared_ptr<const Topology> accept(IncomingMesh mesh) {
    input_.store(mesh);
    EXPECT_EQ(input_.take(ros::Time(), &mesh), Acceptance::kAccepted) << mesh.problem;
    return mesh.topology != nullptr ? mesh.topology : std::make_shared<const Topology>();
  }

 private:
  MeshInput input_{"cloth", MeshLimits()};
};

}  // namespace deformable_contact_monitor
