#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {
namespace {

// Elements that go elsewhere.
struct Move {
  const uint4* from;
  uint4* to;
  std::size_t words;
};

// As many as a kernel takes as its argument. Dozens of small arrays move at a time, and a copy of
// the driver's takes as long for each of them as this for all.
struct Moves {
  static constexpr unsigned kMost = 128;
  Move moves[kMost];
  unsigned count = 0;
};

constexpr unsigned kThreads = 256, kBlocksEach = 64;

// A row of blocks for each move.
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
  if (!isToGrow(sizes)) return;
  std::size_t growing = 0, all = 0;
  for (const Array& array : arrays_) {
    const std::uint32_t rows = array.rowsFor(sizes);
    all += bytesOf(array, rows);
    if (rows > *array.rows) growing += bytesOf(array, rows);
  }
  const bool moves = used_ + growing > memory_.size();
  DeviceBuffer<unsigned char> other;
  if (moves) {
    // So that some arrays find room later on without another allocation; what grew once may do so
    // again.
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
    if (*array.rows > 0) {  // in whole words: what is behind the last row is zeros in both places
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
