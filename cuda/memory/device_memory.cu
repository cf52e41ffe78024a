#include "cuda/memory/device_memory.cuh"

namespace deformable_contact_monitor {

bool DeviceMemory::grow(const CycleSizes& sizes) {
  bool moved = false;
  for (Array& array : arrays_) {
    const std::uint32_t rows =
        (array.size.rows == nullptr ? 0 : sizes.*array.size.rows) + array.size.more;
    if (rows <= *array.rows) continue;
    // While it is being replaced there is none.
    *array.data = nullptr;
    *array.rows = 0;
    array.buffer = nullptr;
    array.buffer = std::make_unique<DeviceBuffer<unsigned char>>(rows * array.row_bytes);
    *array.data = array.buffer->data();
    *array.rows = rows;
    moved = true;
  }
  return moved;
}

std::uint64_t DeviceMemory::bytes() const {
  std::uint64_t bytes = 0;
  for (const Array& array : arrays_) bytes += array.buffer ? array.buffer->bytes() : 0;
  return bytes;
}

}  // namespace deformable_contact_monitor
