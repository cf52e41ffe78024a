// Computes the bounds of the partitions from weighted samples of the vertices. The samples are
// sorted along the axis, and each partition gets an equal part of their total weight. A sample's
// weight estimates the time that a device spends on the material around it.
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

// Sets the places of all samples in the scene frame [m]. The vertices of bodies that take part are
// numbered consecutively; sample k is vertex k * vertices / samples.
void PartitionBounds::place(const Scene& scene, std::size_t vertices) {
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

// Multiplies each sample's weight by a factor that grows with the time that its partition took.
// Samples keep their weights while they move, so the bounds follow slow material.
void PartitionBounds::weigh() {
  if (took_ms_.empty()) return;
  const double mean =
      std::accumulate(took_ms_.begin(), took_ms_.end(), 0.0) / static_cast<double>(took_ms_.size());
  for (Sample& sample : samples_) {
    for (std::size_t s = 0; s < partitions_.size() && mean > 0; ++s) {
      if (!partitions_[s].has(sample.place)) continue;
      // Applies only part of the correction. Material near a bound may take less time than the rest
      // of its partition does, so a full correction could move the bound too far.
      sample.weight *= std::clamp(std::sqrt(took_ms_[s] / mean), 0.8, 1.25);
      break;
    }
  }
  // Where no bound can divide the costly material, weights would go apart for ever, and the bounds
  // could not follow it any more.
  constexpr double kMost = 256;
  double sum = 0;
  for (const Sample& sample : samples_) sum += sample.weight;
  const double scale = static_cast<double>(samples_.size()) / sum;
  for (Sample& sample : samples_) {
    sample.weight = std::clamp(sample.weight * scale, 1 / kMost, kMost);
  }
}

// Returns the axis along which the samples spread widest. It ignores the outermost sixteenth at
// either end, so that a few far-off vertices do not decide.
int PartitionBounds::widestAxis() const {
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

const std::vector<ScenePartition>& PartitionBounds::cut(const Scene& scene, std::size_t count) {
  const std::size_t vertices = verticesThatTakePart(scene);
  const bool another = vertices != vertices_ || count != partitions_.size();
  if (!another && ++cycles_ < kCyclesOfACut) return partitions_;
  if (another) {
    samples_.assign(std::min(vertices, kMostSamples), Sample());
  } else {
    weigh();
  }
  place(scene, vertices);
  const int axis = another ? widestAxis() : partitions_.front().axis;
  vertices_ = vertices;
  cycles_ = 0;
  took_ms_.clear();

  std::vector<std::pair<float, double>> along;  // place on the axis [m], weight
  double sum = 0;
  for (const Sample& sample : samples_) {
    if (!isFinite(sample.place)) continue;
    along.emplace_back(sample.place[axis], sample.weight);
    sum += sample.weight;
  }
  std::sort(along.begin(), along.end());
  partitions_.assign(count, ScenePartition{axis, -INFINITY, INFINITY});
  std::size_t partition = 1;
  double before = 0;
  for (const auto& [where, weight] : along) {
    for (; partition < count &&
           before >= sum * static_cast<double>(partition) / static_cast<double>(count);
         ++partition) {
      partitions_[partition - 1].high = partitions_[partition].low = where;
    }
    before += weight;
  }
  // Bounds that are left have no sample beyond them. This happens without samples, or when rounding
  // leaves the last bound open. Their partitions are empty.
  for (; partition < count; ++partition)
    partitions_[partition - 1].high = partitions_[partition].low = INFINITY;
  return partitions_;
}

// Keeps the shortest time of each partition since the last cut, because single cycles may be slow
// for other reasons.
void PartitionBounds::note(const std::vector<double>& took_ms) {
  if (took_ms_.empty()) took_ms_ = took_ms;
  for (std::size_t s = 0; s < took_ms.size(); ++s) {
    took_ms_[s] = std::min(took_ms_[s], took_ms[s]);
  }
}

}  // namespace deformable_contact_monitor
