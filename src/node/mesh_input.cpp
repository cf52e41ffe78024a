// The meshes of one deformable object: what arrived, what waits, what was accepted.
#include "node/mesh_input.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/triangle_mesh.h"
#include "node/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMaxAccepted = 32;  // bounds memory; at 60 Hz it is half a second
constexpr double kMaxAheadS = 1;

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

}  // namespace

MeshInput::MeshInput(std::string object, double max_age_s)
    : object_(std::move(object)), max_age_ns_(std::llround(1e9 * max_age_s)) {}

void MeshInput::store(const DeformableMesh::ConstPtr& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counters_.received;
  if (waiting_) ++counters_.dropped;
  waiting_ = message;
  waiting_since_ = std::chrono::steady_clock::now();
  if (!message->triangles.empty() && isOurs(*message)) keyframe_ = message;
}

bool MeshInput::isOurs(const DeformableMesh& message) const {
  return message.object.empty() || message.object == object_;
}

MeshCounters MeshInput::counters() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counters_;
}

std::optional<ros::Time> MeshInput::waitingStamp() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!waiting_) return std::nullopt;
  return waiting_->header.stamp;
}

std::chrono::steady_clock::time_point MeshInput::waitingSince() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return waiting_since_;
}

bool MeshInput::waitingJumpsBack() const {
  const std::optional<ros::Time> stamp = waitingStamp();
  return stamp && !stamp->isZero() && !accepted_.empty() &&
         nanosecondsBetween(accepted_.back().stamp(), *stamp) > max_age_ns_;
}

bool MeshInput::take(const ros::Time& now) {
  DeformableMesh::ConstPtr message, keyframe;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    message.swap(waiting_);
    keyframe.swap(keyframe_);
  }
  if (!message) return false;
  std::string refusal;
  bool out_of_order = false;
  const Topology* const topology = topology_.get();
  try {
    if (keyframe) learnTopology(*keyframe);
    checkHeader(*message, now);
    out_of_order = !accepted_.empty() && message->header.stamp < accepted_.back().stamp();
    if (!out_of_order) accept(message);
  } catch (const std::exception& error) {
    refusal = error.what();
    accepted_.clear();
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (out_of_order) ++counters_.dropped;
  if (!refusal.empty()) ++counters_.refused;
  if (topology != nullptr && topology_ && topology != topology_.get()) ++counters_.topology_changes;
  if (!out_of_order) counters_.refusal = refusal;
  if (!accepted_.empty()) counters_.stamp = accepted_.back().stamp();
  return !out_of_order;
}

void MeshInput::checkHeader(const DeformableMesh& message, const ros::Time& now) const {
  if (!isOurs(message)) refuse("the mesh is of object '" + message.object + "'");
  if (message.header.stamp.isZero()) refuse("header.stamp is zero");
  if (message.header.frame_id.empty()) refuse("header.frame_id is empty");
  const double ahead_s = secondsBetween(message.header.stamp, now);
  if (!now.isZero() && ahead_s > kMaxAheadS) {
    refuse("header.stamp is " + std::to_string(ahead_s) + " s ahead of this machine's clock");
  }
}

// An invalid keyframe takes the old triangles away: publishers count on the new ones.
void MeshInput::learnTopology(const DeformableMesh& keyframe) {
  const std::size_t vertex_count = keyframe.vertices.size() / 3;
  if (topology_ && topology_->id == keyframe.topology_id &&
      topology_->vertex_count == vertex_count && topology_->triangles == keyframe.triangles) {
    return;
  }
  try {
    TriangleMesh mesh{keyframe.vertices, keyframe.triangles};
    validate(mesh, "topology " + std::to_string(keyframe.topology_id));
    topology_ = std::make_shared<const Topology>(
        Topology{keyframe.topology_id, vertex_count, std::move(mesh.triangles)});
    topology_refusal_.clear();
  } catch (const std::invalid_argument& error) {
    topology_ = nullptr;
    topology_refusal_ = error.what();
    throw;
  }
}

void MeshInput::accept(const DeformableMesh::ConstPtr& message) {
  if (!topology_ && !topology_refusal_.empty()) refuse(topology_refusal_);
  if (!topology_ || topology_->id != message->topology_id) {
    refuse("no triangles of topology_id " + std::to_string(message->topology_id) +
           " seen yet; publishers send them on change and at least once a second");
  }
  if (message->vertices.size() != 3 * topology_->vertex_count) {
    refuse(std::to_string(message->vertices.size()) + " vertex coordinates, but topology_id " +
           std::to_string(topology_->id) + " has " + std::to_string(topology_->vertex_count) +
           " vertices");
  }
  if (!accepted_.empty() && accepted_.back().stamp() == message->header.stamp) {
    accepted_.pop_back();
  }
  accepted_.push_back({message, topology_});
  while (accepted_.size() > kMaxAccepted ||
         nanosecondsBetween(message->header.stamp, accepted_.front().stamp()) > max_age_ns_) {
    accepted_.pop_front();
  }
}

const AcceptedMesh* MeshInput::newestAt(const ros::Time& t, std::string* why_not) const {
  const auto found = std::find_if(accepted_.rbegin(), accepted_.rend(),
                                  [&t](const AcceptedMesh& mesh) { return mesh.stamp() <= t; });
  if (found != accepted_.rend() && nanosecondsBetween(t, found->stamp()) <= max_age_ns_)
    return &*found;
  const MeshCounters counters = this->counters();
  if (!counters.refusal.empty()) {
    *why_not = "mesh refused: " + counters.refusal;
  } else if (accepted_.empty()) {
    *why_not = "no mesh yet";
  } else if (found == accepted_.rend()) {
    *why_not = "no mesh as old as this cycle";
  } else {
    *why_not = "newest mesh is " + std::to_string(secondsBetween(t, found->stamp())) + " s old";
  }
  return nullptr;
}

void MeshInput::dropWaiting() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (waiting_) ++counters_.dropped;
  waiting_ = nullptr;
}

void MeshInput::forget() { accepted_.clear(); }

}  // namespace deformable_contact_monitor
