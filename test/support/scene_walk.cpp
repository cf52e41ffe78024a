#include "scene_walk.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostBodies = 6;

std::string nameOf(BodyId id) { return " of body " + std::to_string(id); }

}  // namespace

SceneWalk::SceneWalk(std::uint32_t seed) : random_(seed) {
  addBody();
  addBody();
  switchAll();
}

std::string SceneWalk::step() {
  // Those that move things are common, so that scenes live on for a while.
  static constexpr Change kChanges[] = {
      &SceneWalk::moveAll,       &SceneWalk::moveAll,
      &SceneWalk::moveAll,       &SceneWalk::moveOne,
      &SceneWalk::moveOne,       &SceneWalk::pose,
      &SceneWalk::pose,          &SceneWalk::switchPair,
      &SceneWalk::switchPair,    &SceneWalk::setMargin,
      &SceneWalk::setMargin,     &SceneWalk::replaceMesh,
      &SceneWalk::switchAll,     &SceneWalk::replaceMesh,
      &SceneWalk::makeStrange,   &SceneWalk::scale,
      &SceneWalk::changeMeaning, &SceneWalk::changeSpeedOptions,
      &SceneWalk::addBody,       &SceneWalk::changeWhatMarginsAreFor};
  return (this->*kChanges[below(std::size(kChanges))])();
}

// Cloths through the unit cube, soups in it, single triangles, and nothing at all.
TriangleMesh SceneWalk::randomMesh() {
  const std::size_t kind = below(40);
  if (kind == 0) return {};
  if (kind == 1) return {{0, 0, 0.5F, 1, 0, 0.5F, 0, 1, 0.5F}, {0, 1, 2}};
  // One draw a statement: compilers differ in the order in which they evaluate arguments.
  if (kind < 20) {
    const bool is_large = kind == 2;
    const int cells = is_large ? 20 + static_cast<int>(below(12)) : 1 + static_cast<int>(below(9));
    const float height = unit(), size = is_large ? 1 : 0.5F + unit();
    const float wave = is_large ? 0.2F : 0.4F * unit();
    return clothGrid(cells, size, height, wave);
  }
  const std::size_t vertices = 3 + below(40), triangles = 1 + below(80);
  TriangleMesh mesh;
  const bool on_grid = isOneOf(2);  // touching, coplanar and degenerate ones are common then
  for (std::size_t i = 0; i < 3 * vertices; ++i) {
    mesh.vertices.push_back(on_grid ? 0.25F * static_cast<float>(below(5)) : unit());
  }
  for (std::size_t i = 0; i < 3 * triangles; ++i) {
    mesh.triangles.push_back(static_cast<std::uint32_t>(below(vertices)));
  }
  return mesh;
}

std::string SceneWalk::addBody() {
  if (scene_.bodyCount() == kMostBodies) return replaceMesh();
  const BodyId id = scene_.addBody("body", randomMesh());
  for (BodyId other = 0; other <= id; ++other) scene_.setPairEnabled(id, other, isOneOf(2));
  return "another body";
}

std::string SceneWalk::replaceMesh() {
  const BodyId id = anyBody();
  scene_.setMesh(id, randomMesh());
  return "another mesh" + nameOf(id);
}

void SceneWalk::setVertices(BodyId id, const std::vector<float>& vertices) {
  scene_.setVertices(id, vertices.data(), vertices.size() / 3);
}

std::string SceneWalk::moveAll() {
  const BodyId id = anyBody();
  std::vector<float> vertices = scene_.body(id).mesh.vertices;
  const float by = std::pow(10.0F, -4 * unit());
  for (float& x : vertices) x += by * (unit() - 0.5F);
  setVertices(id, vertices);
  return "all vertices" + nameOf(id);
}

std::string SceneWalk::moveOne() {
  const BodyId id = anyBody();
  std::vector<float> vertices = scene_.body(id).mesh.vertices;
  if (vertices.empty()) return replaceMesh();
  vertices[below(vertices.size())] = unit();
  setVertices(id, vertices);
  return "one vertex" + nameOf(id);
}

std::string SceneWalk::makeStrange() {
  static constexpr float kStrange[] = {std::numeric_limits<float>::quiet_NaN(),
                                       std::numeric_limits<float>::infinity(),
                                       -std::numeric_limits<float>::infinity(),
                                       1e30F,
                                       -3e38F,
                                       1e6F,
                                       1e-40F,
                                       std::numeric_limits<float>::denorm_min(),
                                       -0.0F};
  const BodyId id = anyBody();
  std::vector<float> vertices = scene_.body(id).mesh.vertices;
  if (vertices.empty()) return replaceMesh();
  for (std::size_t i = 0; i <= below(4); ++i) {
    const std::size_t place = below(vertices.size());
    vertices[place] = kStrange[below(std::size(kStrange))];
  }
  setVertices(id, vertices);
  return "strange vertices" + nameOf(id);
}

std::string SceneWalk::scale() {
  const BodyId id = anyBody();
  const int least = isOneOf(2) ? -30 : -4;
  const int exponent = least + static_cast<int>(below(isOneOf(4) ? 60 : 9));
  const auto factor = static_cast<float>(std::pow(10.0, exponent));
  std::vector<float> vertices = scene_.body(id).mesh.vertices;
  for (float& x : vertices) x *= factor;
  setVertices(id, vertices);
  return "the scale" + nameOf(id) + " by 1e" + std::to_string(exponent);
}

std::string SceneWalk::pose() {
  const BodyId id = anyBody();
  RigidTransform pose;
  if (isOneOf(4)) {
    scene_.setPose(id, pose);
    return "no pose" + nameOf(id);
  }
  const double angle = 6.3 * unit();
  pose.rotation[0] = pose.rotation[4] = std::cos(angle);
  pose.rotation[3] = std::sin(angle);
  pose.rotation[1] = -pose.rotation[3];
  static constexpr double kFar[] = {1, 1, 1, 1, 1, 10, 1e6, 1e30, 1e39};
  const double far = kFar[below(std::size(kFar))];
  for (double& x : pose.translation) x = far * (unit() - 0.5);
  scene_.setPose(id, pose);
  return "a pose" + nameOf(id) + " within " + std::to_string(far);
}

std::string SceneWalk::setMargin() {
  static constexpr float kMargins[] = {0, 0, 0, 1e-3F, 0.01F, 0.1F, 1e-40F, 10, 3e38F};
  const BodyId id = anyBody();
  const float margin_m = kMargins[below(std::size(kMargins))];
  scene_.setMargin(id, margin_m);
  return "margin " + std::to_string(margin_m) + nameOf(id);
}

std::string SceneWalk::switchPair() {
  const BodyId a = anyBody(), b = anyBody();
  scene_.setPairEnabled(a, b, !scene_.pairEnabled(a, b));
  return "the pair of " + std::to_string(a) + " and " + std::to_string(b);
}

std::string SceneWalk::switchAll() {
  const bool enabled = !isOneOf(4);
  for (BodyId a = 0; a < scene_.bodyCount(); ++a) {
    for (BodyId b = 0; b <= a; ++b) scene_.setPairEnabled(a, b, enabled);
  }
  return enabled ? "all pairs on" : "all pairs off";
}

std::string SceneWalk::changeSpeedOptions() {
  static constexpr int kClusters[] = {0, 0, 1, 2, 7, 64, kMaxClusters};
  options_.clusters = kClusters[below(std::size(kClusters))];
  options_.fuzzifier = 1.05F + 2 * unit();
  options_.iterations = static_cast<int>(below(3));
  options_.refresh_period = 1 + static_cast<int>(below(3));
  options_.threads = static_cast<int>(below(3));
  return std::to_string(options_.clusters) + " clusters, other speed options";
}

std::string SceneWalk::changeMeaning() {
  options_.adjacent = isOneOf(2) ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
  options_.predicates = isOneOf(3) ? Predicates::kConservative : Predicates::kExact;
  return std::string("options ") + toString(options_.adjacent) + ", " +
         toString(options_.predicates);
}

std::string SceneWalk::changeWhatMarginsAreFor() {
  options_.nearest = !isOneOf(3);
  options_.near_pairs = isOneOf(2);
  return std::string(options_.nearest ? "nearest pairs" : "no nearest pairs") +
         (options_.near_pairs ? ", near pairs" : "");
}

}  // namespace deformable_contact_monitor
