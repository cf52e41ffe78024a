// Sorts triangles into up to 64 tiles, by one thread block: halves a set of triangles along the
// longest side of the box of its centroids, again and again, as core/tiling.cpp does on the host.
#pragma once

#include <cstdint>

#include "core/vector3.h"
#include "cuda/device/bitonic_sort.cuh"
#include "cuda/device/boxes.cuh"

namespace deformable_contact_monitor {

// Lies in shared memory of a block of kThreads threads, all of which make each call. All sets of
// one size are halved at the same time, by one sort.
struct TileHalving {
  static constexpr unsigned kMost = 2048;  // triangles
  static constexpr unsigned kThreads = kMost / 2;

  // The keys to sort by: the rank of the coordinate, and in the lowest bits the triangle's number.
  std::uint32_t key[kMost];
  float at[3][kMost];  // centroids of the triangles
  std::uint32_t sides[kMost / (2 * kWarp)][kSides];

  // Returns the number of the triangle in a place. Places beyond the number of triangles have
  // numbers beyond it too.
  __device__ std::uint32_t triangleAt(std::uint32_t place) const { return key[place] % kMost; }

  // Sets the centroid of triangle i. A coordinate that is not finite counts as zero, because any
  // tile is right for such a triangle.
  __device__ void put(std::uint32_t i, const Vec3f& centroid) {
    for (int k = 0; k < 3; ++k) at[k][i] = fabsf(centroid[k]) < INFINITY ? centroid[k] : 0;
  }

  // Sorts the first `count` triangles. Every 32 consecutive places then form a tile.
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
  static constexpr std::uint32_t kRanks = ~std::uint32_t{0} / kMost;  // the last rank: no triangle

  // Returns the position of x in [low, high], as a rank below kRanks.
  __device__ static std::uint32_t rankOf(float x, float low, float high) {
    const float from = low / 2, length = high / 2 - from;  // high - low may overflow
    if (!(length > 0)) return 0;
    constexpr auto kMostRank = static_cast<float>(kRanks - 1);
    return static_cast<std::uint32_t>(fminf((x / 2 - from) / length * kMostRank, kMostRank));
  }

  // Sets the keys to the rank of the coordinate along the longest side of each set; places without
  // a triangle come last.
  __device__ void rank(std::uint32_t count, unsigned whole, unsigned part) {
    for (unsigned i = threadIdx.x; i < whole / part * kSides; i += kThreads) (&sides[0][0])[i] = 0;
    __syncthreads();
    for (unsigned i = threadIdx.x; i < whole; i += kThreads) {  // a warp lies in one set
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
