// Exact signs of determinants by 128-bit and 192-bit integers.
//
// They apply where the coordinates' exponents do not differ by more than 37, which is nearly always
// the case, and are much faster there than exact sums of doubles. Device code has 128-bit integers
// from CUDA 11.5 on; with older compilers it uses the sums.
#pragma once

#include <cstdint>
#include <cstring>

#include "core/host_device.h"

#if defined(__CUDA_ARCH__) && __CUDACC_VER_MAJOR__ * 100 + __CUDACC_VER_MINOR__ < 1105
#define DCM_INT128 0
#else
#define DCM_INT128 1
#endif

#if DCM_INT128
namespace deformable_contact_monitor {

__extension__ using Int128 = __int128;

// Writes finite coordinates as multiples of a common power of two; all are less than 2^61. Returns
// false if the exponents differ by too much for that.
template <int N>
DCM_HD inline bool toIntegers(const float (&x)[N], std::int64_t (&integer)[N]) {
  constexpr int kMostShift = 37;  // of a mantissa of 24 bits
  int low = 255, high = 0;
  std::uint32_t bits[N];
  for (int i = 0; i < N; ++i) {
    std::memcpy(&bits[i], &x[i], sizeof bits[i]);
    const int stored = static_cast<int>(bits[i] >> 23 & 0xff);
    const int exponent = stored > 0 ? stored : 1;  // a subnormal has no hidden bit
    if ((bits[i] & 0x7fffffffU) == 0) continue;    // a zero has any exponent
    low = exponent < low ? exponent : low;
    high = exponent > high ? exponent : high;
  }
  if (high - low > kMostShift) return false;
  for (int i = 0; i < N; ++i) {
    const int stored = static_cast<int>(bits[i] >> 23 & 0xff);
    const std::int64_t mantissa = (bits[i] & 0x7fffffU) | (stored > 0 ? 0x800000U : 0U);
    const std::int64_t size = mantissa == 0 ? 0 : mantissa << ((stored > 0 ? stored : 1) - low);
    integer[i] = bits[i] >> 31 != 0 ? -size : size;
  }
  return true;
}

// An integer of 192 bits: high * 2^64 + low.
struct Int192 {
  Int128 high = 0;
  std::uint64_t low = 0;

  // Adds x * y; |x| < 2^126 and |y| < 2^62.
  DCM_HD void addProduct(Int128 x, std::int64_t y) {
    const auto x_high = static_cast<std::int64_t>(x >> 64);
    const Int128 part = static_cast<Int128>(static_cast<std::uint64_t>(x)) * y;
    const auto part_low = static_cast<std::uint64_t>(part);
    low += part_low;
    high += static_cast<Int128>(x_high) * y + (part >> 64) + (low < part_low ? 1 : 0);
  }
  DCM_HD int sign() const {
    if (high != 0) return high > 0 ? 1 : -1;
    return low != 0 ? 1 : 0;
  }
};

// Returns the sign of det[u; v; w]; each number is less than 2^62 in size.
DCM_HD inline int determinantSign(const std::int64_t u[3], const std::int64_t v[3],
                                  const std::int64_t w[3]) {
  Int192 sum;
  sum.addProduct(static_cast<Int128>(v[1]) * w[2] - static_cast<Int128>(v[2]) * w[1], u[0]);
  sum.addProduct(static_cast<Int128>(v[2]) * w[0] - static_cast<Int128>(v[0]) * w[2], u[1]);
  sum.addProduct(static_cast<Int128>(v[0]) * w[1] - static_cast<Int128>(v[1]) * w[0], u[2]);
  return sum.sign();
}

// Returns the sign of det[u; v]; each number is less than 2^62 in size.
DCM_HD inline int determinantSign2(std::int64_t ux, std::int64_t uy, std::int64_t vx,
                                   std::int64_t vy) {
  const Int128 left = static_cast<Int128>(ux) * vy, right = static_cast<Int128>(uy) * vx;
  return (left > right) - (left < right);
}

}  // namespace deformable_contact_monitor
#endif
