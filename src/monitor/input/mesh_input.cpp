// The meshes of one deformable object: which were accepted, and which is the newest at a time.
#include "monitor/input/mesh_input.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/triangle_mesh.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMaxAccepted = 32;  // bounds memory; at 60 Hz it is half a second
constexpr double kMaxAheadS = 1;

std::size_t byteCount(const DeformableMesh& message) {
  return sizeof(float) * message.vertices.size() + sizeof(std::uint32_t) * message.triangles.size();
}

[[noreturn]] void refuse(const std::string& what) { throw std::invalid_argument(what); }

}  // namespace

MeshInput::MeshInput(std::string object, const MeshLimits& limits)
    : object_(std::move(object)),
      max_age_ns_(std::llround(1e9 * limits.max_age_s)),
      history_bytes_(limits.history_bytes) {}

Acceptance MeshInput::accept(const ArrivedMesh& mesh, const ros::Time& now) {
  const std::shared_ptr<const Topology> before = topology_;
  Acceptance answer = Acceptance::kDropped;
  try {
    if (mesh.keyframe) learnTopology(*mesh.keyframe);
    if (!mesh.refusal.empty()) refuse(mesh.refusal);
    checkHeader(*mesh.message);
    if (!isOutdated(mesh.message->header.stamp, now)) {
      checkAge(mesh.message->header.stamp, now);
      checkTopology(*mesh.message);
      answer = keep(mesh.message) ? Acceptance::kJumped : Acceptance::kAccepted;
    }
    if (answer != Acceptance::kDropped) counters_.refusal.clear();
  } catch (const std::exception& error) {
    counters_.refusal = error.what();
    accepted_.clear();
    answer = Acceptance::kRefused;
  }
  counters_.dropped += answer == Acceptance::kDropped;
  counters_.refused += answer == Acceptance::kRefused;
  counters_.jumps += answer == Acceptance::kJumped;
  if (before && topology_ && before != topology_) ++counters_.topology_changes;
  if (!accepted_.empty()) counters_.stamp = accepted_.back().stamp();
  return answer;
}

bool MeshInput::isOld(const ros::Time& stamp, const ros::Time& now) const {
  return !now.isZero() && nanosecondsBetween(now, stamp) > max_age_ns_;
}

// Whether a mesh of that stamp says nothing that the newest accepted one does not say better.
bool MeshInput::isOutdated(const ros::Time& stamp, const ros::Time& now) const {
  if (accepted_.empty()) return false;
  const ros::Time& newest = accepted_.back().stamp();
  if (stamp >= newest || isOld(newest, now)) return false;
  return nanosecondsBetween(newest, stamp) <= max_age_ns_ || isOld(stamp, now);
}

void MeshInput::checkHeader(const DeformableMesh& message) const {
  if (!isMeshOf(object_, message)) refuse("the mesh is of object '" + message.object + "'");
  if (message.header.stamp.isZero()) refuse("header.stamp is zero");
  if (message.header.frame_id.empty()) refuse("header.frame_id is empty");
}

void MeshInput::checkAge(const ros::Time& stamp, const ros::Time& now) const {
  if (now.isZero()) return;
  const double ahead_s = secondsBetween(stamp, now);
  if (ahead_s > kMaxAheadS) {
    refuse("header.stamp is " + std::to_string(ahead_s) + " s ahead of this machine's clock");
  }
  if (isOld(stamp, now)) {
    refuse("header.stamp is " + std::to_string(-ahead_s) +
           " s old, and max_mesh_age_s less; a bag needs /clock and use_sim_time");
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
    validate({keyframe.vertices, keyframe.triangles},
             "topology " + std::to_string(keyframe.topology_id));
    topology_ = std::make_shared<const Topology>(
        Topology{keyframe.topology_id, vertex_count, keyframe.triangles});
    refused_topology_.reset();
  } catch (const std::invalid_argument& error) {
    topology_ = nullptr;
    refused_topology_ = {keyframe.topology_id, error.what()};
    throw;
  }
}

void MeshInput::checkTopology(const DeformableMesh& message) const {
  if (refused_topology_ && refused_topology_->id == message.topology_id) {
    refuse(refused_topology_->why);
  }
  if (!topology_ || topology_->id != message.topology_id) {
    refuse("no triangles of topology_id " + std::to_string(message.topology_id) +
           " seen yet; publishers send them on change and at least once a second");
  }
  if (message.vertices.size() != 3 * topology_->vertex_count) {
    refuse(std::to_string(message.vertices.size()) + " vertex coordinates, but topology_id " +
           std::to_string(topology_->id) + " has " + std::to_string(topology_->vertex_count) +
           " vertices");
  }
}

// Returns whether stamps jumped back, so that what was kept is forgotten.
bool MeshInput::keep(const DeformableMesh::ConstPtr& message) {
  const ros::Time& stamp = message->header.stamp;
  const bool jumped = !accepted_.empty() && stamp < accepted_.back().stamp();
  if (jumped) accepted_.clear();
  if (!accepted_.empty() && accepted_.back().stamp() == stamp) accepted_.pop_back();
  accepted_.push_back({message, topology_});
  std::size_t bytes = 0;
  for (const AcceptedMesh& mesh : accepted_) bytes += byteCount(*mesh.message);
  while (accepted_.size() > 1 &&
         (accepted_.size() > kMaxAccepted || bytes > history_bytes_ ||
          nanosecondsBetween(stamp, accepted_.front().stamp()) > max_age_ns_)) {
    bytes -= byteCount(*accepted_.front().message);
    accepted_.pop_front();
  }
  return jumped;
}

const AcceptedMesh* MeshInput::newestAt(const ros::Time& t, std::string* why_not) const {
  const auto found = std::find_if(accepted_.rbegin(), accepted_.rend(),
                                  [&t](const AcceptedMesh& mesh) { return mesh.stamp() <= t; });
  if (found != accepted_.rend() && nanosecondsBetween(t, found->stamp()) <= max_age_ns_)
    return &*found;
  if (!counters_.refusal.empty()) {
    *why_not = "mesh refused: " + counters_.refusal;
  } else if (accepted_.empty()) {
    *why_not = "no mesh yet";
  } else if (found == accepted_.rend()) {
    *why_not = "no mesh as old as this cycle";
  } else {
    *why_not = "newest mesh is " + std::to_string(secondsBetween(t, found->stamp())) + " s old";
  }
  return nullptr;
}

bool MeshInput::has(const ros::Time& stamp) const {
  return std::any_of(accepted_.begin(), accepted_.end(),
                     [&stamp](const AcceptedMesh& mesh) { return mesh.stamp() == stamp; });
}

void MeshInput::forget() { accepted_.clear(); }

}  // namespace deformable_contact_monitor
