// What tests of adapters have in common: meshes, what becomes of them, and why not.
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

namespace deformable_contact_monitor {

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
inline const ros::Time kReceived(50.5);

// The same bits, so that NaN and signs of zeros count.
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
  return PointCloudAdapter(std::make_shared<const TriangleMesh>(faces));
}

template <typename Adapter>
std::string refusalOf(Adapter&& adapter, const typename std::decay_t<Adapter>::Message& message,
                      const ros::Time& received = kReceived) {
  try {
    adapter.adapt(message, received);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

inline void expectIn(const std::string& part, const std::string& all) {
  EXPECT_NE(all.find(part), std::string::npos) << "'" << part << "' is not in: " << all;
}

// What comes of an adapter's meshes beyond the mailbox.
class Accepting {
 public:
  std::shared_ptr<const Topology> accept(const ReceivedMesh& mesh) {
    MeshMailbox mailbox("cloth");
    mailbox.store(mesh);
    EXPECT_EQ(input_.accept(*mailbox.take(), ros::Time()), Acceptance::kAccepted)
        << input_.counters().refusal;
    std::string why_not;
    const AcceptedMesh* const newest = input_.newestAt(mesh.message->header.stamp, &why_not);
    return newest == nullptr ? std::make_shared<const Topology>() : newest->topology;
  }

 private:
  MeshInput input_{"cloth", MeshLimits()};
};

}  // namespace deformable_contact_monitor
