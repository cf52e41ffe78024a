// Prints what KittenGpuLBVH, a tree of boxes made anew in each cycle, takes for scenes of
// cuda_benchmark, and which of its contacts are wrong. The tree finds pairs of boxes. A plain test
// in double precision, as its users write it, tells which pairs are contacts.
#include <cuda_runtime.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh_file.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/check.cuh"
#include "layered_cloth.h"
#include "lbvh.cuh"
#include "moving_scene.h"
#include "run_benchmark.h"
#include "scenes.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kWarmUp = 20, kRepeats = 60;
constexpr unsigned kThreads = 128;
constexpr std::size_t kMostPairs = 20000000;  // of boxes

// Device memory of `count` items.
template <class T>
class Items {
 public:
  explicit Items(std::size_t count) {
    checkCuda(cudaMalloc(&data_, count * sizeof(T)), "cudaMalloc");
  }
  explicit Items(const std::vector<T>& from) : Items(from.size()) { send(from); }
  ~Items() { cudaFree(data_); }
  Items(const Items&) = delete;
  Items& operator=(const Items&) = delete;

  void send(const std::vector<T>& from) {
    checkCuda(cudaMemcpy(data_, from.data(), from.size() * sizeof(T), cudaMemcpyHostToDevice),
              "cudaMemcpy to the device");
  }
  std::vector<T> fetch(std::size_t count) const {
    std::vector<T> to(count);
    checkCuda(cudaMemcpy(to.data(), data_, count * sizeof(T), cudaMemcpyDeviceToHost),
              "cudaMemcpy to the host");
    return to;
  }
  T* data() const { return data_; }

 private:
  T* data_ = nullptr;
};

struct Corners {
  double3 at[3];
};

// A mesh on the device.
struct MeshView {
  const float* vertices;
  const std::uint32_t* triangles;

  __device__ Corners corners(std::uint32_t triangle) const {
    Corners c;
    for (int k = 0; k < 3; ++k) {
      const float* const v = vertices + 3 * std::size_t{triangles[3 * triangle + k]};
      c.at[k] = make_double3(v[0], v[1], v[2]);
    }
    return c;
  }
};

// Makes the triangles' boxes, each larger by `pad_m` on all sides. The tree loses boxes that only
// touch.
__global__ void makeBoxes(MeshView mesh, std::uint32_t count, float pad_m,
                          Kitten::LBVH::aabb* boxes) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  Kitten::LBVH::aabb box;
  for (int k = 0; k < 3; ++k) {
    const float* const v = mesh.vertices + 3 * std::size_t{mesh.triangles[3 * i + k]};
    box.absorb(glm::vec3(v[0], v[1], v[2]));
  }
  box.pad(pad_m);
  boxes[i] = box;
}

// Returns six times the signed volume of a tetrahedron.
__device__ double volume(const double3& a, const double3& b, const double3& c, const double3& d) {
  const double ux = a.x - d.x, uy = a.y - d.y, uz = a.z - d.z;
  const double vx = b.x - d.x, vy = b.y - d.y, vz = b.z - d.z;
  const double wx = c.x - d.x, wy = c.y - d.y, wz = c.z - d.z;
  return ux * (vy * wz - vz * wy) + uy * (vz * wx - vx * wz) + uz * (vx * wy - vy * wx);
}

__device__ bool haveOneSign(double a, double b, double c) {
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

// Returns whether the segment meets the triangle. A segment in the triangle's plane does not.
__device__ bool crosses(const double3& p, const double3& q, const Corners& t) {
  const double from = volume(t.at[0], t.at[1], t.at[2], p);
  const double to = volume(t.at[0], t.at[1], t.at[2], q);
  if (from * to > 0 || (from == 0 && to == 0)) return false;
  return haveOneSign(volume(p, q, t.at[0], t.at[1]), volume(p, q, t.at[1], t.at[2]),
                     volume(p, q, t.at[2], t.at[0]));
}

// Returns whether a point, or an edge of one triangle, meets the other one in the plane without
// axis `dropped`.
__device__ bool meetInPlane(const Corners& a, const Corners& b, int dropped) {
  const auto turn = [dropped](const double3& p, const double3& q, const double3& r) {
    if (dropped == 0) return (q.y - p.y) * (r.z - p.z) - (q.z - p.z) * (r.y - p.y);
    if (dropped == 1) return (q.z - p.z) * (r.x - p.x) - (q.x - p.x) * (r.z - p.z);
    return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
  };
  for (int i = 0; i < 9; ++i) {
    const double3 &p = a.at[i / 3], &q = a.at[(i / 3 + 1) % 3];
    const double3 &r = b.at[i % 3], &s = b.at[(i % 3 + 1) % 3];
    if (turn(p, q, r) * turn(p, q, s) <= 0 && turn(r, s, p) * turn(r, s, q) <= 0) return true;
  }
  const auto inside = [&turn](const double3& p, const Corners& t) {
    return haveOneSign(turn(t.at[0], t.at[1], p), turn(t.at[1], t.at[2], p),
                       turn(t.at[2], t.at[0], p));
  };
  return inside(a.at[0], b) || inside(b.at[0], a);
}

__device__ bool areCoplanar(const Corners& a, const Corners& b) {
  for (int k = 0; k < 3; ++k) {
    if (volume(a.at[0], a.at[1], a.at[2], b.at[k]) != 0) return false;
  }
  return true;
}

// Returns the axis along which the triangle's normal is longest.
__device__ int longestAxis(const Corners& t) {
  const double ux = t.at[1].x - t.at[0].x, uy = t.at[1].y - t.at[0].y, uz = t.at[1].z - t.at[0].z;
  const double vx = t.at[2].x - t.at[0].x, vy = t.at[2].y - t.at[0].y, vz = t.at[2].z - t.at[0].z;
  const double x = fabs(uy * vz - uz * vy), y = fabs(uz * vx - ux * vz);
  const double z = fabs(ux * vy - uy * vx);
  if (x >= y && x >= z) return 0;
  return y >= z ? 1 : 2;
}

__device__ bool meet(const Corners& a, const Corners& b) {
  if (areCoplanar(a, b)) return meetInPlane(a, b, longestAxis(a));
  for (int k = 0; k < 3; ++k) {
    if (crosses(a.at[k], a.at[(k + 1) % 3], b)) return true;
    if (crosses(b.at[k], b.at[(k + 1) % 3], a)) return true;
  }
  return false;
}

// Lists the contacts among `count` pairs of boxes. If both meshes are one (`self`), pairs that
// share a vertex are left out.
__global__ void listContacts(MeshView first, MeshView second, bool self, const glm::ivec2* pairs,
                             std::uint32_t count, std::uint32_t* contact_count, uint2* contacts) {
  const std::uint32_t i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const std::uint32_t a = pairs[i].x, b = pairs[i].y;
  for (int k = 0; self && k < 9; ++k) {
    if (first.triangles[3 * a + k / 3] == second.triangles[3 * b + k % 3]) return;
  }
  if (!meet(first.corners(a), second.corners(b))) return;
  contacts[atomicAdd(contact_count, 1U)] = make_uint2(a, b);
}

unsigned blocksFor(std::size_t items) {
  return static_cast<unsigned>((items + kThreads - 1) / kThreads);
}

// A body's mesh, its boxes and their tree.
class Tree {
 public:
  Tree(const TriangleMesh& mesh, float pad_m)
      : count_(mesh.triangleCount()),
        pad_m_(pad_m),
        vertices_(mesh.vertices),
        triangles_(mesh.triangles),
        boxes_(count_) {}

  void send(const std::vector<float>& vertices) { vertices_.send(vertices); }
  void make() {
    makeBoxes<<<blocksFor(count_), kThreads>>>(view(), static_cast<std::uint32_t>(count_), pad_m_,
                                               boxes_.data());
    tree_.compute(boxes_.data(), count_);
  }
  MeshView view() const { return {vertices_.data(), triangles_.data()}; }
  Kitten::LBVH& tree() { return tree_; }

 private:
  std::size_t count_;
  float pad_m_;
  Items<float> vertices_;
  Items<std::uint32_t> triangles_;
  Items<Kitten::LBVH::aabb> boxes_;
  Kitten::LBVH tree_;
};

// The rival on a scene of one body with itself, or of two bodies.
class Rival {
 public:
  Rival(const Scene& scene, float pad_m)
      : first_(scene.body(0).mesh, pad_m), pairs_(kMostPairs), contacts_(kMostPairs), counter_(1) {
    if (scene.bodyCount() > 1) second_ = std::make_unique<Tree>(scene.body(1).mesh, pad_m);
  }

  // Returns the time of a cycle [ms], from vertices on the device to the count on the host.
  double cycle(const std::vector<float>& vertices) {
    first_.send(vertices);
    checkCuda(cudaDeviceSynchronize(), "cudaDeviceSynchronize");
    const auto start = std::chrono::steady_clock::now();
    first_.make();
    if (second_ != nullptr) second_->make();
    box_pairs_ = second_ != nullptr
                     ? first_.tree().query(pairs_.data(), kMostPairs, &second_->tree())
                     : first_.tree().query(pairs_.data(), kMostPairs);
    if (box_pairs_ == kMostPairs) throw std::runtime_error("the rival's list of pairs is full");
    checkCuda(cudaMemset(counter_.data(), 0, sizeof(std::uint32_t)), "cudaMemset");
    if (box_pairs_ > 0) {
      const MeshView other = second_ != nullptr ? second_->view() : first_.view();
      listContacts<<<blocksFor(box_pairs_), kThreads>>>(
          first_.view(), other, second_ == nullptr, pairs_.data(),
          static_cast<std::uint32_t>(box_pairs_), counter_.data(), contacts_.data());
    }
    contact_count_ = counter_.fetch(1)[0];
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
        .count();
  }
  std::size_t boxPairs() const { return box_pairs_; }
  // Returns the contacts of the last cycle, in ascending order.
  std::vector<TrianglePair> contacts() const {
    std::vector<TrianglePair> list;
    for (const uint2& pair : contacts_.fetch(contact_count_)) {
      if (second_ != nullptr) {
        list.push_back({0, pair.x, 1, pair.y});
      } else {
        list.push_back({0, std::min(pair.x, pair.y), 0, std::max(pair.x, pair.y)});
      }
    }
    std::sort(list.begin(), list.end());
    return list;
  }

 private:
  Tree first_;
  std::unique_ptr<Tree> second_;
  Items<glm::ivec2> pairs_;
  Items<uint2> contacts_;
  Items<std::uint32_t> counter_;
  std::size_t box_pairs_ = 0, contact_count_ = 0;
};

// Returns how many pairs of `some` are not in `others`. Both are in ascending order.
std::size_t notIn(const std::vector<TrianglePair>& some, const std::vector<TrianglePair>& others) {
  std::vector<TrianglePair> rest;
  std::set_difference(some.begin(), some.end(), others.begin(), others.end(),
                      std::back_inserter(rest));
  return rest.size();
}

// Returns what `cycle` says of each second cycle, those of the state that is named. The last cycle
// is one of them.
template <class Cycle>
std::vector<double> times(const Cycle& cycle) {
  std::vector<double> list;
  for (int i = 1; i <= kWarmUp + 2 * kRepeats; ++i) {
    const double ms = cycle(i);
    if (i > kWarmUp && i % 2 == 0) list.push_back(ms);
  }
  return list;
}

// `pad_m` goes to makeBoxes().
void compare(MovingScene moving, float pad_m = 0) {
  Options options;
  options.adjacent = AdjacentPairs::kSkip;
  const auto detector = makeCudaDetector();
  moving.scene.useMemory(detector->vertexMemory());
  const std::vector<double> ours = times([&](int i) {
    moving.show(i);
    return detector->detect(moving.scene, options).detect_ms;
  });
  Rival rival(moving.scene, pad_m);
  const std::vector<double> rivals = times([&](int i) { return rival.cycle(moving.state[i % 2]); });
  const std::vector<TrianglePair> exact = detector->detect(moving.scene, options).contacts;
  const std::vector<TrianglePair> found = rival.contacts();
  std::printf("| %s | %.3f | %zu | %.3f | %zu | %zu | %zu | %zu |\n", moving.name.c_str(),
              median(ours), exact.size(), median(rivals), rival.boxPairs(), found.size(),
              notIn(found, exact), notIn(exact, found));
  std::fflush(stdout);
}

MovingScene selfMoving(const std::string& name, const TriangleMesh& a, const TriangleMesh& b) {
  return {name, selfScene(a), {a.vertices, b.vertices}};
}

int run() {
  const auto read = [](const char* file) { return readMeshFile(testDataFile(file)); };
  const TriangleMesh ball92 = read("cloth-ball/cloth_ball92.ply");
  const TriangleMesh ball93 = read("cloth-ball/cloth_ball93.ply");
  std::printf(
      "| scene | ours: detect ms | contacts | rival: ms | pairs of boxes | its contacts | false | "
      "missed |\n|---|---|---|---|---|---|---|---|\n");
  compare(selfMoving("cloth_ball92", ball92, ball93));
  compare(selfMoving("cloth_ball93", ball93, ball92));
  compare(
      selfMoving("cloth-funnel 227", read("cloth-funnel/227.ply"), read("cloth-funnel/228.ply")));
  compare(
      selfMoving("cloth_ball92 split 3 x 3", splitThreeByThree(ball92), splitThreeByThree(ball93)));
  constexpr float kTouching = 1e-6F;
  compare(layeredCloths(), kTouching);
  compare({"cloth_ball92 twice, at one place",
           pairScene(ball92, ball92),
           {ball92.vertices, ball93.vertices}},
          kTouching);
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() {
  return deformable_contact_monitor::runBenchmark("lbvh_rival", deformable_contact_monitor::run);
}
