// Arrays on the device that are declared once: element, index and size stand where the array does,
// and room, bytes and the kernels' view follow from that.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/index.h"
#include "cuda/memory/cycle_sizes.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// In place of a number: there is none.
constexpr std::uint32_t kNone = ~std::uint32_t{0};

// How many rows an array has: `rows` of the sizes (null: none) and `more`.
struct ArraySize {
  std::uint32_t CycleSizes::*rows;
  std::uint32_t more;
};

// Owns the memory of the arrays that were declared with it: one piece for all of them, for to
// allocate takes longer than a cycle. One detector's; one thread at a time.
class DeviceMemory {
 public:
  DeviceMemory() = default;
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  // Every array to at least its size; what is new of one that grows is zeros, the rest stays, in
  // `stream`, always the same one. Then arrays may have moved, and copies of them are of no use any
  // more. Throws CudaError; then all is as it was.
  void grow(const CycleSizes& sizes, cudaStream_t stream);

  // Whether some array is not of that size yet.
  bool isToGrow(const CycleSizes& sizes) const {
    return std::any_of(arrays_.begin(), arrays_.end(),
                       [&sizes](const Array& array) { return array.rowsFor(sizes) > *array.rows; });
  }

  std::uint64_t bytes() const { return memory_.bytes(); }

 private:
  friend class ArrayGroup;

  struct Array {
    void** data;  // the two in the array itself
    std::uint32_t* rows;
    std::size_t row_bytes;
    ArraySize size;

    std::uint32_t rowsFor(const CycleSizes& sizes) const {
      return std::max(*rows, (size.rows == nullptr ? 0 : sizes.*size.rows) + size.more);
    }
  };

  // What so many rows take, up to where the next array may begin [bytes].
  static std::size_t bytesOf(const Array& array, std::uint32_t rows) {
    constexpr std::size_t kAlignment = 256;
    return (rows * array.row_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }
  // Behind what is in use of the memory, which has room for it and is zero there; returns where.
  unsigned char* place(const Array& array, std::uint32_t rows);

  std::vector<Array> arrays_;
  DeviceBuffer<unsigned char> memory_;
  std::size_t used_ = 0;  // of it, places that arrays have left included [bytes]
};

// What arrays are declared in: a struct of them derives from this, and lives as long as the memory
// does, in one place. Kernels get a copy of it.
class ArrayGroup {
 public:
  explicit ArrayGroup(DeviceMemory& memory) : memory_(&memory) {}

 private:
  template <class T, class Id, unsigned kRow>
  friend class DeviceArray;

  void enlist(void** data, std::uint32_t* rows, std::size_t row_bytes, const ArraySize& size) {
    memory_->arrays_.push_back({data, rows, row_bytes, size});
  }

  DeviceMemory* memory_;  // of use on the host alone
};

// Elements T on the device, kRow of them for each Id. On the host it only says where they are.
template <class T, class Id, unsigned kRow = 1>
class DeviceArray {
 public:
  // As many rows as `rows` of the sizes says, and `more`.
  DeviceArray(ArrayGroup& group, std::uint32_t CycleSizes::*rows, std::uint32_t more = 0) {
    group.enlist(&data_, &rows_, kRow * sizeof(T), {rows, more});
  }
  // Always so many rows.
  DeviceArray(ArrayGroup& group, std::uint32_t fixed) {
    group.enlist(&data_, &rows_, kRow * sizeof(T), {nullptr, fixed});
  }

  __device__ T& operator[](Id i) const {
    static_assert(kRow == 1, "several elements for each index: see row()");
    return static_cast<T*>(data_)[i.value];
  }
  // The kRow elements of one index.
  __device__ T* row(Id i) const { return static_cast<T*>(data_) + std::size_t{i.value} * kRow; }

  // Rows that there is room for.
  __host__ __device__ std::uint32_t size() const { return rows_; }
  // The device's address of the first element: for copies, and where places have no type.
  __host__ __device__ T* data() const { return static_cast<T*>(data_); }

 private:
  void* data_ = nullptr;
  std::uint32_t rows_ = 0;
};

// A place in an array whose elements have no name of their own.
using Place = Index<struct PlaceTag>;

// Page-locked memory of the host, through which kernels and the host tell each other things.
template <class T>
class PinnedPointer {
 public:
  void pointTo(T* on_host) { on_host_ = on_host; }
  __device__ T* onHost() const { return on_host_; }

 private:
  T* on_host_ = nullptr;
};

}  // namespace deformable_contact_monitor
