// Exact signs of the Bernstein coefficients of a feature's cubic, by integers of 192 bits: where
// coordinates' sizes are not too far apart, which is nearly always. For what double leaves open.
#pragma once

#include "core/predicates/exact_integers.h"
#include "core/predicates/swept_feature.h"

namespace deformable_contact_monitor {

// What exact signs tell of [x1 - x0, x2 - x0, x3 - x0].
enum class IntegerSigns {
  kUnknown,       // several may vanish, or a root lies within, or the integers are too large
  kNoRootWithin,  // it does not vanish in (0, 1); it may at 0 and at 1
};

#if DCM_INT128
namespace detail {

// Adds [u v w]; |each number| < 2^62. Three of them fit.
DCM_HD inline void addDeterminant(Int192& sum, const std::int64_t u[3], const std::int64_t v[3],
                                  const std::int64_t w[3]) {
  sum.addProduct(static_cast<Int128>(v[1]) * w[2] - static_cast<Int128>(v[2]) * w[1], u[0]);
  sum.addProduct(static_cast<Int128>(v[2]) * w[0] - static_cast<Int128>(v[0]) * w[2], u[1]);
  sum.addProduct(static_cast<Int128>(v[0]) * w[1] - static_cast<Int128>(v[1]) * w[0], u[2]);
}

}  // namespace detail

DCM_HD DCM_RARE inline IntegerSigns integerSigns(const Feature& feature) {
  float x[24];
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      x[3 * i + k] = feature.x[i].from[k];
      x[12 + 3 * i + k] = feature.x[i].to[k];
    }
  }
  std::int64_t n[24];
  if (!toIntegers(x, n)) return IntegerSigns::kUnknown;
  for (int state = 0; state < 24; state += 12) {
    for (int i = 3; i < 12; ++i) n[state + i] -= n[state + i % 3];
  }
  // The coefficients are sums over which of the three differences are of the later state.
  int variations = 0, last = 0, first = 0;
  for (int later = 0; later < 4; ++later) {
    Int192 sum;
    for (int which = 0; which < 8; ++which) {
      const int u = which & 1, v = which >> 1 & 1, w = which >> 2;
      if (u + v + w != later) continue;
      detail::addDeterminant(sum, n + 12 * u + 3, n + 12 * v + 6, n + 12 * w + 9);
    }
    const int sign = sum.sign();
    if (sign == 0) continue;
    if (first == 0) first = sign;
    variations += last != 0 && sign != last;
    last = sign;
  }
  // Descartes: no more roots in (0, 1) than variations, unless it vanishes always.
  return first != 0 && variations == 0 ? IntegerSigns::kNoRootWithin : IntegerSigns::kUnknown;
}
#else
DCM_HD inline IntegerSigns integerSigns(const Feature& /*feature*/) {
  return IntegerSigns::kUnknown;
}
#endif

}  // namespace deformable_contact_monitor
