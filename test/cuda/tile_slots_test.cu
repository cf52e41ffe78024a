// The triangles by tiles on the device: each has one slot, in a tile of its body, beside what lies
// near.
#include <gtest/gtest.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/tiling.h"
#include "cuda/memory/device_scene.cuh"
#include "device_test.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

class TileSlots : public DeviceTest {};

// A body that takes part by contacts with itself.
void add(Scene* scene, TriangleMesh mesh) {
  const BodyId id = scene->addBody("body", std::move(mesh));
  scene->setPairEnabled(id, id, true);
}

// One detector's scene on the device.
class OnDevice {
 public:
  void send(const Scene& scene) {
    device_scene_.layOut(scene, Motion::kInstant, false);
    device_scene_.sendLayout(scene, stream_.get());
    HostCopies copies(stream_.get());
    device_scene_.sendVertices(scene, Motion::kInstant, copies, stream_.get());
    device_scene_.sendBodies(scene, Options(), SceneScale(), copies);
    copies.launch();
    device_scene_.makeTiles(stream_.get());
    device_scene_.makeTilesAgain(stream_.get());
    numbers_ = fetch(arrays_.scene.slot_numbers.data(), std::size_t{kWarp} * tileCount());
    slots_.clear();
    for (const uint4& of_slot : numbers_) slots_.push_back(TriangleIndex(of_slot.w));
    neighbours_ = fetch(arrays_.scene.slot_neighbours.data(), std::size_t{kWarp} * tileCount());
    bodies_ = fetch(arrays_.scene.tile_body.data(), tileCount());
  }

  std::uint32_t tileCount() const { return arrays_.scene.tile_count; }
  // Triangles of the scene, 32 to a tile; kNone where there is none.
  const std::vector<TriangleIndex>& slots() const { return slots_; }
  // The same with the numbers of their vertices.
  const std::vector<uint4>& numbers() const { return numbers_; }
  const std::vector<std::uint32_t>& neighbours() const { return neighbours_; }
  const std::vector<BodyIndex>& bodies() const { return bodies_; }

 private:
  template <class T>
  std::vector<T> fetch(const T* from, std::size_t count) {
    std::vector<T> to(count, T{});
    checkCuda(
        cudaMemcpyAsync(to.data(), from, count * sizeof(T), cudaMemcpyDeviceToHost, stream_.get()),
        "cudaMemcpyAsync to the host");
    stream_.synchronise();
    return to;
  }

  CudaStream stream_;
  DeviceMemory memory_;
  CycleSizes sizes_;
  CycleArrays arrays_{memory_};
  DeviceScene device_scene_{0, memory_, sizes_, arrays_.scene};
  std::vector<uint4> numbers_;
  std::vector<TriangleIndex> slots_;
  std::vector<std::uint32_t> neighbours_;
  std::vector<BodyIndex> bodies_;
};

bool shareVertex(const TriangleMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const std::uint32_t* const of_a = &mesh.triangles[3 * std::size_t{a}];
  const std::uint32_t* const of_b = &mesh.triangles[3 * std::size_t{b}];
  return std::find_first_of(of_a, of_a + 3, of_b, of_b + 3) != of_a + 3;
}

// The slots of a tile whose triangles share a vertex number, for each slot that has a triangle.
// `first_triangle`: the first one of the body, whose mesh is given.
void expectNeighbours(const TriangleMesh& mesh, const OnDevice& found, std::size_t first_slot,
                      std::uint32_t first_triangle) {
  const TriangleIndex* const slots = &found.slots()[first_slot];
  for (unsigned i = 0; i < kWarp && slots[i].value != kNone; ++i) {
    std::uint32_t expected = 0;
    for (unsigned k = 0; k < kWarp && slots[k].value != kNone; ++k) {
      const std::uint32_t a = slots[i].value - first_triangle, b = slots[k].value - first_triangle;
      if (shareVertex(mesh, a, b)) expected |= 1U << k;
    }
    ASSERT_EQ(found.neighbours()[first_slot + i], expected) << "slot " << first_slot + i;
  }
}

// The numbers of the vertices of each slot's triangle. `first_vertex`: the first one of the body.
void expectNumbers(const TriangleMesh& mesh, const OnDevice& found, std::size_t first_slot,
                   std::uint32_t first_triangle, std::uint32_t first_vertex) {
  for (unsigned i = 0; i < kWarp; ++i) {
    const uint4& of_slot = found.numbers()[first_slot + i];
    const bool there = of_slot.w != kNone;
    const std::uint32_t* const of_mesh =
        there ? &mesh.triangles[3 * std::size_t{of_slot.w - first_triangle}] : nullptr;
    const auto expected = [&](int k) { return there ? first_vertex + of_mesh[k] : 0; };
    ASSERT_EQ(of_slot.x, expected(0));
    ASSERT_EQ(of_slot.y, expected(1));
    ASSERT_EQ(of_slot.z, expected(2));
  }
}

// Each triangle of each body that takes part in one slot of a tile of that body, of which all but
// one are full; and the neighbours and vertices of each slot.
void expectWhole(const Scene& scene, const OnDevice& found) {
  std::uint32_t body = 0, first_triangle = 0, first_vertex = 0, tile = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const auto count = static_cast<std::uint32_t>(scene.body(id).mesh.triangleCount());
    const std::uint32_t tiles = (count + kWarp - 1) / kWarp;
    ASSERT_LE(tile + tiles, found.tileCount());
    std::vector<std::uint32_t> in_slots, expected(count);
    for (std::uint32_t i = 0; i < tiles; ++i) ASSERT_EQ(found.bodies()[tile + i].value, body);
    for (std::uint32_t i = 0; i < tiles * kWarp; ++i) {
      const std::uint32_t t = found.slots()[tile * kWarp + i].value;
      ASSERT_EQ(t == kNone, i >= count) << "slot " << i << " of body " << id;
      if (t != kNone) in_slots.push_back(t - first_triangle);
    }
    std::sort(in_slots.begin(), in_slots.end());
    for (std::uint32_t t = 0; t < count; ++t) expected[t] = t;
    ASSERT_EQ(in_slots, expected) << "body " << id;
    for (std::uint32_t i = 0; i < tiles; ++i) {
      const std::size_t first_slot = std::size_t{kWarp} * (tile + i);
      const TriangleMesh& mesh = scene.body(id).mesh;
      ASSERT_NO_FATAL_FAILURE(expectNeighbours(mesh, found, first_slot, first_triangle));
      ASSERT_NO_FATAL_FAILURE(expectNumbers(mesh, found, first_slot, first_triangle, first_vertex));
    }
    tile += tiles;
    first_triangle += count;
    first_vertex += static_cast<std::uint32_t>(scene.body(id).mesh.vertexCount());
    ++body;
  }
  ASSERT_EQ(tile, found.tileCount());
}

TriangleMesh soup(std::uint32_t seed, std::uint32_t triangles, float most) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> any(-1, 1);
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 9 * triangles; ++i) mesh.vertices.push_back(most * any(random));
  for (std::uint32_t i = 0; i < 3 * triangles; ++i) mesh.triangles.push_back(i);
  return mesh;
}

TEST_F(TileSlots, HaveEachTriangleOfBodiesOfAnySizeOnce) {
  if (!hasDevice()) return;
  for (const std::uint32_t size :
       {1U, 31U, 32U, 33U, 63U, 65U, 1024U, 2047U, 2048U, 2049U, 2081U, 5000U, 70000U}) {
    Scene scene;
    for (const std::uint32_t triangles : {size, 1U, 0U, 33U, size}) {
      add(&scene, soup(size, triangles, 1));
    }
    add(&scene, sizedTo(clothGrid(50, 1, 0, 0.1F), size));
    OnDevice found;
    found.send(scene);
    ASSERT_NO_FATAL_FAILURE(expectWhole(scene, found)) << size;
  }
}

TEST_F(TileSlots, HaveEachTriangleOnceWhereverItsVerticesAre) {
  if (!hasDevice()) return;
  constexpr std::uint32_t kTriangles = 3000;
  Scene scene;
  add(&scene, soup(1, kTriangles, 0));             // all at one place
  add(&scene, soup(2, kTriangles, FLT_MAX));       // farther apart than a float32 can say
  add(&scene, soup(3, kTriangles, FLT_TRUE_MIN));  // nearer than a quotient can
  TriangleMesh some = soup(4, kTriangles, 1), none = some;
  const float strange[] = {INFINITY, -INFINITY, NAN};
  for (std::size_t i = 0; i < some.vertices.size(); i += 7) some.vertices[i] = strange[i % 3];
  for (float& x : none.vertices) x = NAN;
  add(&scene, some);
  add(&scene, none);
  OnDevice found;
  found.send(scene);
  expectWhole(scene, found);
}

TEST_F(TileSlots, FollowBodiesThatComeAndGoAndChange) {
  if (!hasDevice()) return;
  std::mt19937 random(5);
  Scene scene;
  OnDevice found;
  add(&scene, soup(0, 100, 1));
  for (std::uint32_t step = 1; step <= 200; ++step) {
    const BodyId id = random() % scene.bodyCount();
    const std::uint32_t size = random() % 2 == 0 ? random() % 70 : random() % 5000;
    if (random() % 4 == 0 && scene.bodyCount() < 12) {
      add(&scene, soup(step, size, 1));
    } else if (random() % 3 == 0) {
      scene.setPairEnabled(id, id, !scene.pairEnabled(id, id));
    } else {
      scene.setMesh(id, soup(step, size, 1));
    }
    found.send(scene);
    ASSERT_NO_FATAL_FAILURE(expectWhole(scene, found)) << "step " << step;
  }
}

// Returns the tiles of a scene of this body alone.
std::vector<std::uint32_t> slotsOf(const TriangleMesh& mesh) {
  Scene scene;
  add(&scene, mesh);
  OnDevice found;
  found.send(scene);
  expectWhole(scene, found);
  std::vector<std::uint32_t> slots;
  for (const TriangleIndex t : found.slots()) slots.push_back(t.value);
  return slots;
}

// How many pairs of tiles have boxes that meet.
std::size_t meetingTiles(const TriangleMesh& mesh, const std::vector<std::uint32_t>& slots) {
  std::vector<Aabb> boxes;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    if (i % kWarp == 0) boxes.emplace_back();
    for (std::size_t k = 0; slots[i] != kNone && k < 3; ++k) {
      boxes.back().include(mesh.vertex(mesh.triangles[3 * std::size_t{slots[i]} + k]));
    }
  }
  std::size_t meeting = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) meeting += intersects(boxes[i], boxes[j]) ? 1 : 0;
  }
  return meeting;
}

// Tiles by the host's rule are all full but the last, as these are. With a vertex far off, whose
// triangles' tiles meet any.
TEST_F(TileSlots, AreNotMuchWorseThanTheHosts) {
  if (!hasDevice()) return;
  for (const int side : {20, 40, 100}) {  // of less than a chunk, more, many
    TriangleMesh mesh = clothGrid(side, 1, 0, 0);
    for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
      mesh.vertices[i + 2] = 0.2F * std::sin(9 * mesh.vertices[i]);
    }
    // Numbers that say nothing of where triangles are.
    std::mt19937 random(6);
    for (std::size_t t = mesh.triangleCount() - 1; t > 0; --t) {
      const std::size_t other = random() % (t + 1);
      for (int k = 0; k < 3; ++k) {
        std::swap(mesh.triangles[3 * t + k], mesh.triangles[3 * other + k]);
      }
    }
    const std::size_t on_host = meetingTiles(mesh, tilingByPosition(mesh).triangle);
    EXPECT_LE(meetingTiles(mesh, slotsOf(mesh)), 1.3 * static_cast<double>(on_host)) << side;
    mesh.vertices[0] = 1e30F;
    const std::size_t each = 6 * (mesh.triangleCount() / kWarp + 1);  // around a vertex of a grid
    EXPECT_LE(meetingTiles(mesh, slotsOf(mesh)), 1.3 * static_cast<double>(on_host + each)) << side;
  }
}

// A strip that winds itself up: what lay side by side lies in layers then.
TEST_F(TileSlots, AreMadeAnewWhenABodyHasBeenDeformedForAWhile) {
  if (!hasDevice()) return;
  TriangleMesh mesh = clothGrid(60, 1, 0, 0);
  Scene scene;
  add(&scene, mesh);
  OnDevice found;
  found.send(scene);
  const std::vector<TriangleIndex> before = found.slots();
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    float* const v = &mesh.vertices[i];
    const float angle = 40 * v[0], radius = 0.1F + 0.02F * angle;
    v[0] = radius * std::cos(angle);
    v[2] = radius * std::sin(angle);
  }
  for (std::uint32_t cycle = 1; cycle < DeviceScene::kCyclesOfTiles; ++cycle) {
    scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
    found.send(scene);
    ASSERT_EQ(found.slots(), before) << cycle;
    found.send(scene);  // as it is: no cycle more
  }
  scene.setVertices(0, mesh.vertices.data(), mesh.vertexCount());
  found.send(scene);
  expectWhole(scene, found);
  std::vector<std::uint32_t> then, now;
  for (const TriangleIndex t : before) then.push_back(t.value);
  for (const TriangleIndex t : found.slots()) now.push_back(t.value);
  EXPECT_LT(meetingTiles(mesh, now), meetingTiles(mesh, then));
}

}  // namespace
}  // namespace deformable_contact_monitor
