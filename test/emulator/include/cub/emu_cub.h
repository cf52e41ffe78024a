#pragma once
#include <cuda_runtime.h>
#include <algorithm>
#include <numeric>
#include <vector>
namespace cub {
namespace emu_detail {
template <class F>
cudaError_t call(void* memory, std::size_t& bytes, cudaStream_t stream, F f) {
  if (memory == nullptr) { bytes = 256; return cudaSuccess; }
  emu::enqueue(stream, f);
  return cudaSuccess;
}
template <class K>
auto key(K k, int begin, int end) {
  using U = std::conditional_t<sizeof(K) == 8, std::uint64_t, std::uint32_t>;
  const U u = static_cast<U>(k);
  const int n = end - begin;
  return static_cast<U>(n >= static_cast<int>(8 * sizeof(U)) ? u >> begin : (u >> begin) & ((U{1} << n) - 1));
}
}
template <class T> struct DoubleBuffer {
  T* d_buffers[2]; int selector = 0;
  DoubleBuffer(T* a, T* b) : d_buffers{a, b} {}
  T* Current() { return d_buffers[selector]; }
  T* Alternate() { return d_buffers[selector ^ 1]; }
};
struct DeviceScan {
  template <class I, class O, class N>
  static cudaError_t ExclusiveSum(void* m, std::size_t& b, I in, O out, N n, cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      std::decay_t<decltype(*out)> sum = 0;
      for (N i = 0; i < n; ++i) { const auto x = in[i]; out[i] = sum; sum += x; }
    });
  }
  template <class I, class O, class N>
  static cudaError_t InclusiveSum(void* m, std::size_t& b, I in, O out, N n, cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      std::decay_t<decltype(*out)> sum = 0;
      for (N i = 0; i < n; ++i) { sum += in[i]; out[i] = sum; }
    });
  }
};
struct DeviceReduce {
  template <class I, class O, class N>
  static cudaError_t Sum(void* m, std::size_t& b, I in, O out, N n, cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      std::decay_t<decltype(*out)> sum = 0;
      for (N i = 0; i < n; ++i) sum += in[i];
      *out = sum;
    });
  }
  template <class I, class O, class N>
  static cudaError_t Max(void* m, std::size_t& b, I in, O out, N n, cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      auto r = in[0];
      for (N i = 0; i < n; ++i) r = std::max(r, in[i]);
      *out = r;
    });
  }
};
struct DeviceRadixSort {
  template <class K, class V, class N>
  static cudaError_t SortPairs(void* m, std::size_t& b, const K* ki, K* ko, const V* vi, V* vo, N n,
                               int begin = 0, int end = 8 * sizeof(K), cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      std::vector<std::size_t> order(n);
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
        return emu_detail::key(ki[x], begin, end) < emu_detail::key(ki[y], begin, end);
      });
      std::vector<K> k(n);
      std::vector<V> v(vi, vi + n);
      for (std::size_t i = 0; i < order.size(); ++i) k[i] = ki[order[i]], v[i] = vi[order[i]];
      std::copy(k.begin(), k.end(), ko);
      std::copy(v.begin(), v.end(), vo);
    });
  }
  template <class K, class V, class N>
  static cudaError_t SortPairs(void* m, std::size_t& b, DoubleBuffer<K>& k, DoubleBuffer<V>& v, N n,
                               int begin = 0, int end = 8 * sizeof(K), cudaStream_t s = nullptr) {
    const cudaError_t e = SortPairs(m, b, static_cast<const K*>(k.Current()), k.Alternate(),
                                    static_cast<const V*>(v.Current()), v.Alternate(), n, begin, end, s);
    if (m != nullptr) k.selector ^= 1, v.selector ^= 1;
    return e;
  }
  template <class K, class N>
  static cudaError_t SortKeys(void* m, std::size_t& b, const K* ki, K* ko, N n, int begin = 0,
                              int end = 8 * sizeof(K), cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      std::vector<K> k(ki, ki + n);
      std::stable_sort(k.begin(), k.end(), [&](K x, K y) {
        return emu_detail::key(x, begin, end) < emu_detail::key(y, begin, end);
      });
      std::copy(k.begin(), k.end(), ko);
    });
  }
  template <class K, class N>
  static cudaError_t SortKeys(void* m, std::size_t& b, DoubleBuffer<K>& k, N n, int begin = 0,
                              int end = 8 * sizeof(K), cudaStream_t s = nullptr) {
    const cudaError_t e = SortKeys(m, b, static_cast<const K*>(k.Current()), k.Alternate(), n, begin, end, s);
    if (m != nullptr) k.selector ^= 1;
    return e;
  }
};
struct DeviceSelect {
  template <class I, class F, class O, class C, class N>
  static cudaError_t Flagged(void* m, std::size_t& b, I in, F flags, O out, C count, N n, cudaStream_t s = nullptr) {
    return emu_detail::call(m, b, s, [=] {
      N k = 0;
      for (N i = 0; i < n; ++i) if (flags[i]) out[k++] = in[i];
      *count = k;
    });
  }
};
}
