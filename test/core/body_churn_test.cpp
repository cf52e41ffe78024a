// Bodies that come, go, and get other triangles, little by little, so that detectors carry on from
// one scene to the next: after every step the pairs are those of brute force.
#include <algorithm>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "detector_suite.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// A cloth that touches itself, and small things in and about it.
class Churn {
 public:
  explicit Churn(std::uint32_t seed) : random_(seed) {
    TriangleMesh cloth = clothGrid(kSide, 1, 0, 0.05F);
    for (std::size_t i = 0; i < cloth.vertices.size(); i += 3) {  // fold it through itself
      if (cloth.vertices[i] > 0.5F) cloth.vertices[i] = 1 - cloth.vertices[i];
    }
    scene_.addBody("cloth", std::move(cloth));
    scene_.setPairEnabled(0, 0, true);
    for (int i = 0; i < 4; ++i) add();
  }

  // Returns what was changed.
  std::string step() {
    static constexpr std::string (Churn::*kChanges[])() = {
        &Churn::add,       &Churn::takeOut,   &Churn::putBack,     &Churn::empty,
        &Churn::remesh,    &Churn::growCloth, &Churn::shrinkCloth, &Churn::turnTriangles,
        &Churn::moveCloth, &Churn::moveSmall, &Churn::switchSelf,  &Churn::moveSmall,
        &Churn::moveCloth, &Churn::otherAway};
    return (this->*kChanges[random_() % std::size(kChanges)])();
  }

  const Scene& scene() const { return scene_; }

 private:
  static constexpr int kSide = 15;
  static constexpr std::size_t kMostBodies = 12;

  float unit() { return static_cast<float>(random_()) * 0x1p-32F; }
  BodyId anySmall() { return 1 + static_cast<BodyId>(random_() % (scene_.bodyCount() - 1)); }
  TriangleMesh smallMesh() {
    const int n = 1 + static_cast<int>(random_() % 3);
    const float size = 0.05F + 0.2F * unit();
    return clothGrid(n, size, 0.1F * unit() - 0.05F, 0.1F * unit());
  }
  void place(BodyId id) {
    RigidTransform pose;
    pose.translation[0] = 0.6 * unit();
    pose.translation[1] = unit();
    scene_.setPose(id, pose);
  }

  std::string add() {
    if (scene_.bodyCount() == kMostBodies) return remesh();
    const BodyId id = scene_.addBody("small", smallMesh());
    scene_.setPairEnabled(0, id, true);
    if (id > 1) scene_.setPairEnabled(id - 1, id, unit() < 0.5F);
    place(id);
    return "another body";
  }
  std::string takeOut() {
    const BodyId id = anySmall();
    for (BodyId other = 0; other < scene_.bodyCount(); ++other) {
      scene_.setPairEnabled(id, other, false);
    }
    return "body " + std::to_string(id) + " taken out";
  }
  std::string putBack() {
    const BodyId id = anySmall();
    scene_.setPairEnabled(0, id, true);
    return "body " + std::to_string(id) + " put back";
  }
  std::string empty() {
    const BodyId id = anySmall();
    scene_.setMesh(id, {});
    return "body " + std::to_string(id) + " without triangles";
  }
  std::string remesh() {
    const BodyId id = anySmall();
    scene_.setMesh(id, smallMesh());
    return "another mesh of body " + std::to_string(id);
  }
  // Some triangles more at its end, with a vertex of their own.
  std::string growCloth() {
    TriangleMesh mesh = scene_.body(0).mesh;
    const auto before = static_cast<std::uint32_t>(mesh.vertexCount());
    for (std::uint32_t i = 0; i < 5; ++i) {
      mesh.vertices.insert(mesh.vertices.end(), {unit(), unit(), 0.2F * unit() - 0.1F});
      const std::uint32_t at = random_() % before;
      mesh.triangles.insert(mesh.triangles.end(), {at, (at + 1) % before, before + i});
    }
    scene_.setMesh(0, std::move(mesh));
    return "a larger cloth";
  }
  std::string shrinkCloth() {
    TriangleMesh mesh = scene_.body(0).mesh;
    const std::size_t kept = mesh.triangleCount() - std::min<std::size_t>(8, mesh.triangleCount());
    mesh.triangles.resize(3 * std::max<std::size_t>(kept, 200));
    scene_.setMesh(0, std::move(mesh));
    return "a smaller cloth";
  }
  // As many triangles between the same vertices, others.
  std::string turnTriangles() {
    TriangleMesh mesh = scene_.body(0).mesh;
    const std::size_t first = 3 * (random_() % mesh.triangleCount());
    std::rotate(mesh.triangles.begin(), mesh.triangles.begin() + static_cast<std::ptrdiff_t>(first),
                mesh.triangles.end());
    std::swap(mesh.triangles[0], mesh.triangles[1]);
    scene_.setMesh(0, std::move(mesh));
    return "another order of the cloth's triangles";
  }
  std::string moveCloth() {
    std::vector<float> vertices = scene_.body(0).mesh.vertices;
    for (float& x : vertices) x += 0.01F * (unit() - 0.5F);
    scene_.setVertices(0, vertices.data(), vertices.size() / 3);
    return "the cloth moved";
  }
  std::string moveSmall() {
    const BodyId id = anySmall();
    place(id);
    return "body " + std::to_string(id) + " moved";
  }
  std::string switchSelf() {
    const BodyId id = anySmall();
    scene_.setPairEnabled(id, id, !scene_.pairEnabled(id, id));
    return "self-contacts of body " + std::to_string(id);
  }
  // Adds bodies in another place, which may be far from all clusters.
  std::string otherAway() {
    const BodyId id = anySmall(), other = anySmall();
    scene_.setMesh(id, clothGrid(2, 0.3F, 40, 0.1F));
    scene_.setMesh(other, clothGrid(3, 0.3F, 40, 0.05F));
    if (id != other) scene_.setPairEnabled(id, other, true);
    return "bodies " + std::to_string(id) + " and " + std::to_string(other) + " far away";
  }

  std::mt19937 random_;
  Scene scene_;
};

class BodyChurn : public DetectorSuite {};

TEST_P(BodyChurn, PairsAreThoseOfBruteForceAfterEveryStep) {
  const auto brute_force = makeBruteForceDetector();
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    Churn churn(seed);
    Options options;
    options.clusters = seed == 1 ? 0 : 6;
    std::size_t with_contacts = 0;
    for (int i = 0; i < 80; ++i) {
      const std::string change = churn.step();
      options.adjacent = i / 7 % 2 == 0 ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
      const auto expected = brute_force->detect(churn.scene(), options).contacts;
      with_contacts += expected.empty() ? 0 : 1;
      ASSERT_TRUE(samePairs(expected, contacts(churn.scene(), options)))
          << "seed " << seed << ", step " << i << ": " << change;
    }
    EXPECT_GT(with_contacts, 60U);
  }
}

// By a hundredth a cycle, to four times its size and back.
TEST_P(BodyChurn, ASceneThatGrowsAndShrinksHasAllItsPairs) {
  const auto brute_force = makeBruteForceDetector();
  TriangleMesh whole = clothGrid(20, 1, 0, 0.05F);
  for (std::size_t i = 0; i < whole.vertices.size(); i += 3) {
    if (whole.vertices[i + 1] > 0.5F) whole.vertices[i + 1] = 1 - whole.vertices[i + 1];
  }
  Scene scene = selfScene(whole);
  Options options;
  options.clusters = 5;
  double share = 0.25;
  for (const double factor : {1.01, 1 / 1.01}) {
    for (; share <= 1 && share >= 0.25; share *= factor) {
      TriangleMesh part = whole;
      part.triangles.resize(3 * static_cast<std::size_t>(share * 800));
      scene.setMesh(0, part);
      const auto expected = brute_force->detect(scene, options).contacts;
      ASSERT_TRUE(samePairs(expected, contacts(scene, options))) << share;
    }
    share = std::min(share, 1.0);
  }
}

INSTANTIATE_TEST_SUITE_P(, BodyChurn, ::testing::ValuesIn(productBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
