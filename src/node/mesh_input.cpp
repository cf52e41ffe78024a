// The meshes of one deformable object: which were accepted, and which is the newest at a time.
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

bool MeshInput::jumpsBack(const ros::Time& stamp) const {
  return !stamp.isZero() && !accepted_.empty() &&
         nanosecondsBetween(accepted_.back().stamp(), stamp) > max_age_ns_;
}

bool MeshInput::accept(const ArrivedMesh& mesh, const ros::Time& now) {
  std::string refusal;
  bool out_of_order = false;
  const std::shared_ptr<const Topology> before = topology_;
  try {
    if (mesh.keyframe) learnTopology(*mesh.keyframe);
    checkHeader(*mesh.message, now);
    out_of_order = !accepted_.empty() && mesh.message->header.stamp < accepted_.back().stamp();
    if (!out_of_order) keep(mesh.message);
  } catch (const std::exception& error) {
    refusal = error.what();
    accepted_.clear();
  }
  if (out_of_order) ++counters_.dropped;
  if (!refusal.empty()) ++counters_.refused;
  if (before && topology_ && before != topology_) ++counters_.topology_changes;
  if (!out_of_order) counters_.refusal = refusal;
  if (!accepted_.empty()) counters_.stamp = accepted_.back().stamp();
  return !out_of_order;
}

void MeshInput::checkHeader(const DeformableMesh& message, const ros::Time& now) const {
  if (!isMeshOf(object_, message)) refuse("the mesh is of object '" + message.object + "'");
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

void MeshInput::keep(const DeformableMesh::ConstPtr& message) {
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

void MeshInput::forget() { accepted_.clear(); }

}  // namespace deformable_contact_monitor
