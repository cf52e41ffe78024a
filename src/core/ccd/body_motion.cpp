// Interpolates the path of a body, and bounds how far its points are from straight lines. From one
// sample to the next the body's origin moves straight and evenly, and the body rotates evenly about
// a fixed axis. All bounds are computed in double and made a little larger than the rounding
// errors.
#include "core/ccd/body_motion.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

// Covers the rounding errors of double arithmetic in this file, with much to spare.
constexpr double kSlack = 1 + 1e-7;
constexpr double kHalfUlp = 1.0 / (1 << 24);  // of the number 1 as float32

void multiply(const double a[9], const double b[9], double product[9]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      product[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    }
  }
}

// Returns a bound of the operator norm of m, the largest factor by which m makes a vector longer.
// Its fourth power is an eigenvalue of (m^T m)^2, and so at most the largest row sum of that
// matrix. For differences of rotations about one axis the bound is at most 8 % too large.
double boundOfNorm(const double m[9]) {
  double transposed[9], square[9], fourth[9], most = 0;
  for (int i = 0; i < 9; ++i) transposed[i] = m[3 * (i % 3) + i / 3];
  multiply(transposed, m, square);
  multiply(square, square, fourth);
  for (int i = 0; i < 9; i += 3) {
    most = std::max(most, std::abs(fourth[i]) + std::abs(fourth[i + 1]) + std::abs(fourth[i + 2]));
  }
  return std::sqrt(std::sqrt(most));
}

// Writes the rotation by an angle [rad] about an axis (Rodrigues' formula). The axis is a unit
// vector, or zero.
void rotationAbout(const double axis[3], double angle, double r[9]) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double half = std::sin(angle / 2);
  const double versine = 2 * half * half;  // 1 - c, of small angles too
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) r[3 * i + j] = versine * axis[i] * axis[j] + (i == j ? c : 0);
  }
  r[1] -= s * axis[2];
  r[2] += s * axis[1];
  r[3] += s * axis[2];
  r[5] -= s * axis[0];
  r[6] -= s * axis[1];
  r[7] += s * axis[0];
}

// Writes the unit quaternion x y z w of a rotation, w >= 0. Uses Shepperd's method, which divides
// by the largest component.
void quaternionOf(const double r[9], double q[4]) {
  const double trace = r[0] + r[4] + r[8];
  const double largest = std::max({trace, r[0], r[4], r[8]});
  if (largest == trace) {
    q[0] = r[7] - r[5], q[1] = r[2] - r[6], q[2] = r[3] - r[1], q[3] = 1 + trace;
  } else {
    const int i = largest == r[0] ? 0 : largest == r[4] ? 1 : 2;
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 1 + 2 * r[4 * i] - trace;
    q[j] = r[3 * j + i] + r[3 * i + j];
    q[k] = r[3 * k + i] + r[3 * i + k];
    q[3] = r[3 * k + j] - r[3 * j + k];
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; ++i) q[i] /= q[3] < 0 ? -length : length;
}

double lengthOf(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

// Returns the vertices of the earlier state. A body that does not deform has the same ones in both.
const HostList<float>& earlierVertices(const Body& body) {
  const bool others = body.earlier && !body.earlier->vertices.empty();
  return others ? body.earlier->vertices : body.mesh.vertices;
}

}  // namespace

void validate(const BodyPath& path, const std::string& name) {
  if (path.empty()) return;
  const auto refuse = [&name](const std::string& why) {
    throw std::invalid_argument(name + ": its path " + why);
  };
  if (path.size() < 2) refuse("has one sample alone");
  if (path.front().at != 0 || path.back().at != 1) refuse("does not go from 0 to 1");
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string sample = "sample " + std::to_string(i);
    if (i > 0 && !(path[i - 1].at < path[i].at)) refuse("does not ascend at " + sample);
    const RigidTransform& pose = path[i].pose;
    if (!isFinite(pose)) refuse("has a non-finite number in " + sample);
    if (!isRotation(pose.rotation)) refuse("has no rotation in " + sample);
  }
}

std::vector<float> verticesBetween(const HostList<float>& from, const HostList<float>& to,
                                   double at) {
  if (at == 0 || at == 1) return at == 0 ? from : to;
  std::vector<float> between(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    const double x = from[i];
    between[i] = toFloat(x + at * (to[i] - x));
  }
  return between;
}

// The bound is half an ulp of each coordinate, and the spacing of float32 numbers near 0.
double roundingAt(double distance) { return kSlack * (kHalfUlp * distance + 0x1p-149); }

// Takes axis and angle from the relative rotation. The matrices of samples may be no exact
// rotations, so the rotated first sample can differ a little from the second. `defect` bounds that
// difference.
BodyMotion::Piece BodyMotion::pieceBetween(const RigidTransform& from, const RigidTransform& to) {
  double inverse[9], relative[9], q[4];
  for (int i = 0; i < 9; ++i) inverse[i] = from.rotation[3 * (i % 3) + i / 3];
  multiply(to.rotation, inverse, relative);
  quaternionOf(relative, q);
  const double sine = lengthOf(q[0], q[1], q[2]);
  Piece piece{{0, 0, 0}, 2 * std::atan2(sine, q[3]), 0};
  for (int k = 0; k < 3 && sine > 0; ++k) piece.axis[k] = q[k] / sine;
  double turned[9], end[9];
  rotationAbout(piece.axis, piece.angle, turned);
  multiply(turned, from.rotation, end);
  for (int i = 0; i < 9; ++i) end[i] -= to.rotation[i];
  piece.defect = boundOfNorm(end);
  return piece;
}

BodyMotion::BodyMotion(const Body& body, const BodyPath& path) : body_(&body), path_(&path) {
  const HostList<float>&now = body.mesh.vertices, &then = earlierVertices(body);
  for (std::size_t i = 0; i + 2 < now.size(); i += 3) {
    const double x = now[i], y = now[i + 1], z = now[i + 2];
    const double u = then[i], v = then[i + 1], w = then[i + 2];
    const double change = lengthOf(x - u, y - v, z - w);
    if (!std::isfinite(change)) continue;  // takes no part
    reach_ = std::max({reach_, lengthOf(x, y, z), lengthOf(u, v, w)});
    change_ = std::max(change_, change);
  }
  // A sample's matrix may be no exact rotation and may make vectors longer by this factor at most.
  double stretch = 1;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const RigidTransform& pose = path[i].pose;
    if (i > 0) pieces_.push_back(pieceBetween(path[i - 1].pose, pose));
    stretch = std::max(stretch, 1 + rotationDefect(pose.rotation));
    const double* t = pose.translation;
    farthest_ = std::max(farthest_, lengthOf(t[0], t[1], t[2]));
  }
  reach_ *= stretch;
  change_ *= stretch;
  farthest_ += reach_;
  rounding_ = roundingAt(farthest_);
  if (change_ > 0) rounding_ += roundingAt(reach_);
}

// Returns the piece that contains that time; at a sample the piece that begins there, at 1 the
// last.
std::size_t BodyMotion::pieceAt(double at) const {
  const auto next = std::upper_bound(path_->begin(), path_->end() - 1, at,
                                     [](double t, const PoseSample& s) { return t < s.at; });
  return static_cast<std::size_t>(next - path_->begin()) - 1;
}

RigidTransform BodyMotion::poseAt(double at) const {
  const BodyPath& path = *path_;
  const std::size_t i = pieceAt(at);
  const PoseSample &from = path[i], &to = path[i + 1];
  if (from.at == at || to.at == at) return (from.at == at ? from : to).pose;
  const Piece& piece = pieces_[i];
  const double part = (at - from.at) / (to.at - from.at);
  double turned[9];
  rotationAbout(piece.axis, part * piece.angle, turned);
  RigidTransform pose;
  multiply(turned, from.pose.rotation, pose.rotation);
  for (int k = 0; k < 3; ++k) {
    const double x = from.pose.translation[k], y = to.pose.translation[k];
    pose.translation[k] = x + part * (y - x);
  }
  return pose;
}

std::vector<float> BodyMotion::verticesAt(double at) const {
  if (change_ == 0) return {};
  return verticesBetween(earlierVertices(*body_), body_->mesh.vertices, at);
}

// Consider a point at distance r from the body's origin. In one piece it rotates by an angle a and
// moves by d in the body's frame. With the piece's time in [0, 1], |x''| <= a^2 r + 2 a d, and
// linear interpolation has an error of at most an eighth of that (`arc`). If samples lie between
// `from` and `to`, the error is at most the largest deviation of a sample from the straight line
// (`corner`), plus the largest arc between two of them.
double BodyMotion::deviation(double from, double to) const {
  const BodyPath& path = *path_;
  const RigidTransform pose_from = poseAt(from), pose_to = poseAt(to);
  double arc = 0, corner = 0;
  for (std::size_t i = pieceAt(from); i < pieces_.size() && path[i].at < to; ++i) {
    const double low = std::max(from, path[i].at), high = std::min(to, path[i + 1].at);
    const double angle = pieces_[i].angle * ((high - low) / (path[i + 1].at - path[i].at));
    const double change = change_ * (high - low);
    arc = std::max(arc, angle * (angle * reach_ + 2 * change) / 8 + pieces_[i].defect * reach_);
    if (high < to) corner = std::max(corner, deviationAt(i + 1, from, pose_from, to, pose_to));
  }
  return (arc + corner) * kSlack;
}

// Bounds how far the body's points at a sample are from the straight line between both ends [m]: by
// the differences of rotation, of translation, and of the deformation that is rotated with them.
double BodyMotion::deviationAt(std::size_t sample, double from, const RigidTransform& pose_from,
                               double to, const RigidTransform& pose_to) const {
  const RigidTransform& pose = (*path_)[sample].pose;
  const double part = ((*path_)[sample].at - from) / (to - from);
  double off[9], rest[9], shift[3];
  for (int i = 0; i < 9; ++i) {
    off[i] = pose.rotation[i] - ((1 - part) * pose_from.rotation[i] + part * pose_to.rotation[i]);
    rest[i] = pose.rotation[i] - pose_to.rotation[i];
  }
  for (int k = 0; k < 3; ++k) {
    shift[k] = pose.translation[k] -
               ((1 - part) * pose_from.translation[k] + part * pose_to.translation[k]);
  }
  return boundOfNorm(off) * reach_ + lengthOf(shift[0], shift[1], shift[2]) +
         part * boundOfNorm(rest) * change_ * (to - from);
}

bool BodyMotion::rotates() const { return reach_ > 0 && deviation(0, 1) > rounding_ / 2; }

}  // namespace deformable_contact_monitor
