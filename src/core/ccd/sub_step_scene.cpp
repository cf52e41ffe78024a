// Cuts a time interval into sub-steps in which bodies move nearly straight, and sets up the scene
// of each sub-step. The deviation from straight lines that is left is added to the bodies' pads, so
// no contact is missed.
#include "core/ccd/sub_step_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/bounds/distance_rounding.h"
#include "core/common/posed_body.h"
#include "core/vector3.h"

namespace deformable_contact_monitor {
namespace {

// Vertices that are so many times as far from the origin as any body that rotates are outliers,
// unless rounding them costs less than the tolerance.
constexpr double kFarOff = 16;

// Makes pads large enough that the sum of two pads, rounded to float32, is not too small.
constexpr double kSlackOfSum = 1 + 0x1p-22;

// Returns whether the body is the same in its earlier and its present state.
bool isStill(const Body& body) {
  return !body.earlier || (body.earlier->vertices.empty() && body.earlier->pose == body.pose);
}

// Returns the first `count` vertices in the scene frame [m].
std::vector<float> posed(const PosedBody& body, std::size_t count) {
  std::vector<float> vertices;
  vertices.reserve(3 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3f v = body.vertex(i);
    vertices.insert(vertices.end(), {v.x, v.y, v.z});
  }
  return vertices;
}

double distanceOf(const float* v) {
  const double x = v[0], y = v[1], z = v[2];
  return std::sqrt(x * x + y * y + z * z);
}

// Holds where an interval is cut, and into how many pieces.
struct Cuts {
  std::vector<double> at;  // incomplete if there are too many pieces
  double pieces = 0;
};

// Returns a sample after `i`, far away, up to which the deviation is within the tolerance; the next
// sample if there is none. Doubles and then halves the distance.
std::size_t farthestSample(const std::vector<double>& samples, const DeviationBetween& deviation,
                           double tolerance, std::size_t i) {
  const auto isWithin = [&](std::size_t j) {
    return j < samples.size() && deviation(samples[i], samples[j]) <= tolerance;
  };
  std::size_t j = i + 1, more = 1;
  for (; isWithin(j + more); more *= 2) j += more;
  for (more /= 2; more > 0; more /= 2) {
    if (isWithin(j + more)) j += more;
  }
  return j;
}

// Cuts from the left, each time as far on as the tolerance allows: over several samples, or over an
// equal part of one arc.
Cuts cutsWithin(const std::vector<double>& samples, const DeviationBetween& deviation,
                double tolerance, int most) {
  Cuts cuts{{0}, 0};
  for (std::size_t i = 0; i + 1 < samples.size();) {
    const std::size_t j = farthestSample(samples, deviation, tolerance, i);
    double parts = 1;
    if (j == i + 1) {
      parts = std::ceil(std::sqrt(deviation(samples[i], samples[j]) / tolerance));
      parts = std::max(parts, 1.0);
    }
    cuts.pieces += parts;
    for (int k = 1; k < parts && cuts.pieces <= most; ++k) {
      cuts.at.push_back(samples[i] + (samples[j] - samples[i]) * (k / parts));
    }
    cuts.at.push_back(samples[j]);
    i = j;
  }
  return cuts;
}

}  // namespace

std::vector<double> cutInterval(const std::vector<double>& samples,
                                const DeviationBetween& deviation, double tolerance, int most) {
  Cuts cuts = cutsWithin(samples, deviation, tolerance, most);
  // On one arc, n parts reduce the deviation by n^2. So the tolerance grows by the square of how
  // many times too many pieces there are, and always by some, so that the loop ends.
  while (cuts.pieces > most) {
    const double ratio = std::min(cuts.pieces / most, 1e100);
    tolerance *= std::max(ratio * ratio, 1.05);
    cuts = cutsWithin(samples, deviation, tolerance, most);
  }
  return cuts.at;
}

SubStepScene::SubStepScene(const Scene& whole,
                           const std::vector<std::optional<BodyMotion>>& motions,
                           double tolerance_m, Scene* scene)
    : whole_(&whole),
      motions_(&motions),
      tolerance_m_(tolerance_m),
      horizon_(tolerance_m / roundingAt(1)),
      scene_(scene),
      straight_(whole.bodyCount()) {
  for (const auto& motion : motions) {
    if (motion) horizon_ = std::max(horizon_, kFarOff * motion->farthest());
  }
  *scene_ = whole;
  for (const auto& [a, b] : whole.enabledPairs()) {
    if (a == b || (!motions[a] && !motions[b])) scene_->setPairEnabled(a, b, false);
  }
}

std::vector<double> SubStepScene::cuts(int most) const {
  std::vector<double> samples;
  for (const auto& motion : *motions_) {
    if (!motion) continue;
    for (const PoseSample& sample : motion->path()) samples.push_back(sample.at);
  }
  std::sort(samples.begin(), samples.end());
  samples.erase(std::unique(samples.begin(), samples.end()), samples.end());
  return cutInterval(
      samples, [this](double from, double to) { return deviation(from, to); }, tolerance_m_, most);
}

// Returns the largest deviation of all bodies that rotate [m].
double SubStepScene::deviation(double from, double to) const {
  double most = 0;
  for (const auto& motion : *motions_) {
    if (motion) most = std::max(most, motion->deviation(from, to));
  }
  return most;
}

void SubStepScene::moveTo(double from, double to) {
  for (BodyId id = 0; id < scene_->bodyCount(); ++id) {
    if (!scene_->takesPart(id)) continue;
    double pad_m = whole_->body(id).pad_m;
    if ((*motions_)[id]) {
      pad_m += moveRotating(id, from, to);
    } else if (!isStill(whole_->body(id)) && !(from == 0 && to == 1)) {
      pad_m += moveStraight(id, from, to);
    }
    scene_->setPad(id, roundedUp(pad_m * kSlackOfSum));
  }
}

double SubStepScene::moveRotating(BodyId id, double from, double to) {
  const BodyMotion& motion = *(*motions_)[id];
  const std::vector<float> vertices = motion.verticesAt(to);
  if (!vertices.empty()) scene_->setVertices(id, vertices.data(), vertices.size() / 3);
  scene_->setPose(id, motion.poseAt(to));
  scene_->setEarlier(id, motion.poseAt(from), motion.verticesAt(from));
  return motion.deviation(from, to) + motion.rounding();
}

// Vertices beyond the horizon would make rounding, and so the pads, large. They are set to NaN,
// which removes their triangles, and the body is reported as outlying.
SubStepScene::Straight SubStepScene::straightMotion(const Body& body) const {
  if (body.device_vertices) {
    throw std::invalid_argument(body.name +
                                ": its vertices are on a device, where sub-steps of a "
                                "body that turns cannot be made");
  }
  const std::size_t count = body.mesh.vertexCount();
  Straight straight{posed(PosedBody::earlier(body), count), posed(PosedBody(body), count), 0,
                    false};
  double farthest = 0;  // from the origin, of the vertices that are rounded [m]
  for (std::size_t i = 0; i + 2 < straight.from.size(); i += 3) {
    float *from = &straight.from[i], *to = &straight.to[i];
    const double distance = std::max(distanceOf(from), distanceOf(to));
    if (std::equal(from, from + 3, to) || !std::isfinite(distance)) continue;
    if (distance > horizon_) {
      straight.has_outliers = true;
      std::fill(to, to + 3, NAN);
    } else {
      farthest = std::max(farthest, distance);
    }
  }
  straight.rounding = roundingAt(farthest);
  return straight;
}

// The vertices move straight in the scene frame, so both states are set there, with identity poses.
double SubStepScene::moveStraight(BodyId id, double from, double to) {
  std::optional<Straight>& straight = straight_[id];
  if (!straight) straight = straightMotion(whole_->body(id));
  const std::vector<float> vertices = verticesBetween(straight->from, straight->to, to);
  scene_->setVertices(id, vertices.data(), vertices.size() / 3);
  scene_->setPose(id, RigidTransform());
  scene_->setEarlier(id, RigidTransform(), verticesBetween(straight->from, straight->to, from));
  return straight->rounding;
}

float SubStepScene::largestPad() const {
  double most = 0;
  for (const auto& [a, b] : scene_->enabledPairs()) {
    most = std::max(most, static_cast<double>(scene_->body(a).pad_m) + scene_->body(b).pad_m);
  }
  return roundedUp(most);
}

std::vector<BodyId> SubStepScene::outlying() const {
  std::vector<BodyId> bodies;
  for (BodyId id = 0; id < straight_.size(); ++id) {
    if (straight_[id] && straight_[id]->has_outliers) bodies.push_back(id);
  }
  return bodies;
}

}  // namespace deformable_contact_monitor
