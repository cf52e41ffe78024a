// Simulates a soft object among a robot's links with Bullet's soft bodies.
#include "tools/simulation/soft_world.h"

#include <BulletCollision/NarrowPhaseCollision/btGjkEpa2.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "tools/simulation/link_hulls.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kGravityZ = -9.81;      // [m/s^2]
constexpr double kDampingPerS = 1.5;     // share of a node's speed that goes in a second
constexpr double kMass = 0.3;            // [kg], of the whole object; links are not pushed by it
constexpr double kFrictionShare = 0.4;   // Bullet's dynamic friction
constexpr double kBendStiffness = 0.05;  // of springs that bend
constexpr double kPoseStiffness = 0.02;  // a volume's way back to its shape, a step
constexpr double kVoxel = 0.015;         // [m], of Bullet's grids of distances to a shape
constexpr int kPasses = 12;              // over all springs, a step
constexpr int kUndoneInARow = 10;        // calls, after which the object starts anew
constexpr double kFarAway = 20;          // sizes of the object, at rest
constexpr double kTable = 4;             // half of the table's edges [m]
constexpr const char* kFloorName = "";   // no link has an empty name

btVector3 toBullet(const Eigen::Vector3d& p) {
  return {static_cast<btScalar>(p.x()), static_cast<btScalar>(p.y()), static_cast<btScalar>(p.z())};
}

btTransform toBullet(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.rotation());
  const btQuaternion rotation(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()),
                              static_cast<btScalar>(q.z()), static_cast<btScalar>(q.w()));
  return btTransform(rotation, toBullet(Eigen::Vector3d(pose.translation())));
}

// Returns the pose at `share` of the way from a to b.
Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, double share) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translate((1 - share) * a.translation() + share * b.translation());
  pose.rotate(Eigen::Quaterniond(a.rotation()).slerp(share, Eigen::Quaterniond(b.rotation())));
  return pose;
}

}  // namespace

SoftWorld::SoftWorld(SoftShape shape, const SoftWorldOptions& options)
    : shape_(std::move(shape)), options_(options) {
  for (const double number : {options.step_s, options.margin_m, options.max_speed_m_s}) {
    if (!(number > 0) || !std::isfinite(number)) {
      throw std::invalid_argument(
          "the step, the margin and the fastest speed must be finite and above zero");
    }
  }
  Eigen::Vector3d low = shape_.nodes.front(), high = low;
  for (const Eigen::Vector3d& node : shape_.nodes) {
    low = low.cwiseMin(node);
    high = high.cwiseMax(node);
  }
  middle_ = toBullet(Eigen::Vector3d((low + high) / 2));
  far_away_m_ = kFarAway * (high - low).norm();
  const btVector3 gravity(0, 0, static_cast<btScalar>(kGravityZ));
  world_.setGravity(gravity);
  btSoftBodyWorldInfo& info = world_.getWorldInfo();
  info.m_gravity = gravity;
  info.air_density = 0;
  // The default grid of 25 cm knows no finger.
  info.m_sparsesdf.setDefaultVoxelsz(static_cast<btScalar>(kVoxel));
  info.m_sparsesdf.Reset();
  makeBody();
}

SoftWorld::~SoftWorld() {
  world_.removeSoftBody(body_.get());
  for (auto& [name, link] : links_) {
    for (Piece& piece : link.pieces) {
      if (piece.body->isInWorld()) world_.removeRigidBody(piece.body.get());
    }
  }
}

// Makes the soft body anew, at rest. Nothing that Bullet remembers of an explosion is left.
void SoftWorld::makeBody() {
  if (body_) world_.removeSoftBody(body_.get());
  std::vector<btVector3> nodes;
  for (const Eigen::Vector3d& node : shape_.nodes) nodes.push_back(toBullet(node));
  const std::vector<btScalar> masses(nodes.size(), static_cast<btScalar>(kMass / nodes.size()));
  body_ = std::make_unique<btSoftBody>(&world_.getWorldInfo(), static_cast<int>(nodes.size()),
                                       nodes.data(), masses.data());
  btSoftBody::Material* stretch = body_->m_materials[0];
  stretch->m_kLST = 1;
  btSoftBody::Material* bend = body_->appendMaterial();
  bend->m_kLST = static_cast<btScalar>(kBendStiffness);
  for (const SoftSpring& spring : shape_.springs) {
    body_->appendLink(static_cast<int>(spring.a), static_cast<int>(spring.b),
                      spring.bends ? bend : stretch);
  }
  for (std::size_t t = 0; !shape_.is_rope && t < shape_.triangles.size(); t += 3) {
    body_->appendFace(static_cast<int>(shape_.triangles[t]),
                      static_cast<int>(shape_.triangles[t + 1]),
                      static_cast<int>(shape_.triangles[t + 2]), stretch);
  }
  for (const std::uint32_t node : shape_.pinned) body_->setMass(static_cast<int>(node), 0);
  btSoftBody::Config& config = body_->m_cfg;
  config.collisions = btSoftBody::fCollision::SDF_RS;
  config.piterations = kPasses;
  config.kDP = static_cast<btScalar>(1 - std::exp(-kDampingPerS * options_.step_s));
  config.kDF = static_cast<btScalar>(kFrictionShare);
  config.kCHR = config.kKHR = 1;
  if (shape_.is_volume) {
    config.kMT = static_cast<btScalar>(kPoseStiffness);
    body_->setPose(false, true);
  }
  body_->getCollisionShape()->setMargin(static_cast<btScalar>(options_.margin_m));
  body_->setActivationState(DISABLE_DEACTIVATION);
  world_.addSoftBody(body_.get());
}

// Puts the nodes there, at rest.
void SoftWorld::place(const std::vector<btVector3>& nodes) {
  for (int i = 0; i < body_->m_nodes.size(); ++i) {
    btSoftBody::Node& node = body_->m_nodes[i];
    node.m_x = node.m_q = nodes[static_cast<std::size_t>(i)];
    node.m_v = btVector3(0, 0, 0);
  }
}

void SoftWorld::addPiece(const std::string& link, std::unique_ptr<btConvexShape> shape) {
  Piece piece;
  piece.shape = std::move(shape);
  piece.motion = std::make_unique<btDefaultMotionState>();
  piece.body = std::make_unique<btRigidBody>(0, piece.motion.get(), piece.shape.get());
  piece.body->setCollisionFlags(piece.body->getCollisionFlags() |
                                btCollisionObject::CF_KINEMATIC_OBJECT);
  piece.body->setActivationState(DISABLE_DEACTIVATION);
  piece.body->setFriction(1);  // Bullet multiplies it with the soft body's
  links_[link].pieces.push_back(std::move(piece));
}

std::string SoftWorld::linkOf(const btCollisionObject* object) const {
  for (const auto& [name, link] : links_) {
    for (const Piece& piece : link.pieces) {
      if (piece.body.get() == object) return name;
    }
  }
  return "";
}

// Bullet derives a kinematic body's velocity from the poses that its motion state has in turn.
// `at_once` moves it without a velocity.
void SoftWorld::movePieces(Link* link, const Eigen::Isometry3d& pose, bool at_once) {
  for (Piece& piece : link->pieces) {
    const btTransform transform = toBullet(pose);
    piece.motion->setWorldTransform(transform);
    if (!at_once) continue;
    piece.body->setWorldTransform(transform);
    piece.body->setInterpolationWorldTransform(transform);
    if (!piece.body->isInWorld()) {
      world_.addRigidBody(piece.body.get(), btBroadphaseProxy::KinematicFilter,
                          btBroadphaseProxy::DefaultFilter);
    }
  }
}

void SoftWorld::moveHeld(double share) {
  for (const Held& held : held_) {
    const Link& link = links_.at(held.link);
    btSoftBody::Node& node = body_->m_nodes[held.node];
    node.m_x = node.m_q =
        toBullet(Eigen::Vector3d(between(*link.from, *link.to, share) * held.place));
    node.m_v = btVector3(0, 0, 0);
  }
}

// Returns why the present state is an explosion; empty if it is none. It is lost if it does not
// come back when it is undone.
std::string SoftWorld::explosion(bool* is_lost) const {
  for (int i = 0; i < body_->m_nodes.size(); ++i) {
    const btSoftBody::Node& node = body_->m_nodes[i];
    const double speed = node.m_v.length(), away = (node.m_x - middle_).length();
    const std::string name = "vertex " + std::to_string(i);
    if (!std::isfinite(speed) || !std::isfinite(away)) return name + " is not finite";
    if (speed > options_.max_speed_m_s) {
      return name + " would move at " + std::to_string(std::lround(speed)) + " m/s";
    }
    if (away > far_away_m_) {
      *is_lost = true;
      return name + " would be " + std::to_string(std::lround(away)) + " m away";
    }
  }
  return "";
}

// Takes the object back to these nodes. The links stand where they should be at the end.
void SoftWorld::undo(const std::vector<btVector3>& nodes, bool is_lost, Advance* result) {
  if (++undone_ < kUndoneInARow && !is_lost) {
    makeBody();
    place(nodes);
    for (const Held& held : held_) body_->setMass(held.node, 0);
  } else {
    restart();
    result->restarted = true;
  }
  for (auto& [name, link] : links_) {
    if (link.to) movePieces(&link, *link.to, true);
  }
}

Advance SoftWorld::advance(double dt_s, const LinkPose& pose_of) {
  Advance result;
  bool is_lost = false;
  std::vector<btVector3> before;
  before.reserve(shape_.nodes.size());
  for (int i = 0; i < body_->m_nodes.size(); ++i) before.push_back(body_->m_nodes[i].m_x);
  for (auto& [name, link] : links_) {
    const std::optional<Eigen::Isometry3d> pose =
        name == kFloorName ? Eigen::Isometry3d::Identity() : pose_of(name);
    if (!pose || !pose->matrix().allFinite()) continue;
    const bool at_once = !link.to;
    link.to = pose;
    if (at_once) link.from = pose;
    if (at_once) movePieces(&link, *pose, true);
  }
  // A little less, so that a frame of four steps does not become five by rounding.
  const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / options_.step_s - 1e-6)));
  for (int step = 1; step <= steps && result.problem.empty(); ++step) {
    const double share = static_cast<double>(step) / steps;
    for (auto& [name, link] : links_) {
      if (link.to) movePieces(&link, between(*link.from, *link.to, share), false);
    }
    moveHeld(share);
    world_.stepSimulation(static_cast<btScalar>(dt_s / steps), 0);
    result.problem = explosion(&is_lost);
  }
  if (result.problem.empty()) {
    undone_ = 0;
  } else {
    undo(before, is_lost, &result);
  }
  for (auto& [name, link] : links_) link.from = link.to;
  return result;
}

std::size_t SoftWorld::hold(const std::vector<std::string>& links, double radius_m) {
  for (const std::string& name : links) {
    const auto link = links_.find(name);
    if (link == links_.end() || name == kFloorName) {
      throw std::invalid_argument("'" + name + "' is no link with a mesh");
    }
    if (!link->second.to) throw std::invalid_argument("the pose of '" + name + "' is not known");
  }
  std::vector<Held> held;
  for (int i = 0; i < body_->m_nodes.size(); ++i) {
    const btVector3& p = body_->m_nodes[i].m_x;
    double nearest = radius_m;
    Held best{i, "", {}};
    for (const std::string& name : links) {
      const Link& link = links_.at(name);
      for (const Piece& piece : link.pieces) {
        btGjkEpaSolver2::sResults results;
        const double distance =
            btGjkEpaSolver2::SignedDistance(p, 0, piece.shape.get(), toBullet(*link.to), results);
        if (!(distance <= nearest) || (distance == nearest && !best.link.empty())) continue;
        nearest = distance;
        best.link = name;
        best.place = link.to->inverse() * Eigen::Vector3d(p.x(), p.y(), p.z());
      }
    }
    const bool is_pinned = std::binary_search(shape_.pinned.begin(), shape_.pinned.end(),
                                              static_cast<std::uint32_t>(i));
    if (!best.link.empty() && !is_pinned) held.push_back(best);
  }
  if (held.empty()) return 0;
  release();
  held_ = std::move(held);
  for (const Held& one : held_) body_->setMass(one.node, 0);
  return held_.size();
}

void SoftWorld::release() {
  const auto mass = static_cast<btScalar>(kMass / body_->m_nodes.size());
  for (const Held& held : held_) body_->setMass(held.node, mass);
  held_.clear();
}

void SoftWorld::restart() {
  makeBody();
  held_.clear();
  undone_ = 0;
}

void SoftWorld::addLink(const std::string& name, const TriangleMesh& mesh) {
  for (auto& hull : linkHulls(mesh)) addPiece(name, std::move(hull));
}

void SoftWorld::addFloor(double z) {
  auto table = std::make_unique<btConvexHullShape>();
  for (int corner = 0; corner < 8; ++corner) {
    table->addPoint(toBullet(Eigen::Vector3d((corner & 1) != 0 ? kTable : -kTable,
                                             (corner & 2) != 0 ? kTable : -kTable,
                                             (corner & 4) != 0 ? z : z - 1)));
  }
  table->setMargin(0);
  addPiece(kFloorName, std::move(table));
}

std::size_t SoftWorld::heldTriangles() const {
  std::vector<bool> held(shape_.nodes.size());
  for (const Held& one : held_) held[static_cast<std::size_t>(one.node)] = true;
  std::size_t count = 0;
  for (std::size_t t = 0; t < shape_.triangles.size(); t += 3) {
    const bool all =
        held[shape_.triangles[t]] && held[shape_.triangles[t + 1]] && held[shape_.triangles[t + 2]];
    count += all ? 1 : 0;
  }
  return count;
}

TriangleMesh SoftWorld::mesh() const {
  TriangleMesh mesh;
  mesh.vertices.reserve(3 * shape_.node_of_vertex.size());
  for (const std::uint32_t node : shape_.node_of_vertex) {
    const btVector3& p = body_->m_nodes[static_cast<int>(node)].m_x;
    for (const btScalar coordinate : {p.x(), p.y(), p.z()}) {
      mesh.vertices.push_back(static_cast<float>(coordinate));
    }
  }
  mesh.triangles.assign(shape_.mesh_triangles.begin(), shape_.mesh_triangles.end());
  return mesh;
}

double SoftWorld::stretch() const {
  double most = 0;
  for (const SoftSpring& spring : shape_.springs) {
    if (spring.bends) continue;
    const auto& nodes = body_->m_nodes;
    const double now =
        (nodes[static_cast<int>(spring.a)].m_x - nodes[static_cast<int>(spring.b)].m_x).length();
    most = std::max(most, now / (shape_.nodes[spring.a] - shape_.nodes[spring.b]).norm());
  }
  return most;
}

std::vector<SoftContact> SoftWorld::contacts() const {
  std::vector<SoftContact> contacts;
  const btSoftBody& body = *body_;
  for (int i = 0; i < body.m_rcontacts.size(); ++i) {
    const auto& contact = body.m_rcontacts[i];
    contacts.push_back({static_cast<std::uint32_t>(contact.m_node - &body.m_nodes[0]),
                        linkOf(contact.m_cti.m_colObj)});
  }
  std::sort(contacts.begin(), contacts.end(), [](const SoftContact& a, const SoftContact& b) {
    return std::tie(a.node, a.link) < std::tie(b.node, b.link);
  });
  return contacts;
}

}  // namespace deformable_contact_monitor
