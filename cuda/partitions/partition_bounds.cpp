#include "cuda/partitions/partition_bounds.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/rules/posed_vertex.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostSamples = 1024;
constexpr int kCyclesOfACut = 8;

std::size_t verticesThatTakePart(const Scene& scene) {
  std::size_t count = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (scene.takesPart(id)) count += scene.body(id).mesh.vertexCount();
  }
  return count;
}

}  // namespace

// Vertices of bodies that take part are numbered through; sample k is number k * vertices /
// samples.
void ShareBounds::place(const Scene& scene, std::size_t vertices) {
  std::size_t k = 0, first = 0;
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    const bool identity = body.pose.isIdentity();
    const std::size_t end = first + body.mesh.vertexCount();
    for (; k < samples_.size(); ++k) {
      const std::size_t vertex = k * vertices / samples_.size();
      if (vertex >= end) break;
      const float* const xyz = body.mesh.vertices.data() + 3 * (vertex - first);
      samples_[k].place = posedVertex(body.pose, identity, {xyz[0], xyz[1], xyz[2]});
    }
    first = end;
  }
}

// By how long the shares took in which the samples are.
void ShareBounds::weigh() {
  if (took_ms_.empty()) return;
  const double mean =
      std::accumulate(took_ms_.begin(), took_ms_.end(), 0.0) / static_cast<double>(took_ms_.size());
  for (Sample& sample : samples_) {
    for (std::size_t s = 0; s < shares_.size() && mean > 0; ++s) {
      if (!shares_[s].has(sample.place)) continue;
      // Not all of it at once: what is next to a border is not all that was in the share.
      sample.weight *= std::clamp(std::sqrt(took_ms_[s] / mean), 0.8, 1.25);
      break;
    }
  }
}

// A few far-off vertices count for nothing.
int ShareBounds::widestAxis() const {
  int widest = 0;
  float width = -1;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> along;
    for (const Sample& sample : samples_) {
      if (isFinite(sample.place)) along.push_back(sample.place[axis]);
    }
    if (along.empty()) return 0;
    std::sort(along.begin(), along.end());
    const std::size_t left_out = along.size() / 16;
    const float its = along[along.size() - 1 - left_out] / 2 - along[left_out] / 2;
    if (its > width) {
      width = its;
      widest = axis;
    }
  }
  return widest;
}

const std::vector<SceneShare>& ShareBounds::cut(const Scene& scene, std::size_t count) {
  const std::size_t vertices = verticesThatTakePart(scene);
  const bool another = vertices != vertices_ || count != shares_.size();
  if (!another && ++cycles_ < kCyclesOfACut) return shares_;
  if (another) {
    samples_.assign(std::min(vertices, kMostSamples), Sample());
  } else {
    weigh();
  }
  place(scene, vertices);
  const int axis = another ? widestAxis() : shares_.front().axis;
  vertices_ = vertices;
  cycles_ = 0;
  took_ms_.clear();

  std::vector<std::pair<float, double>> along;  // place and weight
  double sum = 0;
  for (const Sample& sample : samples_) {
    if (!isFinite(sample.place)) continue;
    along.emplace_back(sample.place[axis], sample.weight);
    sum += sample.weight;
  }
  std::sort(along.begin(), along.end());
  shares_.assign(count, SceneShare{axis, -INFINITY, INFINITY});
  std::size_t share = 1;
  double before = 0;
  for (const auto& [where, weight] : along) {
    for (; share < count && before >= sum * static_cast<double>(share) / static_cast<double>(count);
         ++share) {
      shares_[share - 1].high = shares_[share].low = where;
    }
    before += weight;
  }
  // Without samples, or where rounding leaves a bound: nothing is beyond the last of them.
  for (; share < count; ++share) shares_[share - 1].high = shares_[share].low = INFINITY;
  return shares_;
}

void ShareBounds::note(const std::vector<double>& took_ms) {
  if (took_ms_.empty()) took_ms_ = took_ms;
  for (std::size_t s = 0; s < took_ms.size(); ++s) {
    took_ms_[s] = std::min(took_ms_[s], took_ms[s]);
  }
}

}  // namespace deformable_contact_monitor
