// Triangle pairs on which published codes went wrong, in all 72 orders.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cgal_oracle.h"
#include "detector_suite.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

struct Vector {
  std::string name;
  Triangle a, b;  // rounded to float32
  bool meet;      // after rounding
};

std::vector<Vector> readVectors() {
  std::ifstream file(testDataFile("../reference/vectors.json"));
  std::vector<Vector> vectors;
  for (const auto& entry : nlohmann::json::parse(file)) {
    const auto triangle = [&entry](const char* key) {
      Triangle t;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto x = entry.at(key).at(k).get<std::array<double, 3>>();
        t.v[k] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
      }
      return t;
    };
    vectors.push_back({entry.at("name").get<std::string>(), triangle("A"), triangle("B"),
                       entry.at("exact32").get<bool>()});
  }
  return vectors;
}

std::vector<Triangle> orders(const Triangle& t) {
  std::vector<Triangle> all;
  std::array<int, 3> order = {0, 1, 2};
  do {
    all.push_back({{t.v[order[0]], t.v[order[1]], t.v[order[2]]}});
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

class PredicateVectors : public DetectorSuite {};

TEST_P(PredicateVectors, HoldInAll72Orders) {
  DCM_REQUIRE_TEST_DATA();
  const std::vector<Vector> vectors = readVectors();
  ASSERT_EQ(38U, vectors.size());
  for (const Vector& vector : vectors) {
    int wrong = 0;
    for (const Triangle& a : orders(vector.a)) {
      for (const Triangle& b : orders(vector.b)) {
        wrong += contacts(pairScene(meshOf({a}), meshOf({b}))).size() != vector.meet;
        wrong += contacts(pairScene(meshOf({b}), meshOf({a}))).size() != vector.meet;
      }
    }
    EXPECT_EQ(0, wrong) << vector.name << " of 72 orders";
  }
}

TEST_P(PredicateVectors, ConservativeNeverMisses) {
  DCM_REQUIRE_TEST_DATA();
  Options options;
  options.predicates = Predicates::kConservative;
  for (const Vector& vector : readVectors()) {
    if (!vector.meet) continue;
    for (const Triangle& a : orders(vector.a)) {
      for (const Triangle& b : orders(vector.b)) {
        EXPECT_EQ(1U, contacts(pairScene(meshOf({a}), meshOf({b})), options).size()) << vector.name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(, PredicateVectors, ::testing::ValuesIn(allBackends()), backendName);

TEST(PredicateVectorsOracle, Agrees) {
  DCM_REQUIRE_TEST_DATA();
  for (const Vector& vector : readVectors()) {
    const Scene scene = pairScene(meshOf({vector.a}), meshOf({vector.b}));
    EXPECT_EQ(vector.meet, oracleContacts(scene, AdjacentPairs::kSkip).size()) << vector.name;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
