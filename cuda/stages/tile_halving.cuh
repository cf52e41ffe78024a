// Triangles of which up to 64 tiles are to be made, halved along the longest side of what their
// centroids fill, again and again, as core/bounds/halving.h does on the host.
#pragma once

#include <cstdint>

#include "core/vector3.h"
#include "cuda/device/bitonic_sort.cuh"
#include "cuda/device/boxes.cuh"

namespace deformable_contact_monitor {

// In shared memory, by a block of kThreads. All its threads make each of the calls.
struct TileHalving {
  static constexpr unsigned kMost = 2048;  // triangles
  static constexpr unsigned kThreads = kMost / 2;

  // Ranks by coordinate, once they are sorted by; in the lowest bits which of the triangles.
  std::uint32_t key[kMost];
  float at[3][kMost];  // centroids of the triangles
  std::uint32_t sides[kMost / (2 * kWarp)][kSides];

  // Which triangle is in that place, of those that there are if it is less than their number.
  __device__ std::uint32_t triangleAt(std::uint32_t place) const { return key[place] % kMost; }

  // Of triangle i; what is not finite may lie anywhere.
  __device__ void put(std::uint32_t i, const Vec3f& centroid) {
    for (int k = 0; k < 3; ++k) at[k][i] = fabsf(centroid[k]) < INFINITY ? centroid[k] : 0;
  }

  // Of the first `count` triangles: those in each 32 places are a tile's.
  __device__ void halve(std::uint32_t count) {
    for (unsigned i = threadIdx.x; i < kMost; i += kThreads) key[i] = i;
    unsigned whole = kWarp;
    while (whole < count) whole *= 2;
    for (unsigned part = whole; part > kWarp; part /= 2) {
      __syncthreads();
      rank(count, whole, part);
      bitonicSort(key, whole, part);
    }
    __syncthreads();
  }

 private:
  static constexpr std::uint32_t kRanks = ~std::uint32_t{0} / kMost;  // the last: no triangle

  // Where x is within [low, high], in so many steps.
  __device__ static std::uint32_t rankOf(float x, float low, float high) {
    const float from = low / 2, length = high / 2 - from;  // twice that may have no float32
    if (!(length > 0)) return 0;
    constexpr auto kMostRank = static_cast<float>(kRanks - 1);
    return static_cast<std::uint32_t>(fminf((x / 2 - from) / length * kMostRank, kMostRank));
  }

  // By the coordinate along the longest side of each part; what is no triangle comes last.
  __device__ void rank(std::uint32_t count, unsigned whole, unsigned part) {
    for (unsigned i = threadIdx.x; i < whole / part * kSides; i += kThreads) (&sides[0][0])[i] = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i < whole; i += kThreads) {  // whole warps in one part
      const std::uint32_t t = triangleAt(i);
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t bits = orderedBits(at[k][t]);
        const std::uint32_t low = warpMost(t < count ? ~bits : 0);
        const std::uint32_t high = warpMost(t < count ? bits : 0);
        if (laneId() != 0) continue;
        atomicMax(&sides[i / part][k], low);
        atomicMax(&sides[i / part][3 + k], high);
      }
    }
    __syncthreads();
    for (unsigned i = threadIdx.x; i < whole; i += kThreads) {
      const Aabb box = boxOf(sides[i / part]);
      const Vec3f side = box.max - box.min;
      const int k = side.x >= fmaxf(side.y, side.z) ? 0 : side.y >= side.z ? 1 : 2;
      const std::uint32_t t = triangleAt(i);
      const std::uint32_t rank = t < count ? rankOf(at[k][t], box.min[k], box.max[k]) : kRanks;
      key[i] = rank * kMost + t;
    }
  }
};

}  // namespace deformable_contact_monitor
