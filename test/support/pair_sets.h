// Comparison of contact lists as sets, with what differs spelled out.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <ostream>
#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

inline std::ostream& operator<<(std::ostream& out, const TrianglePair& p) {
  return out << p.body_a << ":" << p.triangle_a << "-" << p.body_b << ":" << p.triangle_b;
}

// Each pair once, each ascending, the list ascending.
inline ::testing::AssertionResult isOrdered(const std::vector<TrianglePair>& pairs) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const TrianglePair& p = pairs[i];
    if (p.body_a > p.body_b || (p.body_a == p.body_b && p.triangle_a >= p.triangle_b)) {
      return ::testing::AssertionFailure() << "pair " << p << " is not in ascending order";
    }
    if (i > 0 && !(pairs[i - 1] < p)) {
      return ::testing::AssertionFailure()
             << "pair " << pairs[i - 1] << " stands before " << p << " at " << i;
    }
  }
  return ::testing::AssertionSuccess();
}

// `actual` is ordered and has exactly the pairs of `expected`, which is ordered.
inline ::testing::AssertionResult samePairs(const std::vector<TrianglePair>& expected,
                                            const std::vector<TrianglePair>& actual) {
  const ::testing::AssertionResult ordered = isOrdered(actual);
  if (!ordered) return ordered;
  std::vector<TrianglePair> missing, extra;
  std::set_difference(expected.begin(), expected.end(), actual.begin(), actual.end(),
                      std::back_inserter(missing));
  std::set_difference(actual.begin(), actual.end(), expected.begin(), expected.end(),
                      std::back_inserter(extra));
  if (missing.empty() && extra.empty()) return ::testing::AssertionSuccess();
  auto failure = ::testing::AssertionFailure()
                 << "of " << expected.size() << " pairs " << missing.size() << " are missing and "
                 << extra.size() << " are too many:";
  for (std::size_t i = 0; i < std::min<std::size_t>(missing.size(), 5); ++i) {
    failure << " -" << missing[i];
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(extra.size(), 5); ++i) {
    failure << " +" << extra[i];
  }
  return failure;
}

// Separations, bit by bit.
inline ::testing::AssertionResult sameBits(const std::vector<float>& a,
                                           const std::vector<float>& b) {
  if (a.size() != b.size()) {
    return ::testing::AssertionFailure() << a.size() << " and " << b.size() << " separations";
  }
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof a[i]) == 0) continue;
    return ::testing::AssertionFailure() << "separation " << i << ": " << a[i] << ", " << b[i];
  }
  return ::testing::AssertionSuccess();
}

}  // namespace deformable_contact_monitor
