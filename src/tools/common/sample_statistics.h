// Computes median and percentiles of measured samples, such as times. The samples may come in any
// order.
//
// Benchmarks and tools use the same definitions, so their figures can be compared.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace deformable_contact_monitor {

// Returns the smallest sample that at least a share (0, 1] of all samples does not exceed. Returns
// 0 without samples.
inline double percentile(std::vector<double> samples, double share) {
  if (samples.empty()) return 0;
  std::sort(samples.begin(), samples.end());
  const double rank = std::ceil(share * static_cast<double>(samples.size()));
  return samples[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

// Returns the median: for an even number of samples, the mean of the two in the middle. Returns 0
// without samples.
inline double median(std::vector<double> samples) {
  if (samples.empty()) return 0;
  const auto half = samples.begin() + static_cast<std::ptrdiff_t>(samples.size() / 2);
  std::nth_element(samples.begin(), half, samples.end());
  if (samples.size() % 2 == 1) return *half;
  return (*std::max_element(samples.begin(), half) + *half) / 2;
}

}  // namespace deformable_contact_monitor
