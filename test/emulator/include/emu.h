// Emulation of a CUDA device on the host: fibers for threads, warps, blocks.
#pragma once
#include <cstdint>
#include <cstring>
#include <functional>
#include <tuple>
#include <type_traits>
#include <utility>

namespace emu {

struct Warp;
struct Fiber {
  uint3 tid;
  unsigned lane = 0;
  Warp* warp = nullptr;
  void* sp = nullptr;
  void* stack = nullptr;
  unsigned number = 0;  // in the block
};
struct Slot {
  std::uint64_t value = 0, result = 0;
  unsigned mask = 0;
  int arg = 0;
  const void* complete = nullptr;
};
using Complete = void (*)(Warp&, unsigned mask);
struct Warp {
  Slot slot[32];
  unsigned alive = 0, runnable = 0, waiting = 0, atBarrier = 0;
};
struct State {
  Fiber* now = nullptr;
  uint3 block{};
  dim3 blockDim{}, gridDim{};
};
extern thread_local State state __attribute__((tls_model("initial-exec")));

[[noreturn]] void fail(const char* what, const char* where = "");
void collective(unsigned mask, std::uint64_t value, int arg, Complete complete);
int barrier(int value, int kind);  // kind 0: none, 1: count, 2: or, 3: and
void* dynamicShared();
void launch(dim3 grid, dim3 block, std::size_t shared, cudaStream_t stream, std::function<void()> thread,
            const char* name);
void enqueue(cudaStream_t stream, std::function<void()> what);
void kernelUnknown();

struct Config {
  dim3 grid, block;
  std::size_t shared = 0;
  cudaStream_t stream = nullptr;
  const char* name = "";
  Config(dim3 g, dim3 b, std::size_t s = 0, cudaStream_t st = nullptr)
      : grid(g), block(b), shared(s), stream(st) {}
  template <class... P, class... A>
  void run(const char* called, void (*kernel)(P...), A&&... a) const {
    std::tuple<std::decay_t<P>...> args(static_cast<std::decay_t<P>>(a)...);
    launch(grid, block, shared, stream, [kernel, args] { std::apply(kernel, args); }, called);
  }
};

inline void checkIndex(std::uint64_t i, std::uint64_t rows, const char* where) {
  if (__builtin_expect(i >= rows && state.now != nullptr, 0)) {
    extern void failIndex(std::uint64_t, std::uint64_t, const char*);
    failIndex(i, rows, where);
  }
}

template <class T>
std::uint64_t toBits(T x) {
  static_assert(sizeof(T) <= 8);
  std::uint64_t b = 0;
  std::memcpy(&b, &x, sizeof x);
  return b;
}
template <class T>
T fromBits(std::uint64_t b) {
  T x;
  std::memcpy(&x, &b, sizeof x);
  return x;
}
inline Slot& mine() { return state.now->warp->slot[state.now->lane]; }
template <class F>
void forLanes(unsigned mask, F f) {
  for (; mask != 0; mask &= mask - 1) f(__builtin_ctz(mask));
}
inline void completeShuffle(Warp& w, unsigned mask) {
  forLanes(mask, [&](int l) {
    const int from = w.slot[l].arg;
    if (!(mask >> from & 1)) {
      w.slot[l].result = 0xdeadbeefdeadbeefULL;  // undefined on the device
    } else {
      w.slot[l].result = w.slot[from].value;
    }
  });
}
inline void completeBallot(Warp& w, unsigned mask) {
  unsigned r = 0;
  forLanes(mask, [&](int l) { r |= (w.slot[l].value != 0 ? 1U : 0U) << l; });
  forLanes(mask, [&](int l) { w.slot[l].result = r; });
}
inline void completeSync(Warp&, unsigned) {}
inline void completeMatch(Warp& w, unsigned mask) {
  forLanes(mask, [&](int l) {
    unsigned r = 0;
    forLanes(mask, [&](int k) { r |= (w.slot[k].value == w.slot[l].value ? 1U : 0U) << k; });
    w.slot[l].result = r;
  });
}
template <class T, int kOp>  // 0 add 1 max 2 min 3 or 4 and 5 xor
void completeReduce(Warp& w, unsigned mask) {
  bool first = true;
  T r{};
  forLanes(mask, [&](int l) {
    const T x = fromBits<T>(w.slot[l].value);
    if (first) r = x;
    else if (kOp == 0) r += x;
    else if (kOp == 1) r = x > r ? x : r;
    else if (kOp == 2) r = x < r ? x : r;
    else if (kOp == 3) r |= x;
    else if (kOp == 4) r &= x;
    else r ^= x;
    first = false;
  });
  forLanes(mask, [&](int l) { w.slot[l].result = toBits(r); });
}
template <class T>
T shuffle(unsigned mask, T x, int from) {
  if constexpr (sizeof(T) <= 8) {
    collective(mask, toBits(x), from, completeShuffle);
    return fromBits<T>(mine().result);
  }
}
}  // namespace emu

// ------------------------------------------------------------------ what kernels call
#undef __shared__
#define __shared__ static thread_local
#undef __launch_bounds__
#define __launch_bounds__(...)
#undef __global__
#define __global__
#undef __device__
#define __device__
#undef __host__
#define __host__
#undef __constant__
#define __constant__
#undef __forceinline__
#define __forceinline__ inline
#undef __noinline__
#undef __align__
#define __align__(n) alignas(n)
#undef __grid_constant__
#define __grid_constant__
#define warpSize 32

inline void __syncthreads() { emu::barrier(0, 0); }
inline int __syncthreads_count(int p) { return emu::barrier(p != 0, 1); }
inline int __syncthreads_or(int p) { return emu::barrier(p != 0, 2); }
inline int __syncthreads_and(int p) { return emu::barrier(p != 0, 3); }
inline void __syncwarp(unsigned mask = 0xffffffffU) { emu::collective(mask, 0, 0, emu::completeSync); }
inline unsigned __activemask() { return 1U << emu::state.now->lane; }
template <class T>
T __shfl_sync(unsigned mask, T x, int from, int width = 32) {
  const int l = static_cast<int>(emu::state.now->lane);
  return emu::shuffle(mask, x, (l & ~(width - 1)) | (from & (width - 1)));
}
template <class T>
T __shfl_xor_sync(unsigned mask, T x, int o, int width = 32) {
  const int l = static_cast<int>(emu::state.now->lane);
  const int from = l ^ o;
  return emu::shuffle(mask, x, (from & ~(width - 1)) <= (l & ~(width - 1)) ? from : l);
}
template <class T>
T __shfl_up_sync(unsigned mask, T x, unsigned o, int width = 32) {
  const int l = static_cast<int>(emu::state.now->lane), from = l - static_cast<int>(o);
  return emu::shuffle(mask, x, from < (l & ~(width - 1)) ? l : from);
}
template <class T>
T __shfl_down_sync(unsigned mask, T x, unsigned o, int width = 32) {
  const int l = static_cast<int>(emu::state.now->lane), from = l + static_cast<int>(o);
  return emu::shuffle(mask, x, from > (l | (width - 1)) ? l : from);
}
inline unsigned __ballot_sync(unsigned mask, int p) {
  emu::collective(mask, p != 0, 0, emu::completeBallot);
  return static_cast<unsigned>(emu::mine().result);
}
inline int __any_sync(unsigned mask, int p) { return __ballot_sync(mask, p) != 0; }
inline int __all_sync(unsigned mask, int p) { return __ballot_sync(mask, !p) == 0; }
template <class T>
unsigned __match_any_sync(unsigned mask, T x) {
  emu::collective(mask, emu::toBits(x), 0, emu::completeMatch);
  return static_cast<unsigned>(emu::mine().result);
}
#define EMU_REDUCE(name, op)                                                     \
  template <class T>                                                             \
  T __reduce_##name##_sync(unsigned mask, T x) {                                 \
    emu::collective(mask, emu::toBits(x), 0, emu::completeReduce<T, op>);        \
    return emu::fromBits<T>(emu::mine().result);                                 \
  }
EMU_REDUCE(add, 0) EMU_REDUCE(max, 1) EMU_REDUCE(min, 2) EMU_REDUCE(or, 3) EMU_REDUCE(and, 4)
EMU_REDUCE(xor, 5)
#undef EMU_REDUCE

#define EMU_ATOMIC(name, expression)                                 \
  template <class T, class U>                                        \
  T atomic##name(T* p, U v) {                                        \
    const T x = static_cast<T>(v), old = *p;                         \
    *p = expression;                                                 \
    return old;                                                      \
  }                                                                  \
  template <class T, class U>                                        \
  T atomic##name##_system(T* p, U v) { return atomic##name(p, v); }  \
  template <class T, class U>                                        \
  T atomic##name##_block(T* p, U v) { return atomic##name(p, v); }
EMU_ATOMIC(Add, old + x) EMU_ATOMIC(Sub, old - x) EMU_ATOMIC(Max, old > x ? old : x)
EMU_ATOMIC(Min, old < x ? old : x) EMU_ATOMIC(Or, old | x) EMU_ATOMIC(And, old & x)
EMU_ATOMIC(Xor, old ^ x) EMU_ATOMIC(Exch, x) EMU_ATOMIC(Inc, old >= x ? 0 : old + 1)
#undef EMU_ATOMIC
template <class T, class U, class V>
T atomicCAS(T* p, U c, V v) {
  const T old = *p;
  if (old == static_cast<T>(c)) *p = static_cast<T>(v);
  return old;
}
inline void __threadfence() {}
inline void __threadfence_system() {}
inline void __threadfence_block() {}
template <class T> T __ldg(const T* p) { return *p; }
template <class T> T __ldcg(const T* p) { return *p; }
template <class T> T __ldcs(const T* p) { return *p; }
template <class T> T __ldca(const T* p) { return *p; }
template <class T> T __ldcv(const T* p) { return *p; }
template <class T, class U> void __stcg(T* p, U v) { *p = v; }
template <class T, class U> void __stcs(T* p, U v) { *p = v; }
template <class T, class U> void __stwt(T* p, U v) { *p = v; }
inline int __popc(unsigned x) { return __builtin_popcount(x); }
inline int __popcll(unsigned long long x) { return __builtin_popcountll(x); }
inline int __ffs(int x) { return __builtin_ffs(x); }
inline int __ffsll(long long x) { return __builtin_ffsll(x); }
inline int __clz(int x) { return x == 0 ? 32 : __builtin_clz(static_cast<unsigned>(x)); }
inline int __clzll(long long x) { return x == 0 ? 64 : __builtin_clzll(static_cast<unsigned long long>(x)); }
inline unsigned __brev(unsigned x) {
  unsigned r = 0;
  for (int i = 0; i < 32; ++i) r |= (x >> i & 1) << (31 - i);
  return r;
}
inline unsigned __byte_perm(unsigned a, unsigned b, unsigned s) {
  const std::uint64_t v = std::uint64_t{b} << 32 | a;
  unsigned r = 0;
  for (int i = 0; i < 4; ++i) r |= static_cast<unsigned>(v >> (8 * (s >> (4 * i) & 7)) & 0xff) << (8 * i);
  return r;
}
inline unsigned __funnelshift_l(unsigned lo, unsigned hi, unsigned s) {
  return static_cast<unsigned>(((std::uint64_t{hi} << 32 | lo) << (s & 31)) >> 32);
}
inline unsigned __funnelshift_r(unsigned lo, unsigned hi, unsigned s) {
  return static_cast<unsigned>((std::uint64_t{hi} << 32 | lo) >> (s & 31));
}
inline unsigned __umulhi(unsigned a, unsigned b) { return static_cast<unsigned>(std::uint64_t{a} * b >> 32); }
inline unsigned __float_as_uint(float x) { return emu::fromBits<unsigned>(emu::toBits(x)); }
inline int __float_as_int(float x) { return emu::fromBits<int>(emu::toBits(x)); }
inline float __uint_as_float(unsigned x) { return emu::fromBits<float>(x); }
inline float __int_as_float(int x) { return emu::fromBits<float>(static_cast<unsigned>(x)); }
inline long long __double_as_longlong(double x) { return emu::fromBits<long long>(emu::toBits(x)); }
inline double __longlong_as_double(long long x) { return emu::fromBits<double>(emu::toBits(x)); }
#include <cfenv>
namespace emu {
// Outward rounding of a binary operation by the error of an exact one in wider arithmetic.
inline float down(long double x) { float f = static_cast<float>(x); return f > x ? std::nextafterf(f, -INFINITY) : f; }
inline float up(long double x) { float f = static_cast<float>(x); return f < x ? std::nextafterf(f, INFINITY) : f; }
}
inline float __fadd_rn(float a, float b) { return a + b; }
inline float __fsub_rn(float a, float b) { return a - b; }
inline float __fmul_rn(float a, float b) { return a * b; }
inline float __fdiv_rn(float a, float b) { return a / b; }
inline float __fmaf_rn(float a, float b, float c) { return std::fmaf(a, b, c); }
inline float __fadd_rd(float a, float b) { return emu::down(static_cast<long double>(a) + b); }
inline float __fadd_ru(float a, float b) { return emu::up(static_cast<long double>(a) + b); }
inline float __fsub_rd(float a, float b) { return emu::down(static_cast<long double>(a) - b); }
inline float __fsub_ru(float a, float b) { return emu::up(static_cast<long double>(a) - b); }
inline float __fmul_rd(float a, float b) { return emu::down(static_cast<long double>(a) * b); }
inline float __fmul_ru(float a, float b) { return emu::up(static_cast<long double>(a) * b); }
inline float __fmaf_ru(float a, float b, float c) { return emu::up(static_cast<long double>(a) * b + c); }
inline float __fmaf_rd(float a, float b, float c) { return emu::down(static_cast<long double>(a) * b + c); }
inline float __frcp_rn(float a) { return 1 / a; }
inline float __fsqrt_rn(float a) { return std::sqrt(a); }
inline float __fdividef(float a, float b) { return a / b; }
inline float __saturatef(float a) { return a < 0 ? 0 : a > 1 ? 1 : a; }
inline double __dadd_rn(double a, double b) { return a + b; }
inline double __dsub_rn(double a, double b) { return a - b; }
inline double __dmul_rn(double a, double b) { return a * b; }
inline double __fma_rn(double a, double b, double c) { return std::fma(a, b, c); }
inline float __uint2float_rn(unsigned x) { return static_cast<float>(x); }
inline float __uint2float_rd(unsigned x) { return emu::down(x); }
inline float __uint2float_ru(unsigned x) { return emu::up(x); }
inline float __int2float_rn(int x) { return static_cast<float>(x); }
namespace emu {
inline unsigned sat(double x) { return x != x || x <= 0 ? 0 : x >= 4294967295.0 ? 0xffffffffU : static_cast<unsigned>(x); }
inline int sati(double x) { return x != x ? 0 : x <= -2147483648.0 ? INT32_MIN : x >= 2147483647.0 ? INT32_MAX : static_cast<int>(x); }
}
inline unsigned __float2uint_rd(float x) { return emu::sat(std::floor(x)); }
inline unsigned __float2uint_ru(float x) { return emu::sat(std::ceil(x)); }
inline unsigned __float2uint_rn(float x) { return emu::sat(std::nearbyint(x)); }
inline unsigned __float2uint_rz(float x) { return emu::sat(std::trunc(x)); }
inline int __float2int_rd(float x) { return emu::sati(std::floor(x)); }
inline int __float2int_ru(float x) { return emu::sati(std::ceil(x)); }
inline int __float2int_rn(float x) { return emu::sati(std::nearbyint(x)); }
inline int __float2int_rz(float x) { return emu::sati(std::trunc(x)); }
inline float rsqrtf(float x) { return 1 / std::sqrt(x); }
inline unsigned __vminu2(unsigned a, unsigned b) {
  const unsigned al = a & 0xffff, bl = b & 0xffff, ah = a >> 16, bh = b >> 16;
  return (al < bl ? al : bl) | (ah < bh ? ah : bh) << 16;
}
inline unsigned __vmaxu2(unsigned a, unsigned b) {
  const unsigned al = a & 0xffff, bl = b & 0xffff, ah = a >> 16, bh = b >> 16;
  return (al > bl ? al : bl) | (ah > bh ? ah : bh) << 16;
}
inline long long clock64() { return static_cast<long long>(__builtin_ia32_rdtsc()); }
inline void __nanosleep(unsigned) {}
inline void __trap() { emu::fail("trap"); }
inline void __builtin_assume_emu(bool) {}
inline void cudaGridDependencySynchronize() {}
inline void cudaTriggerProgrammaticLaunchCompletion() {}
template <class A, class B>
std::common_type_t<A, B> min(const A a, const B b) {
  using C = std::common_type_t<A, B>;
  return static_cast<C>(b) < static_cast<C>(a) ? static_cast<C>(b) : static_cast<C>(a);
}
template <class A, class B>
std::common_type_t<A, B> max(const A a, const B b) {
  using C = std::common_type_t<A, B>;
  return static_cast<C>(a) < static_cast<C>(b) ? static_cast<C>(b) : static_cast<C>(a);
}
