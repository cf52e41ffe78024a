#include "core/ccd/turning_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/ccd/step_cuts.h"
#include "core/common/posed_body.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kFarOff = 16;

// So that two pads' sum, rounded to float32, is no smaller than what they stand for.
constexpr double kSlackOfSum = 1 + 0x1p-22;

bool isStill(const Body& body) {
  return !body.earlier ||
         (body.earlier->vertices.empty() && samePose(body.earlier->pose, body.pose));
}

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

float roundedUp(double x) {
  const auto near = static_cast<float>(x);
  return near < x ? std::nextafter(near, INFINITY) : near;
}

}  // namespace

TurningScene::TurningScene(const Scene& step, const std::vector<std::optional<BodyMotion>>& motions,
                           double tolerance_m, Scene* scene)
    : step_(&step),
      motions_(&motions),
      tolerance_m_(tolerance_m),
      horizon_(tolerance_m / roundingAt(1)),
      scene_(scene),
      straight_(step.bodyCount()) {
  for (const auto& motion : motions) {
    if (motion) horizon_ = std::max(horizon_, kFarOff * motion->farthest());
  }
  *scene_ = step;
  for (const auto& [a, b] : step.enabledPairs()) {
    if (a == b || (!motions[a] && !motions[b])) scene_->setPairEnabled(a, b, false);
  }
}

std::vector<double> TurningScene::cuts(int most) const {
  std::vector<double> bends;
  for (const auto& motion : *motions_) {
    if (!motion) continue;
    for (const PoseSample& sample : motion->path()) bends.push_back(sample.at);
  }
  std::sort(bends.begin(), bends.end());
  bends.erase(std::unique(bends.begin(), bends.end()), bends.end());
  return cutStep(
      bends, [this](double from, double to) { return deviation(from, to); }, tolerance_m_, most);
}

double TurningScene::deviation(double from, double to) const {
  double most = 0;
  for (const auto& motion : *motions_) {
    if (motion) most = std::max(most, motion->deviation(from, to));
  }
  return most;
}

void TurningScene::moveTo(double from, double to) {
  for (BodyId id = 0; id < scene_->bodyCount(); ++id) {
    if (!scene_->takesPart(id)) continue;
    double pad_m = step_->body(id).pad_m;
    if ((*motions_)[id]) {
      pad_m += moveTurning(id, from, to);
    } else if (!isStill(step_->body(id)) && !(from == 0 && to == 1)) {
      pad_m += moveStraight(id, from, to);
    }
    scene_->setPad(id, roundedUp(pad_m * kSlackOfSum));
  }
}

double TurningScene::moveTurning(BodyId id, double from, double to) {
  const BodyMotion& motion = *(*motions_)[id];
  const std::vector<float> vertices = motion.verticesAt(to);
  if (!vertices.empty()) scene_->setVertices(id, vertices.data(), vertices.size() / 3);
  scene_->setPose(id, motion.poseAt(to));
  scene_->setEarlier(id, motion.poseAt(from), motion.verticesAt(from));
  return motion.deviation(from, to) + motion.rounding();
}

TurningScene::Straight TurningScene::straightMotion(const Body& body) const {
  if (body.device_vertices) {
    throw std::invalid_argument(body.name +
                                ": its vertices are on a device, where sub-steps of a "
                                "body that turns cannot be made");
  }
  const std::size_t count = body.mesh.vertexCount();
  Straight straight{posed(PosedBody::earlier(body), count), posed(PosedBody(body), count), 0,
                    false};
  double farthest = 0;  // of those that are rounded
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

// Both states are given in the scene frame: its vertices move straight there.
double TurningScene::moveStraight(BodyId id, double from, double to) {
  std::optional<Straight>& straight = straight_[id];
  if (!straight) straight = straightMotion(step_->body(id));
  const std::vector<float> vertices = verticesBetween(straight->from, straight->to, to);
  scene_->setVertices(id, vertices.data(), vertices.size() / 3);
  scene_->setPose(id, RigidTransform());
  scene_->setEarlier(id, RigidTransform(), verticesBetween(straight->from, straight->to, from));
  return straight->rounding;
}

float TurningScene::largestPad() const {
  double most = 0;
  for (const auto& [a, b] : scene_->enabledPairs()) {
    most = std::max(most, static_cast<double>(scene_->body(a).pad_m) + scene_->body(b).pad_m);
  }
  return roundedUp(most);
}

std::vector<BodyId> TurningScene::outlying() const {
  std::vector<BodyId> bodies;
  for (BodyId id = 0; id < straight_.size(); ++id) {
    if (straight_[id] && straight_[id]->has_outliers) bodies.push_back(id);
  }
  return bodies;
}

}  // namespace deformable_contact_monitor
