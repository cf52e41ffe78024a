#include "screw_motions.h"

#include <cmath>

namespace deformable_contact_monitor {
namespace {

// v turned about a unit axis.
Place turnedPoint(const Place& v, const Place& axis, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double along = axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
  const Place across{axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2],
                     axis[0] * v[1] - axis[1] * v[0]};
  Place result;
  for (std::size_t k = 0; k < 3; ++k) {
    result[k] = c * v[k] + s * across[k] + (1 - c) * along * axis[k];
  }
  return result;
}

// A matrix whose columns are the axes of the scene frame, turned, times `start`.
RigidTransform turned(const RigidTransform& start, const Place& axis, double angle) {
  RigidTransform result = start;
  for (std::size_t column = 0; column < 3; ++column) {
    const Place v = turnedPoint(
        {start.rotation[column], start.rotation[3 + column], start.rotation[6 + column]}, axis,
        angle);
    for (std::size_t row = 0; row < 3; ++row) result.rotation[3 * row + column] = v[row];
  }
  return result;
}

}  // namespace

Place placeOf(const RigidTransform& pose, const Place& in_body) {
  Place place;
  for (std::size_t k = 0; k < 3; ++k) {
    place[k] = pose.translation[k];
    for (std::size_t j = 0; j < 3; ++j) place[k] += pose.rotation[3 * k + j] * in_body[j];
  }
  return place;
}

RigidTransform ScrewMotion::at(double part) const {
  RigidTransform pose = turned(start, axis, part * angle);
  for (std::size_t k = 0; k < 3; ++k) pose.translation[k] += part * way[k];
  return pose;
}

BodyPath ScrewMotion::path(int between) const {
  BodyPath samples;
  for (int i = 0; i <= between + 1; ++i) {
    const double part = static_cast<double>(i) / (between + 1);
    samples.push_back({part, at(part)});
  }
  return samples;
}

double uniform(std::mt19937* random, double low, double high) {
  return low + (high - low) * ((*random)() / 4294967295.0);
}

Place randomUnit(std::mt19937* random) {
  for (;;) {
    Place v{uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)};
    const double size = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (size > 1 || size < 0.1) continue;
    for (double& x : v) x /= size;
    return v;
  }
}

ScrewMotion randomScrewMotion(std::mt19937* random, double range, double most) {
  ScrewMotion motion;
  motion.start = turned(RigidTransform(), randomUnit(random), uniform(random, -3.1, 3.1));
  motion.axis = randomUnit(random);
  motion.angle = uniform(random, 0, most);
  for (std::size_t k = 0; k < 3; ++k) {
    motion.start.translation[k] = uniform(random, -range, range);
    motion.way[k] = uniform(random, -0.1, 0.1) * range;
  }
  return motion;
}

}  // namespace deformable_contact_monitor
