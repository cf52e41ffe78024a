// Grows the arrays of a DeviceMemory within one piece of memory. Arrays that grow are copied to the
// unused end of the piece; if there is no room, all arrays move to a new piece.
#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {
namespace {

// A copy of an array to its new place, in words of 16 bytes.
struct Move {
  const uint4* from;
  uint4* to;
  std::size_t words;
};

// The argument of one kernel that makes many copies. Dozens of small arrays move at a time, and a
// copy by the driver takes as long for each of them as one kernel takes for all.
struct Moves {
  static constexpr unsigned kMost = 128;
  Move moves[kMost];
  unsigned count = 0;
};

constexpr unsigned kThreads = 256, kBlocksEach = 64;

// Makes the copies: each row of blocks of the grid (blockIdx.y) makes one.
__global__ void __launch_bounds__(kThreads) moveKernel(Moves moves) {
  const Move move = moves.moves[blockIdx.y];
  const std::size_t stride = gridDim.x * kThreads;
  for (std::size_t i = blockIdx.x * kThreads + threadIdx.x; i < move.words; i += stride) {
    move.to[i] = move.from[i];
  }
}

void launchMoves(Moves& moves, cudaStream_t stream) {
  if (moves.count > 0) moveKernel<<<dim3(kBlocksEach, moves.count), kThreads, 0, stream>>>(moves);
  moves.count = 0;
  checkCuda(cudaGetLastError(), "a kernel that moves arrays");
}

}  // namespace

unsigned char* DeviceMemory::place(const Array& array, std::uint32_t rows) {
  unsigned char* const to = memory_.data() + used_;
  used_ += bytesOf(array, rows);
  return to;
}

void DeviceMemory::grow(const CycleSizes& sizes, cudaStream_t stream) {
  if (!mustGrow(sizes)) return;
  std::size_t growing = 0, all = 0;
  for (const Array& array : arrays_) {
    const std::uint32_t rows = array.rowsFor(sizes);
    all += bytesOf(array, rows);
    if (rows > *array.rows) growing += bytesOf(array, rows);
  }
  const bool moves = used_ + growing > memory_.size();
  DeviceBuffer<unsigned char> other;
  if (moves) {
    // Allocates more than is needed, so that arrays can grow later without another allocation. A
    // scene that grew once may do so again.
    other.grow(all + all / (memory_.size() == 0 ? 8 : 2), stream);
    checkCuda(cudaMemsetAsync(other.data(), 0, other.size(), stream), "cudaMemsetAsync");
    other.swap(memory_);
    used_ = 0;
  }
  Moves kept;
  for (Array& array : arrays_) {
    const std::uint32_t rows = array.rowsFor(sizes);
    if (!moves && rows <= *array.rows) continue;
    unsigned char* const to = place(array, rows);
    if (*array.rows > 0) {  // copies whole words: beyond the last row both places have zeros
      const std::size_t words = (*array.rows * array.row_bytes + sizeof(uint4) - 1) / sizeof(uint4);
      kept.moves[kept.count++] = {static_cast<const uint4*>(*array.data),
                                  reinterpret_cast<uint4*>(to), words};
    }
    *array.data = to;
    *array.rows = rows;
    if (kept.count == Moves::kMost) launchMoves(kept, stream);
  }
  launchMoves(kept, stream);
}

}  // namespace deformable_contact_monitor
