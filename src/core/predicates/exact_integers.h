// Exact signs and values of determinants by 128-bit and 192-bit integers.
//
// They apply where the coordinates' exponents do not differ by more than 37, which is nearly always
// the case, and are much faster there than exact sums of doubles. Device code has 128-bit integers
// from CUDA 11.5 on; with older compilers it uses the sums.
#pragma once

#include <cmath>
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

// Writes finite coordinates as multiples of a common power of two, 2^unit; all are less than 2^61.
// Returns false if the exponents differ by too much for that.
template <int N>
DCM_HD inline bool toIntegers(const float (&x)[N], std::int64_t (&integer)[N], int& unit) {
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
  unit = low - 150;  // a stored exponent of 150 makes the mantissa an integer
  for (int i = 0; i < N; ++i) {
    const int stored = static_cast<int>(bits[i] >> 23 & 0xff);
    const std::int64_t mantissa = (bits[i] & 0x7fffffU) | (stored > 0 ? 0x800000U : 0U);
    const std::int64_t size = mantissa == 0 ? 0 : mantissa << ((stored > 0 ? stored : 1) - low);
    integer[i] = bits[i] >> 31 != 0 ? -size : size;
  }
  return true;
}

template <int N>
DCM_HD inline bool toIntegers(const float (&x)[N], std::int64_t (&integer)[N]) {
  int unit = 0;
  return toIntegers(x, integer, unit);
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

// Returns det[u; v; w]; each number is less than 2^62 in size.
DCM_HD inline Int192 determinantOf(const std::int64_t u[3], const std::int64_t v[3],
                                   const std::int64_t w[3]) {
  Int192 sum;
  sum.addProduct(static_cast<Int128>(v[1]) * w[2] - static_cast<Int128>(v[2]) * w[1], u[0]);
  sum.addProduct(static_cast<Int128>(v[2]) * w[0] - static_cast<Int128>(v[0]) * w[2], u[1]);
  sum.addProduct(static_cast<Int128>(v[0]) * w[1] - static_cast<Int128>(v[1]) * w[0], u[2]);
  return sum;
}

DCM_HD inline int determinantSign(const std::int64_t u[3], const std::int64_t v[3],
                                  const std::int64_t w[3]) {
  return determinantOf(u, v, w).sign();
}

// Returns how many bits a number that is not negative has.
DCM_HD inline int bitsOf(std::uint64_t x) {
  int bits = 0;
  for (int step = 32; step > 0; step /= 2) {
    if (x >> step == 0) continue;
    x >>= step;
    bits += step;
  }
  return bits + (x != 0 ? 1 : 0);
}

// Finds what Expansion::value() returns for a determinant of 3 x 3 differences of coordinates that
// are integers of at most `bits` bits. Returns false if that is not certain.
//
// If the determinant has at most 53 bits, all sums in value() are exact. Otherwise, value() rounds
// the determinant plus an error. Components of an expansion do not overlap, and those below its
// last one are what was rounded off sums of at most 9 times the larger one of the determinant and
// its largest term, 2^(3 bits). So the error is less than 2^-100 of that, and only matters if the
// determinant is that near to the middle of two doubles.
DCM_HD inline bool roundedAsExpansion(Int192 sum, int bits, double& value) {
  const int sign = sum.sign();
  if (sign < 0) {
    sum.low = ~sum.low + 1;
    sum.high = -sum.high - (sum.low != 0 ? 1 : 0);
  }
  auto top = static_cast<std::uint64_t>(sum.high >> 64);
  auto middle = static_cast<std::uint64_t>(sum.high);
  std::uint64_t below = sum.low;
  int size = 192;
  for (int words = 0; words < 2 && top == 0; ++words) {
    top = middle;
    middle = below;
    below = 0;
    size -= 64;
  }
  const int unused = 64 - bitsOf(top);
  size -= unused;
  if (size <= 53) {  // it is in `top` alone
    value = sign * static_cast<double>(top);
    return true;
  }
  if (unused > 0) {
    top = top << unused | middle >> (64 - unused);
    middle = middle << unused | below >> (64 - unused);
  }
  const std::uint64_t rest = top << 53 | middle >> 11;  // in 2^-64 of the last bit that is kept
  constexpr std::uint64_t kHalf = std::uint64_t{1} << 63;
  const int beyond = 3 * bits > size ? 3 * bits - size : 0;
  if (beyond > 40) return false;
  const std::uint64_t off = rest > kHalf ? rest - kHalf : kHalf - rest;
  if (off <= std::uint64_t{1} << (beyond + 18)) return false;
  value = sign * ldexp(static_cast<double>((top >> 11) + (rest > kHalf ? 1 : 0)), size - 53);
  return true;
}

// Returns the sign of det[u; v]; each number is less than 2^62 in size.
DCM_HD inline int determinantSign2(std::int64_t ux, std::int64_t uy, std::int64_t vx,
                                   std::int64_t vy) {
  const Int128 left = static_cast<Int128>(ux) * vy, right = static_cast<Int128>(uy) * vx;
  return (left > right) - (left < right);
}

// Finds what Expansion::value() returns for det[q1 - p1; q2 - p2; q3 - p3], with the coordinates of
// p1, q1, p2, q2, p3, q3 in `x`. Returns false if that is not certain.
DCM_HD inline bool determinantAsExpansion(const float (&x)[18], double& value) {
  std::int64_t n[18];
  int unit = 0;
  if (!toIntegers(x, n, unit)) return false;
  std::uint64_t largest = 0;
  std::int64_t edge[9];
  for (int k = 0; k < 18; ++k) largest |= static_cast<std::uint64_t>(n[k] < 0 ? -n[k] : n[k]);
  for (int k = 0; k < 9; ++k) {
    const int from = k / 3 * 6 + k % 3;
    edge[k] = n[from + 3] - n[from];
  }
  if (!roundedAsExpansion(determinantOf(edge, edge + 3, edge + 6), bitsOf(largest), value)) {
    return false;
  }
  value = ldexp(value, 3 * unit);
  return true;
}

}  // namespace deformable_contact_monitor
#endif
