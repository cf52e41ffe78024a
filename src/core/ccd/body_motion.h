// The motion of one body along its path in a time interval, and bounds of how far its points are
// from straight lines.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/body_path.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Throws std::invalid_argument, whose text begins with `name`, for a path that breaks the rules of
// BodyPath.
void validate(const BodyPath& path, const std::string& name);

// Returns vertices (x y z each) that move on straight lines, at a part [0, 1] of the way, rounded
// to float32 once. At 0 and 1 these are exactly the given ones. Both lists have the same length.
std::vector<float> verticesBetween(const HostList<float>& from, const HostList<float>& to,
                                   double at);

// Returns how far, at most, rounding to float32 moves a point at that distance from the origin [m].
double roundingAt(double distance);

// A view of a body and its path, which must be valid and must outlive it. The body's vertices must
// be on the host.
class BodyMotion {
 public:
  BodyMotion(const Body& body, const BodyPath& path);

  const BodyPath& path() const { return *path_; }

  // Returns the pose at a time in [0, 1]. At the time of a sample it is the sample's, bit by bit.
  RigidTransform poseAt(double at) const;

  // Returns the vertices in the body's own frame at a time in [0, 1], where they move from the
  // earlier state to the present one on straight lines, rounded to float32. At 0 and 1 these are
  // exactly the given ones. Empty if they do not move in that frame.
  std::vector<float> verticesAt(double at) const;

  // Returns a bound [m]: at any time in [from, to], each point of the body is at most so far from
  // where it would be if it moved straight and evenly between its places at both ends.
  double deviation(double from, double to) const;

  // Returns a bound of the distance of any point from the scene's origin, at any time [m].
  double farthest() const { return farthest_; }

  // Returns a bound of how far rounding to float32 moves a point, at any time [m]. It is half an
  // ulp of each coordinate, in the scene frame and, if the body deforms, also in its own frame.
  double rounding() const { return rounding_; }

  // Returns whether points deviate from straight lines by more than rounding to float32 moves them.
  bool rotates() const;

 private:
  // The motion from one sample to the next. At part s of it, the rotation is the first sample's,
  // followed by a rotation by s * angle about `axis`.
  struct Piece {
    double axis[3];
    double angle;   // [rad], [0, pi]
    double defect;  // bounds the operator norm of the error against the second sample's rotation
  };

  static Piece pieceBetween(const RigidTransform& from, const RigidTransform& to);
  std::size_t pieceAt(double at) const;
  double deviationAt(std::size_t sample, double from, const RigidTransform& pose_from, double to,
                     const RigidTransform& pose_to) const;

  const Body* body_;
  const BodyPath* path_;
  std::vector<Piece> pieces_;
  double reach_ = 0;     // largest distance of a vertex from the body's origin [m]
  double change_ = 0;    // longest way of a vertex in the body's own frame [m]
  double farthest_ = 0;  // largest distance of a point from the scene's origin [m]
  double rounding_ = 0;  // [m]
};

}  // namespace deformable_contact_monitor
