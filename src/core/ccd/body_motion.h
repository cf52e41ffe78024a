// How one body moves in a step, and how far its points are from straight lines.
#pragma once

#include <vector>

#include "core/scene.h"
#include "core/substeps.h"

namespace deformable_contact_monitor {

// Throws std::invalid_argument, beginning with `name`, at a path that is not as BodyPath says.
void validate(const BodyPath& path, const std::string& name);

bool samePose(const RigidTransform& a, const RigidTransform& b);

// Vertices that move on straight lines: x y z each at a part [0, 1] of the way, rounded to float32
// once; at 0 and 1 the given ones. As many as the others.
std::vector<float> verticesBetween(const HostList<float>& from, const HostList<float>& to,
                                   double at);

// How far rounding to float32 moves a point, at most, that is so far from the origin [m].
double roundingAt(double distance);

// A view: body and path must outlive it, and be valid. The body has no vertices on a device.
class BodyMotion {
 public:
  BodyMotion(const Body& body, const BodyPath& path);

  const BodyPath& path() const { return *path_; }

  // At a part [0, 1] of the step. That of a sample is the sample's, bit by bit.
  RigidTransform poseAt(double at) const;

  // Vertices in the body's own frame, rounded to float32, where they move from one state to the
  // next on straight lines; empty: they do not move there. Those at 0 and 1 are the given ones.
  std::vector<float> verticesAt(double at) const;

  // Every point of the body is, at all times of [from, to], at most so far [m] from the straight
  // line between its places at both ends, which it goes along evenly.
  double deviation(double from, double to) const;

  // No point is ever further from the scene's origin [m].
  double farthest() const { return farthest_; }

  // Rounding to float32 moves no point of the body further than this [m], at any time: half an ulp
  // of each coordinate, in the scene frame and, of a body that deforms, in its own.
  double rounding() const { return rounding_; }

  // Whether it deviates from straight lines by more than rounding to float32 does.
  bool bends() const;

 private:
  // The motion from one sample to the next: R(s) = turn by s * angle about `axis`, times the first
  // sample's rotation.
  struct Piece {
    double axis[3];
    double angle;   // [rad], [0, pi]
    double defect;  // of the turned rotation from the second sample's; bounds its operator norm
  };

  static Piece pieceBetween(const RigidTransform& from, const RigidTransform& to);
  std::size_t pieceAt(double at) const;
  double deviationAt(std::size_t sample, double from, const RigidTransform& pose_from, double to,
                     const RigidTransform& pose_to) const;

  const Body* body_;
  const BodyPath* path_;
  std::vector<Piece> pieces_;
  double reach_ = 0;     // of the vertices from the body's origin [m]
  double change_ = 0;    // longest way of a vertex in the body's own frame [m]
  double farthest_ = 0;  // of the scene's origin [m]
  double rounding_ = 0;  // [m]
};

}  // namespace deformable_contact_monitor
