// Changes that must not change the result: orders, the place of the scene, and its scale.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "detector_suite.h"

namespace deformable_contact_monitor {
namespace {

using Order = std::vector<std::uint32_t>;

Order shuffled(std::size_t count, std::mt19937* random) {
  Order order(count);
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), *random);
  return order;
}

// Three bodies, all pairs enabled: triangles on a small grid, where touching and coplanar ones are
// common, or anywhere.
std::vector<TriangleMesh> randomMeshes(std::mt19937* random, bool on_grid) {
  std::vector<TriangleMesh> meshes(3);
  for (TriangleMesh& mesh : meshes) {
    for (int i = 0; i < 60; ++i) {
      mesh.vertices.push_back(on_grid ? static_cast<float>((*random)() % 5)
                                      : 5 * static_cast<float>((*random)() % 65536) / 65536);
    }
    for (int i = 0; i < 3 * 25; ++i) mesh.triangles.push_back((*random)() % 20);
  }
  return meshes;
}

Scene sceneOf(const std::vector<TriangleMesh>& meshes) {
  Scene scene;
  for (const TriangleMesh& mesh : meshes) {
    const BodyId id = scene.addBody("body", mesh);
    for (BodyId other = 0; other <= id; ++other) scene.setPairEnabled(other, id, true);
  }
  return scene;
}

// Names for bodies and triangles: to[body][triangle] for [body, triangle].
struct Names {
  Order body;
  std::vector<Order> triangle;

  static Names same(const std::vector<TriangleMesh>& meshes) {
    Names names;
    for (const TriangleMesh& mesh : meshes) {
      names.body.push_back(static_cast<std::uint32_t>(names.body.size()));
      names.triangle.emplace_back(mesh.triangleCount());
      std::iota(names.triangle.back().begin(), names.triangle.back().end(), 0);
    }
    return names;
  }
};

std::vector<TrianglePair> renamed(const std::vector<TrianglePair>& pairs, const Names& to) {
  std::vector<TrianglePair> out;
  for (const TrianglePair& p : pairs) {
    TrianglePair q{to.body[p.body_a], to.triangle[p.body_a][p.triangle_a], to.body[p.body_b],
                   to.triangle[p.body_b][p.triangle_b]};
    if (std::make_pair(q.body_b, q.triangle_b) < std::make_pair(q.body_a, q.triangle_a)) {
      std::swap(q.body_a, q.body_b);
      std::swap(q.triangle_a, q.triangle_b);
    }
    out.push_back(q);
  }
  std::sort(out.begin(), out.end());
  return out;
}

class Invariance : public DetectorSuite {
 protected:
  static constexpr unsigned kScenes = 30;

  // change(meshes, names, random) changes both, so that contacts keep their names.
  template <class Change>
  void expectNoChange(const Change& change) {
    std::size_t found = 0;
    for (unsigned seed = 0; seed < kScenes; ++seed) {
      std::mt19937 random(seed);
      std::vector<TriangleMesh> meshes = randomMeshes(&random, seed % 2 == 0);
      for (const AdjacentPairs adjacent : kBothAdjacent) {
        Options options = withAdjacent(adjacent);
        options.clusters = static_cast<int>(seed % 4) * 3;
        const std::vector<TrianglePair> before = contacts(sceneOf(meshes), options);
        std::vector<TriangleMesh> changed = meshes;
        Names names = Names::same(meshes);
        change(&changed, &names, &random);
        const std::vector<TrianglePair> after = contacts(sceneOf(changed), options);
        ASSERT_TRUE(samePairs(renamed(before, names), after)) << "seed " << seed;
        found += before.size();
      }
    }
    EXPECT_GT(found, 1000U);
  }
};

TEST_P(Invariance, OrderOfTriangles) {
  expectNoChange([](std::vector<TriangleMesh>* meshes, Names* names, std::mt19937* random) {
    for (std::size_t b = 0; b < meshes->size(); ++b) {
      TriangleMesh& mesh = (*meshes)[b];
      const TriangleMesh old = mesh;
      names->triangle[b] = shuffled(mesh.triangleCount(), random);
      for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
        std::copy_n(&old.triangles[3 * t], 3,
                    &mesh.triangles[3 * std::size_t{names->triangle[b][t]}]);
      }
    }
  });
}

TEST_P(Invariance, OrderOfVerticesAndOfATrianglesCorners) {
  expectNoChange([](std::vector<TriangleMesh>* meshes, Names*, std::mt19937* random) {
    for (TriangleMesh& mesh : *meshes) {
      const TriangleMesh old = mesh;
      const Order order = shuffled(mesh.vertexCount(), random);
      for (std::size_t v = 0; v < order.size(); ++v) {
        std::copy_n(&old.vertices[3 * v], 3, &mesh.vertices[3 * std::size_t{order[v]}]);
      }
      for (std::uint32_t& corner : mesh.triangles) corner = order[corner];
      for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
        std::shuffle(&mesh.triangles[3 * t], &mesh.triangles[3 * t] + 3, *random);
      }
    }
  });
}

TEST_P(Invariance, OrderOfBodies) {
  expectNoChange([](std::vector<TriangleMesh>* meshes, Names* names, std::mt19937* random) {
    const std::vector<TriangleMesh> old = *meshes;
    names->body = shuffled(old.size(), random);
    for (std::size_t b = 0; b < old.size(); ++b) (*meshes)[names->body[b]] = old[b];
  });
}

TEST_P(Invariance, ScalingByPowersOfTwo) {
  for (const int power : {-100, -20, 7, 90}) {
    expectNoChange([power](std::vector<TriangleMesh>* meshes, Names*, std::mt19937*) {
      for (TriangleMesh& mesh : *meshes) {
        for (float& x : mesh.vertices) x = std::ldexp(x, power);
      }
    });
  }
}

// Coordinates are multiples of 2^-16 below 5, so the sums are exact.
TEST_P(Invariance, TranslatingWhereThatIsExact) {
  for (const float shift : {-8.0F, 64.0F, 123.0F}) {
    expectNoChange([shift](std::vector<TriangleMesh>* meshes, Names*, std::mt19937*) {
      for (TriangleMesh& mesh : *meshes) {
        for (float& x : mesh.vertices) {
          ASSERT_EQ((x + shift) - shift, x);
          x += shift;
        }
      }
    });
  }
}

TEST_P(Invariance, Mirroring) {
  expectNoChange([](std::vector<TriangleMesh>* meshes, Names*, std::mt19937*) {
    for (TriangleMesh& mesh : *meshes) {
      for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
        mesh.vertices[i] = -mesh.vertices[i];
        std::swap(mesh.vertices[i + 1], mesh.vertices[i + 2]);
      }
    }
  });
}

INSTANTIATE_TEST_SUITE_P(, Invariance, ::testing::ValuesIn(allBackends()), backendName);

}  // namespace
}  // namespace deformable_contact_monitor
