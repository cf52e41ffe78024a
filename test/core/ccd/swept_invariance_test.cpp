// Changes that must not change the result of continuous detection: orders, axes, scale, welding,
// and a motion that all bodies have in common.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "scenes.h"
#include "swept_expected.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::uint32_t kScenes = 120;

using Order = std::vector<std::uint32_t>;

Order shuffled(std::size_t count, std::mt19937* random) {
  Order order(count);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), *random);
  return order;
}

// A step without poses: bodies' earlier and later meshes.
struct Step {
  std::vector<TriangleMesh> from, to;
  std::vector<std::pair<BodyId, BodyId>> pairs;

  explicit Step(const Scene& scene) : pairs(scene.enabledPairs()) {
    for (const Body& body : scene.bodies()) {
      to.push_back(body.mesh);
      from.push_back(body.mesh);
      from.back().vertices = body.earlier->vertices;
    }
  }

  Scene scene() const {
    Scene out;
    for (std::size_t b = 0; b < to.size(); ++b) {
      const BodyId id = out.addBody("body " + std::to_string(b), to[b]);
      out.setEarlier(id, RigidTransform(), from[b].vertices);
    }
    for (const auto& [a, b] : pairs) out.setPairEnabled(a, b, true);
    return out;
  }

  // map(vertex, whether at the step's end)
  template <class Map>
  void mapAll(const Map& map) {
    for (std::size_t b = 0; b < to.size(); ++b) {
      for (const bool end : {false, true}) {
        HostList<float>& xyz = (end ? to : from)[b].vertices;
        for (std::size_t i = 0; i < xyz.size(); i += 3) {
          const Vec3f v = map(Vec3f{xyz[i], xyz[i + 1], xyz[i + 2]}, end);
          xyz[i] = v.x;
          xyz[i + 1] = v.y;
          xyz[i + 2] = v.z;
        }
      }
    }
  }
};

// Names for bodies and triangles: to[body][triangle] for [body, triangle].
struct Names {
  Order body;
  std::vector<Order> triangle;

  explicit Names(const Step& step) {
    for (const TriangleMesh& mesh : step.to) {
      body.push_back(static_cast<std::uint32_t>(body.size()));
      triangle.emplace_back(mesh.triangleCount());
      std::iota(triangle.back().begin(), triangle.back().end(), 0);
    }
  }

  TrianglePair of(const TrianglePair& p) const {
    const auto a = std::make_pair(body[p.body_a], triangle[p.body_a][p.triangle_a]);
    const auto b = std::make_pair(body[p.body_b], triangle[p.body_b][p.triangle_b]);
    const auto& [first, second] = std::minmax(a, b);
    return {first.first, first.second, second.first, second.second};
  }
};

class SweptInvariance : public SweptFixture {
 protected:
  // change(step, names, random) changes both, so that contacts keep their names; times stay.
  template <class Change>
  void expectNoChange(const Change& change) {
    std::size_t found = 0;
    for (std::uint32_t seed = 0; seed < kScenes; ++seed) {
      std::mt19937 random(seed);
      Step step(integerSweptScene(seed));
      const AdjacentPairs adjacent = kBothAdjacent[seed % 2];
      Options options = timedOptions(adjacent);
      options.clusters = static_cast<int>(seed % 4);
      const DetectionResult before = detector_->detect(step.scene(), options);
      Names names(step);
      change(&step, &names, &random);
      const DetectionResult& after = detector_->detect(step.scene(), options);
      std::vector<TrianglePair> expected;
      for (const TrianglePair& p : before.contacts) expected.push_back(names.of(p));
      std::vector<TrianglePair> sorted = expected;
      std::sort(sorted.begin(), sorted.end());
      ASSERT_TRUE(samePairs(sorted, after.contacts)) << "seed " << seed;
      for (std::size_t i = 0; i < expected.size(); ++i) {
        const auto place = std::lower_bound(sorted.begin(), sorted.end(), expected[i]);
        const FirstContact& a = before.first_times[i];
        const FirstContact& b = after.first_times[static_cast<std::size_t>(place - sorted.begin())];
        ASSERT_TRUE(a.low <= b.high && b.low <= a.high) << "seed " << seed << ", " << expected[i];
      }
      found += expected.size();
    }
    EXPECT_GT(found, 3 * kScenes);
  }

  template <class Map>
  void expectNoChangeBy(const Map& map) {
    expectNoChange([&map](Step* step, Names*, std::mt19937*) { step->mapAll(map); });
  }
};

TEST_P(SweptInvariance, OrderOfTriangles) {
  expectNoChange([](Step* step, Names* names, std::mt19937* random) {
    for (std::size_t b = 0; b < step->to.size(); ++b) {
      const TriangleMesh old = step->to[b];
      names->triangle[b] = shuffled(old.triangleCount(), random);
      for (std::size_t t = 0; t < old.triangleCount(); ++t) {
        std::copy_n(&old.triangles[3 * t], 3,
                    &step->to[b].triangles[3 * std::size_t{names->triangle[b][t]}]);
      }
      step->from[b].triangles = step->to[b].triangles;
    }
  });
}

TEST_P(SweptInvariance, OrderOfVerticesAndCorners) {
  expectNoChange([](Step* step, Names*, std::mt19937* random) {
    for (std::size_t b = 0; b < step->to.size(); ++b) {
      TriangleMesh &from = step->from[b], &to = step->to[b];
      const TriangleMesh old_from = from, old_to = to;
      const Order order = shuffled(to.vertexCount(), random);
      for (std::size_t v = 0; v < order.size(); ++v) {
        const std::size_t place = 3 * std::size_t{order[v]};
        std::copy_n(&old_from.vertices[3 * v], 3, &from.vertices[place]);
        std::copy_n(&old_to.vertices[3 * v], 3, &to.vertices[place]);
      }
      for (std::uint32_t& corner : to.triangles) corner = order[corner];
      for (std::size_t t = 0; t < to.triangleCount(); ++t) {
        std::shuffle(&to.triangles[3 * t], &to.triangles[3 * t] + 3, *random);
      }
      from.triangles = to.triangles;
    }
  });
}

TEST_P(SweptInvariance, OrderOfBodies) {
  expectNoChange([](Step* step, Names* names, std::mt19937*) {
    std::reverse(step->from.begin(), step->from.end());
    std::reverse(step->to.begin(), step->to.end());
    std::reverse(names->body.begin(), names->body.end());
    for (auto& [a, b] : step->pairs) {
      a = names->body[a];
      b = names->body[b];
    }
  });
}

TEST_P(SweptInvariance, ScalingByPowersOfTwo) {
  for (const int power : {-149, -100, -20, 7, 100}) {
    expectNoChangeBy([power](const Vec3f& v, bool) {
      return Vec3f{std::ldexp(v.x, power), std::ldexp(v.y, power), std::ldexp(v.z, power)};
    });
  }
}

TEST_P(SweptInvariance, AxesAndMirrors) {
  expectNoChangeBy([](const Vec3f& v, bool) { return Vec3f{v.y, v.z, v.x}; });
  expectNoChangeBy([](const Vec3f& v, bool) { return Vec3f{v.x, -v.z, v.y}; });
  expectNoChangeBy([](const Vec3f& v, bool) { return Vec3f{-v.x, v.y, v.z}; });
}

// Integers, so that sums are exact.
TEST_P(SweptInvariance, OneTranslationOfAllInEachState) {
  expectNoChangeBy([](const Vec3f& v, bool) { return v + Vec3f{5, -3, 700}; });
  expectNoChangeBy([](const Vec3f& v, bool end) {
    return v + (end ? Vec3f{-9, 64, 2} : Vec3f{5, -3, 70});
  });
  expectNoChangeBy([](const Vec3f& v, bool end) {
    return v + Vec3f{0, 0, end ? 1048576.0F : 0.0F};
  });
}

// Tests soups, and meshes in which vertices that are equal in both states have one index.
TEST_P(SweptInvariance, SoupsAndWeldedMeshes) {
  expectNoChange([](Step* step, Names*, std::mt19937*) {
    for (std::size_t b = 0; b < step->to.size(); ++b) {
      step->from[b] = soupOf(step->from[b]);
      step->to[b] = soupOf(step->to[b]);
    }
  });
  expectNoChange([](Step* step, Names*, std::mt19937*) {
    for (std::size_t b = 0; b < step->to.size(); ++b) {
      TriangleMesh &from = step->from[b], &to = step->to[b];
      for (std::uint32_t& index : to.triangles) {
        for (std::uint32_t other = 0; other < index; ++other) {
          if (from.vertex(other) != from.vertex(index)) continue;
          if (to.vertex(other) != to.vertex(index)) continue;
          index = other;
          break;
        }
      }
      from.triangles = to.triangles;
    }
  });
}

INSTANTIATE_TEST_SUITE_P(, SweptInvariance, ::testing::ValuesIn(sweptBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
