// Simulates a soft object among a robot's links with Bullet's soft bodies.
//
// Links are kinematic: they go where their poses say, and push the object. Bullet sees each
// connected part of a link's mesh as its convex hull. The object meets links with its nodes, not
// with its edges and triangles, and it does not meet itself.
#pragma once

#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/triangle_mesh.h"
#include "tools/simulation/scene_object.h"
#include "tools/simulation/soft_shape.h"

namespace deformable_contact_monitor {

// How a soft object is simulated.
struct SoftWorldOptions {
  double step_s = 1 / 240.;   // the longest step of the simulation [s]
  double margin_m = 0.001;    // Bullet keeps nodes so far from links; of a rope, its radius
  double max_speed_m_s = 30;  // a node that is faster has flown away
};

// A node that Bullet has in its list of contacts with a link after the latest step.
struct SoftContact {
  std::uint32_t node;
  std::string link;
};

// What one call of advance() came to.
struct Advance {
  std::string problem;  // why the step was undone, one line; empty: it was not
  bool restarted = false;
};

// Owns Bullet's world. The same calls give the same nodes, bit by bit, on one machine. Use it from
// one thread at a time. Gravity is along -z.
class SoftWorld {
 public:
  // Throws std::invalid_argument, one line, if an option is not a positive finite number.
  SoftWorld(SoftShape shape, const SoftWorldOptions& options);
  ~SoftWorld();
  SoftWorld(const SoftWorld&) = delete;
  SoftWorld& operator=(const SoftWorld&) = delete;

  // Adds a link. It pushes nothing before its pose is known. A mesh without any finite vertex is no
  // obstacle.
  void addLink(const std::string& name, const TriangleMesh& mesh);

  // Adds a table about the origin, 8 m by 8 m, whose top is at z [m].
  void addFloor(double z);

  // Moves the links to their poses and the object with them, within `dt_s` [s]: in equal steps of
  // at most step_s, over which the links move steadily. The first call finds the links where they
  // are. A link whose pose is not known, or not finite, stays where it was.
  //
  // A step is undone if it would explode: a node is not finite, is faster than max_speed_m_s, or
  // is many times the object's size away. The object then keeps the shape that it had before the
  // call, at rest, and the links are where they should be. After ten such calls in a row, and if it
  // was far away, the object starts anew, and nothing is held.
  Advance advance(double dt_s, const LinkPose& pose_of);

  // Pins the nodes that are within `radius_m` of one of the links; each follows the nearest one.
  // What was held before is released. Returns the number of nodes; if it is 0, nothing has changed.
  // Throws std::invalid_argument if a link is not known, or its pose is not.
  std::size_t hold(const std::vector<std::string>& links, double radius_m);

  // Returns the number of triangles of which all vertices are held.
  std::size_t heldTriangles() const;

  // Takes the object back to where it started, at rest; nothing is held. Links stay where they are.
  void restart();

  // Lets go of all that is held.
  void release();

  // Returns the object in its present state, rounded to float32.
  TriangleMesh mesh() const;

  // Returns the largest length of a spring that does not bend, relative to its length at rest.
  double stretch() const;

  // Returns the contacts that Bullet found in the latest step, ascending.
  std::vector<SoftContact> contacts() const;

  const SoftShape& shape() const { return shape_; }

 private:
  // A convex piece of a link.
  struct Piece {
    std::unique_ptr<btConvexShape> shape;
    std::unique_ptr<btDefaultMotionState> motion;
    std::unique_ptr<btRigidBody> body;
  };
  struct Link {
    std::vector<Piece> pieces;
    std::optional<Eigen::Isometry3d> from, to;  // poses at the beginning and the end of a call
  };
  // A node that follows a link.
  struct Held {
    int node;
    std::string link;
    Eigen::Vector3d place;  // in the link's frame [m]
  };

  void makeBody();
  void addPiece(const std::string& link, std::unique_ptr<btConvexShape> piece);
  void place(const std::vector<btVector3>& nodes);
  void movePieces(Link* link, const Eigen::Isometry3d& pose, bool at_once);
  void moveHeld(double share);
  std::string explosion(bool* is_lost) const;
  void undo(const std::vector<btVector3>& nodes, bool is_lost, Advance* result);
  std::string linkOf(const btCollisionObject* object) const;

  const SoftShape shape_;
  const SoftWorldOptions options_;
  btVector3 middle_;   // of the object at rest
  double far_away_m_;  // from there
  std::map<std::string, Link> links_;
  std::vector<Held> held_;
  int undone_ = 0;  // calls in a row

  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::unique_ptr<btSoftBody> body_;
};

}  // namespace deformable_contact_monitor
