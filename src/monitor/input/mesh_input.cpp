// The input of one deformable object. store() runs in the thread of the subscription's callback;
// all checks run in take(), in the detection thread.
#include "monitor/input/mesh_input.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <utility>

#include "core/triangle_mesh.h"
#include "monitor/input/usable_stamp.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// So many meshes are kept. They bound memory; at 60 Hz, the most are half a second. The least are
// those that may wait for late transforms.
constexpr std::size_t kLeastAccepted = 4, kMaxAccepted = 32;

// Returns the bytes that keeping a mesh costs.
std::size_t arrayBytes(const DeformableMesh& message) {
  return sizeof(float) * message.vertices.size() + sizeof(std::uint32_t) * message.triangles.size();
}

[[noreturn]] void rejectMesh(const std::string& why) { throw std::invalid_argument(why); }

// Returns whether a message on the topic of `object` is about that object.
bool isMeshOf(const std::string& object, const DeformableMesh& message) {
  return message.object.empty() || message.object == object;
}

bool haveSameTriangles(const DeformableMesh& a, const DeformableMesh& b) {
  return a.topology_id == b.topology_id && a.vertices.size() == b.vertices.size() &&
         a.triangles == b.triangles;
}

}  // namespace

MeshInput::MeshInput(std::string object, const MeshLimits& limits)
    : object_(std::move(object)),
      max_age_ns_(std::llround(1e9 * limits.max_age_s)),
      history_bytes_(limits.history_bytes) {}

// The first of several deletions counts, so that more of them put nothing off. A deletion is
// received, as far as counters go, when its grace ends.
void MeshInput::store(IncomingMesh mesh) {
  rivals_.look(mesh);
  const std::lock_guard<std::mutex> lock(mutex_);
  if (mesh.is_deletion) {
    if (!deletion_) deletion_ = std::move(mesh);
    return;
  }
  deletion_.reset();
  // A message that came before is still held, so no other message can be at its address.
  if (last_ == mesh.message && last_stamp_ != mesh.stamp() && mesh.problem.empty()) {
    mesh.problem =
        "its publisher, in this process, changed a mesh that it had published; it must make a new "
        "message for each mesh";
  }
  last_ = mesh.message;
  last_stamp_ = mesh.stamp();
  ++counters_.received;
  counters_.stamped_on_receipt += mesh.stamped_on_receipt;
  if (waiting_) ++counters_.dropped;
  const DeformableMesh& message = *mesh.message;
  if (!message.triangles.empty() && isMeshOf(object_, message)) {
    const DeformableMesh::ConstPtr& before = keyframe_.mesh.message;
    if (before == nullptr || !haveSameTriangles(*before, message)) keyframe_.senders.clear();
    keyframe_.mesh = mesh;
    add(mesh.connection, &keyframe_.senders);
  }
  waiting_ = std::move(mesh);
}

void MeshInput::storeTriangles(const DeformableMesh::ConstPtr& keyframe) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (keyframe != nullptr) keyframe_ = {IncomingMesh{keyframe}, {}};
}

bool MeshInput::hasWaiting() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return waiting_.has_value();
}

MeshCounters MeshInput::counters() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return counters_;
}

std::optional<IncomingMesh> MeshInput::newest(std::string* why_not) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!newest_) {
    *why_not = counters_.problem.empty() ? "no mesh yet" : "mesh refused: " + counters_.problem;
  }
  return newest_;
}

std::optional<SteadyTime> MeshInput::deletedAt() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return deletion_ ? std::optional(deletion_->arrival) : std::nullopt;
}

void MeshInput::endGrace() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!deletion_ || waiting_) return;
  ++counters_.received;
  waiting_ = std::move(*deletion_);
  deletion_.reset();
}

void MeshInput::countDropped() {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++counters_.dropped;
}

void MeshInput::dropIf(const std::function<bool(const ros::Time&)>& unwanted) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (deletion_ && unwanted(deletion_->stamp())) {  // nothing may follow it, so it counts at once
    deletion_.reset();
    accepted_.clear();
    newest_.reset();
  }
  if (!waiting_ || !unwanted(waiting_->stamp())) return;
  waiting_.reset();
  ++counters_.dropped;
}

// To validate triangles takes time, so the lock is not held meanwhile: publishers' callbacks do not
// wait for it.
Acceptance MeshInput::take(const ros::Time& now, IncomingMesh* taken) {
  Keyframe keyframe;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!waiting_) return Acceptance::kNothing;
    *taken = std::move(*waiting_);
    waiting_.reset();
    keyframe = std::exchange(keyframe_, Keyframe());
  }
  const std::shared_ptr<const Topology> before = topology_;
  const Acceptance answer = decide(keyframe, now, taken);

  const std::lock_guard<std::mutex> lock(mutex_);
  counters_.dropped += answer == Acceptance::kDropped;
  counters_.rejected += answer == Acceptance::kRejected;
  counters_.jumps += answer == Acceptance::kJumped;
  if (answer != Acceptance::kDropped) counters_.problem = taken->problem;
  if (before && topology_ && before != topology_) ++counters_.topology_changes;
  newest_.reset();
  if (!accepted_.empty()) {
    newest_ = accepted_.back();
    counters_.newest = newest_->stamp();
  }
  return answer;
}

// Triangles are learned first: they count even if their own message is dropped or rejected.
Acceptance MeshInput::decide(const Keyframe& keyframe, const ros::Time& now, IncomingMesh* mesh) {
  try {
    if (keyframe.mesh.message != nullptr) learnTopology(keyframe);
    if (!mesh->problem.empty()) rejectMesh(mesh->problem);
    checkHeader(*mesh->message);
    if (isOutOfOrder(mesh->stamp(), now)) return Acceptance::kDropped;
    checkAge(mesh->stamp(), now);
    checkTopology(*mesh);
    mesh->topology = topology_;
    return keep(*mesh) ? Acceptance::kJumped : Acceptance::kAccepted;
  } catch (const std::exception& error) {
    mesh->problem = error.what();
    accepted_.clear();
    return Acceptance::kRejected;
  }
}

// Without a clock no mesh is old.
bool MeshInput::isOld(const ros::Time& stamp, const ros::Time& now) const {
  return !now.isZero() && nanosecondsBetween(now, stamp) > max_age_ns_;
}

// A mesh older than the newest accepted one is out of order, unless the stamps have jumped back.
// They have jumped back if the newest accepted mesh is too old by the clock, or if this mesh is
// older than it by more than max_age_s. But a mesh that is too old by the clock while the newest
// accepted one is fresh comes from a publisher that lags far behind: it is out of order as well.
bool MeshInput::isOutOfOrder(const ros::Time& stamp, const ros::Time& now) const {
  if (accepted_.empty()) return false;
  const ros::Time& newest = accepted_.back().stamp();
  if (stamp >= newest || isOld(newest, now)) return false;
  return nanosecondsBetween(newest, stamp) <= max_age_ns_ || isOld(stamp, now);
}

void MeshInput::checkHeader(const DeformableMesh& message) const {
  if (!isMeshOf(object_, message)) {
    rejectMesh("the mesh is of object '" + message.object + "', expected is '" + object_ + "'");
  }
  const ros::Time& stamp = message.header.stamp;
  if (stamp.isZero()) rejectMesh("header.stamp is zero");
  if (stamp.nsec >= 1000000000) {
    rejectMesh("header.stamp has " + std::to_string(stamp.nsec) + " ns, a second or more");
  }
  if (message.header.frame_id.empty()) rejectMesh("header.frame_id is empty");
}

// An old mesh usually comes from a bag that is played without its clock, so the text says so.
void MeshInput::checkAge(const ros::Time& stamp, const ros::Time& now) const {
  if (now.isZero()) return;
  const double ahead_s = secondsBetween(stamp, now);
  if (ahead_s > kMaxAheadS) {
    rejectMesh("header.stamp is " + std::to_string(ahead_s) + " s ahead of this machine's clock");
  }
  if (isOld(stamp, now)) {
    constexpr double kRecordedS = 60;  // nothing takes so long to arrive
    rejectMesh("header.stamp is " + std::to_string(-ahead_s) + " s old, and max_mesh_age_s less; " +
               (-ahead_s < kRecordedS
                    ? "it came late, or its machine's clock is behind"
                    : "a bag needs /clock, and use_sim_time before the monitor starts"));
  }
}

// A mesh whose connection is not known may use all triangles. A new connection never equals one
// that ended, because the pointers to that one have expired.
bool MeshInput::contains(const Connections& connections,
                         const boost::shared_ptr<const void>& connection) {
  return connection == nullptr ||
         std::any_of(connections.begin(), connections.end(),
                     [&connection](const auto& other) { return other.lock() == connection; });
}

void MeshInput::add(const boost::shared_ptr<const void>& connection, Connections* connections) {
  connections->erase(std::remove_if(connections->begin(), connections->end(),
                                    [](const auto& other) { return other.expired(); }),
                     connections->end());
  if (!contains(*connections, connection)) connections->emplace_back(connection);
}

// Invalid triangles take the old ones away: the publisher means the new ones from now on. Equal
// triangles of several connections are one topology.
void MeshInput::learnTopology(const Keyframe& keyframe) {
  const DeformableMesh& message = *keyframe.mesh.message;
  const std::size_t vertex_count = message.vertices.size() / 3;
  const bool has_same_id = topology_ && topology_->id == message.topology_id;
  if (has_same_id && topology_->vertex_count == vertex_count &&
      topology_->triangles == message.triangles) {
    for (const auto& sender : keyframe.senders) add(sender.lock(), &senders_);
    return;
  }
  const boost::shared_ptr<const void>& connection = keyframe.mesh.connection;
  if (has_same_id && connection != nullptr && contains(senders_, connection)) {
    rivals_.noteReusedId(keyframe.mesh);
  }
  senders_ = keyframe.senders;
  try {
    validate({message.vertices, message.triangles},
             "topology " + std::to_string(message.topology_id));
    topology_ = std::make_shared<const Topology>(
        Topology{message.topology_id, vertex_count, message.triangles});
    rejected_topology_.reset();
  } catch (const std::invalid_argument& error) {
    topology_ = nullptr;
    rejected_topology_ = {message.topology_id, error.what()};
    throw;
  }
}

// If the newest triangles of this id are invalid, the reason is theirs and not that they are
// missing.
void MeshInput::checkTopology(const IncomingMesh& mesh) const {
  const DeformableMesh& message = *mesh.message;
  if (rejected_topology_ && rejected_topology_->id == message.topology_id) {
    rejectMesh(rejected_topology_->problem);
  }
  if (!topology_ || topology_->id != message.topology_id) {
    rejectMesh("no triangles of topology_id " + std::to_string(message.topology_id) +
               " seen yet; publishers send them on change and at least once a second");
  }
  if (!contains(senders_, mesh.connection)) {
    rejectMesh("no triangles of topology_id " + std::to_string(message.topology_id) +
               " seen from this publisher since it connected, or since another one sent different "
               "ones; publishers send them on change and at least once a second");
  }
  if (message.vertices.size() != 3 * topology_->vertex_count) {
    rejectMesh(std::to_string(message.vertices.size()) + " vertex coordinates, but topology_id " +
               std::to_string(topology_->id) + " has " + std::to_string(topology_->vertex_count) +
               " vertices");
  }
}

// Returns whether stamps jumped back, so that all earlier meshes were forgotten.
bool MeshInput::keep(const IncomingMesh& mesh) {
  const bool jumped = !accepted_.empty() && mesh.stamp() < accepted_.back().stamp();
  if (jumped) accepted_.clear();
  if (!accepted_.empty() && accepted_.back().stamp() == mesh.stamp()) accepted_.pop_back();
  accepted_.push_back(mesh);
  std::size_t bytes = 0;
  for (const IncomingMesh& kept : accepted_) bytes += arrayBytes(*kept.message);
  while (accepted_.size() > 1 &&
         (accepted_.size() > kMaxAccepted ||
          (bytes > history_bytes_ && accepted_.size() > kLeastAccepted) ||
          nanosecondsBetween(mesh.stamp(), accepted_.front().stamp()) > max_age_ns_)) {
    bytes -= arrayBytes(*accepted_.front().message);
    accepted_.pop_front();
  }
  return jumped;
}

// The search starts at the newest mesh, where it nearly always ends.
const IncomingMesh* MeshInput::newestAt(
    const ros::Time& t, std::string* why_not,
    const std::function<bool(const IncomingMesh&)>& preferred) const {
  const auto isYoung = [&](const IncomingMesh& mesh) {
    return nanosecondsBetween(t, mesh.stamp()) <= max_age_ns_;
  };
  const auto found = std::find_if(accepted_.rbegin(), accepted_.rend(),
                                  [&t](const IncomingMesh& mesh) { return mesh.stamp() <= t; });
  if (found != accepted_.rend() && isYoung(*found)) {
    if (!preferred) return &*found;
    const auto best = std::find_if(found, accepted_.rend(), [&](const IncomingMesh& mesh) {
      return !isYoung(mesh) || preferred(mesh);
    });
    return best != accepted_.rend() && isYoung(*best) ? &*best : &*found;
  }
  const std::string problem = counters().problem;
  if (!problem.empty()) {
    *why_not = "mesh refused: " + problem;
  } else if (accepted_.empty()) {
    *why_not = "no mesh yet";
  } else if (found == accepted_.rend()) {
    *why_not = "no mesh as old as this cycle";
  } else {
    char text[64];
    std::snprintf(text, sizeof text, "newest mesh is %.3f s old",
                  secondsBetween(t, found->stamp()));
    *why_not = text;
  }
  return nullptr;
}

// The scheduler asks this for meshes in its queue, which may have left the history meanwhile.
bool MeshInput::has(const ros::Time& stamp) const {
  return std::any_of(accepted_.begin(), accepted_.end(),
                     [&stamp](const IncomingMesh& mesh) { return mesh.stamp() == stamp; });
}

void MeshInput::forget() {
  accepted_.clear();
  const std::lock_guard<std::mutex> lock(mutex_);
  newest_.reset();
}

MeshInputs makeMeshInputs(const MonitorParameters& parameters) {
  MeshInputs inputs;
  for (const ObjectParameters& object : parameters.objects) {
    inputs.emplace_back(object.name,
                        MeshLimits{parameters.max_mesh_age_s, parameters.max_mesh_bytes});
  }
  return inputs;
}

}  // namespace deformable_contact_monitor
