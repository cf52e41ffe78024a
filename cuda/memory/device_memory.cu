#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

// Behind what is in use of the memory, which has room for it and is zero there.
void DeviceMemory::place(Array& array, std::uint32_t rows, cudaStream_t stream) {
  unsigned char* const to = memory_.data() + used_;
  if (*array.rows > 0) {
    checkCuda(cudaMemcpyAsync(to, *array.data, *array.rows * array.row_bytes,
                              cudaMemcpyDeviceToDevice, stream),
              "cudaMemcpyAsync on the device");
  }
  *array.data = to;
  *array.rows = rows;
  used_ += bytesOf(array, rows);
}

void DeviceMemory::grow(const CycleSizes& sizes, cudaStream_t stream) {
  std::size_t growing = 0, all = 0;
  for (const Array& array : arrays_) {
    const std::uint32_t rows = array.rowsFor(sizes);
    all += bytesOf(array, rows);
    if (rows > *array.rows) growing += bytesOf(array, rows);
  }
  if (growing == 0) return;
  const bool moves = used_ + growing > memory_.size();
  DeviceBuffer<unsigned char> other;
  if (moves) {
    // So that some arrays find room later on without another allocation; what grew once may do so
    // again.
    other.grow(all + all / (memory_.size() == 0 ? 8 : 2));
    other.swap(memory_);
    used_ = 0;
    checkCuda(cudaMemsetAsync(memory_.data(), 0, memory_.size(), stream), "cudaMemsetAsync");
  }
  for (Array& array : arrays_) {
    const std::uint32_t rows = array.rowsFor(sizes);
    if (moves || rows > *array.rows) place(array, rows, stream);
  }
  // Before what the arrays were in is given back.
  if (moves) checkCuda(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
}

}  // namespace deformable_contact_monitor
