#include "core/turning_scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/posed_body.h"
#include "core/step_cuts.h"

namespace deformable_contact_monitor {
namespace {

// So that two pads' sum, rounded to float32, is no smaller than what they stand for.
constexpr double kSlackOfSum = 1 + 0x1p-22;

bool isStill(const Body& body) {
  return !body.earlier ||
         (body.earlier->vertices.empty() && samePose(body.earlier->pose, body.pose));
}

std::vector<float> posed(const Body& body) {
  const PosedBody at_pose(body);
  std::vector<float> vertices;
  vertices.reserve(body.mesh.vertices.size());
  for (std::size_t i = 0; i < body.mesh.vertexCount(); ++i) {
    const Vec3f v = at_pose.vertex(i);
    vertices.insert(vertices.end(), {v.x, v.y, v.z});
  }
  return vertices;
}

// Of finite vertices.
double farthest(const std::vector<float>& vertices) {
  double most = 0;
  for (std::size_t i = 0; i + 2 < vertices.size(); i += 3) {
    const double x = vertices[i], y = vertices[i + 1], z = vertices[i + 2];
    const double distance = std::sqrt(x * x + y * y + z * z);
    if (std::isfinite(distance)) most = std::max(most, distance);
  }
  return most;
}

float roundedUp(double x) {
  const auto near = static_cast<float>(x);
  return near < x ? std::nextafter(near, INFINITY) : near;
}

}  // namespace

TurningScene::TurningScene(const Scene& step, const std::vector<std::optional<BodyMotion>>& motions,
                           Scene* scene)
    : step_(&step), motions_(&motions), scene_(scene), straight_(step.bodyCount()) {
  *scene_ = step;
  for (const auto& [a, b] : step.enabledPairs()) {
    if (a == b || (!motions[a] && !motions[b])) scene_->setPairEnabled(a, b, false);
  }
}

std::vector<double> TurningScene::cuts(double tolerance_m, int most) const {
  std::vector<double> bends;
  for (const auto& motion : *motions_) {
    if (!motion) continue;
    for (const PoseSample& sample : motion->path()) bends.push_back(sample.at);
  }
  std::sort(bends.begin(), bends.end());
  bends.erase(std::unique(bends.begin(), bends.end()), bends.end());
  return cutStep(
      bends, [this](double from, double to) { return deviation(from, to); }, tolerance_m, most);
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

TurningScene::Straight TurningScene::straightMotion(const Body& body) {
  if (body.device_vertices) {
    throw std::invalid_argument(body.name +
                                ": its vertices are on a device, where sub-steps of a "
                                "body that turns cannot be made");
  }
  Straight straight{posed(earlierBody(body)), posed(body), 0};
  straight.rounding = roundingAt(std::max(farthest(straight.from), farthest(straight.to)));
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

}  // namespace deformable_contact_monitor
