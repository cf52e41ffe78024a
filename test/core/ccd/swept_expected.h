// Helpers that compare continuous detection with the oracle.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "swept/swept_oracle.h"
#include "swept/swept_scenes.h"
#include "swept_suite.h"

namespace deformable_contact_monitor {

class SweptFixture : public DetectorSuite {
 protected:
  std::vector<TrianglePair> swept(const Scene& scene,
                                  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared) {
    return contacts(scene, sweptOptions(adjacent));
  }

  bool isBruteForce() const { return GetParam().name == std::string("brute_force"); }

  // Cluster counts that must not change a result; for brute force, which has none, one of them.
  std::vector<int> clusterCounts() const {
    if (isBruteForce()) return {0};
    return {1, 2, 7, 0};
  }
};

inline std::vector<TrianglePair> oracleSwept(const Scene& scene, AdjacentPairs adjacent) {
  return oracleSweptContacts(earlierScene(scene), laterScene(scene), adjacent);
}

inline ::testing::AssertionResult includes(const std::vector<TrianglePair>& all,
                                           const std::vector<TrianglePair>& part) {
  const ::testing::AssertionResult ordered = isOrdered(all);
  if (!ordered) return ordered;
  std::vector<TrianglePair> missing;
  std::set_difference(part.begin(), part.end(), all.begin(), all.end(),
                      std::back_inserter(missing));
  if (missing.empty()) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "of " << part.size() << " pairs " << missing.size()
                                       << " are missing, the first: " << missing.front();
}

// A time that the oracle tells, within the interval that exact predicates promise.
inline ::testing::AssertionResult holds(const FirstContact& found, const SweptTime& truth) {
  constexpr float kWidest = 0x1p-20F;
  const bool at_start = truth.high == 0 && truth.is_attained;
  // A time that is only an infimum is reached after it.
  const bool reached =
      truth.is_attained ? mpq_class(found.high) >= truth.low : mpq_class(found.high) > truth.low;
  if (0 <= found.low && found.low <= found.high && found.high <= 1 &&
      found.high - found.low <= kWidest && mpq_class(found.low) <= truth.high && reached &&
      (found.high == 0) == at_start) {
    return ::testing::AssertionSuccess();
  }
  return ::testing::AssertionFailure()
         << "[" << found.low << ", " << found.high << "] does not hold [" << truth.low.get_d()
         << ", " << truth.high.get_d() << "]" << (truth.is_attained ? "" : ", an infimum");
}

}  // namespace deformable_contact_monitor
