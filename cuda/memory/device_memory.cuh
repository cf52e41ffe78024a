// Declares arrays on the device. Each array is declared in one place, with its element, index and
// size; allocation, growth and the kernels' view follow from the declaration.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/index.h"
#include "cuda/memory/cycle_sizes.cuh"
#include "cuda/memory/device_buffer.cuh"

namespace deformable_contact_monitor {

// Stands for "no index".
constexpr std::uint32_t kNone = ~std::uint32_t{0};

// The number of rows of an array: the field `rows` of CycleSizes (null: none) plus `more`.
struct ArraySize {
  std::uint32_t CycleSizes::*rows;
  std::uint32_t more;
};

// Owns the memory of all arrays that were declared with it. It is one piece, because an allocation
// takes longer than a cycle. Belongs to one detector; for one thread at a time.
class DeviceMemory {
 public:
  DeviceMemory() = default;
  DeviceMemory(const DeviceMemory&) = delete;
  DeviceMemory& operator=(const DeviceMemory&) = delete;

  // Grows every array to at least its size. New rows are zeros, and the others keep their contents.
  // The copies are enqueued in `stream`, which must be the same one in all calls. Arrays may move,
  // so copies of their structs are invalid afterwards. Throws CudaError; then nothing has changed.
  void grow(const CycleSizes& sizes, cudaStream_t stream);

  // Returns whether some array has fewer rows than these sizes ask for.
  bool mustGrow(const CycleSizes& sizes) const {
    return std::any_of(arrays_.begin(), arrays_.end(),
                       [&sizes](const Array& array) { return array.rowsFor(sizes) > *array.rows; });
  }

  std::uint64_t bytes() const { return memory_.bytes(); }

 private:
  friend class ArrayGroup;

  struct Array {
    void** data;  // points to the array's own fields `data_` and `rows_`
    std::uint32_t* rows;
    std::size_t row_bytes;
    ArraySize size;

    std::uint32_t rowsFor(const CycleSizes& sizes) const {
      return std::max(*rows, (size.rows == nullptr ? 0 : sizes.*size.rows) + size.more);
    }
  };

  // Returns the memory of `rows` rows, padded to where the next array may begin [bytes].
  static std::size_t bytesOf(const Array& array, std::uint32_t rows) {
    constexpr std::size_t kAlignment = 256;
    return (rows * array.row_bytes + kAlignment - 1) / kAlignment * kAlignment;
  }
  // Takes room for an array from the unused end of the memory, which is zero. Returns its address.
  unsigned char* place(const Array& array, std::uint32_t rows);

  std::vector<Array> arrays_;
  DeviceBuffer<unsigned char> memory_;
  // Bytes in use, including places that arrays have left.
  std::size_t used_ = 0;
};

// The base of structs in which arrays are declared. Such a struct must live as long as the memory
// does and must not be moved on the host. Kernels get a copy of it.
class ArrayGroup {
 public:
  explicit ArrayGroup(DeviceMemory& memory) : memory_(&memory) {}

 private:
  template <class T, class Id, unsigned kRow>
  friend class DeviceArray;

  void enlist(void** data, std::uint32_t* rows, std::size_t row_bytes, const ArraySize& size) {
    memory_->arrays_.push_back({data, rows, row_bytes, size});
  }

  DeviceMemory* memory_;  // for the host only
};

// An array on the device, with kRow elements T for each Id. On the host it only knows its address
// and size.
template <class T, class Id, unsigned kRow = 1>
class DeviceArray {
 public:
  // Declares an array with as many rows as the field `rows` of the sizes, plus `more`.
  DeviceArray(ArrayGroup& group, std::uint32_t CycleSizes::*rows, std::uint32_t more = 0) {
    group.enlist(&data_, &rows_, kRow * sizeof(T), {rows, more});
  }
  // Declares an array with a fixed number of rows.
  DeviceArray(ArrayGroup& group, std::uint32_t fixed) {
    group.enlist(&data_, &rows_, kRow * sizeof(T), {nullptr, fixed});
  }

  __device__ T& operator[](Id i) const {
    static_assert(kRow == 1, "several elements for each index: see row()");
    return static_cast<T*>(data_)[i.value];
  }
  // Returns the kRow elements of one index.
  __device__ T* row(Id i) const { return static_cast<T*>(data_) + std::size_t{i.value} * kRow; }

  // Returns the number of rows that there is room for.
  __host__ __device__ std::uint32_t size() const { return rows_; }
  // Returns the device's address of the first element.
  __host__ __device__ T* data() const { return static_cast<T*>(data_); }

 private:
  void* data_ = nullptr;
  std::uint32_t rows_ = 0;
};

// The index of arrays whose elements have no index type of their own.
using Place = Index<struct PlaceTag>;

// Points to page-locked memory of the host, through which kernels and the host exchange values.
template <class T>
class PinnedPointer {
 public:
  void pointTo(T* on_host) { on_host_ = on_host; }
  __device__ T* onHost() const { return on_host_; }

 private:
  T* on_host_ = nullptr;
};

}  // namespace deformable_contact_monitor
