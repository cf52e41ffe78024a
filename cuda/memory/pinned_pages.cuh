// Page-locked memory, as the system hands it out.
#pragma once

#include <cstddef>

namespace deformable_contact_monitor {

// Whole pages that every device reaches by the host's address, and that stay where they are. In
// huge pages where the system has them: to lock 16 MiB takes 3 ms then, else 10. Processes that are
// forked do not have them.
class PinnedPages {
 public:
  // So many bytes at least. Throws CudaError where there is no more.
  explicit PinnedPages(std::size_t bytes);
  PinnedPages(const PinnedPages&) = delete;
  PinnedPages& operator=(const PinnedPages&) = delete;
  ~PinnedPages();

  void* data() const { return data_; }
  std::size_t bytes() const { return bytes_; }

 private:
  void* data_ = nullptr;
  std::size_t bytes_ = 0;
  void* mapped_ = nullptr;  // where the system's pages begin; null: CUDA has made them
};

// Returns the device's address of page-locked host memory, or null if the device cannot reach it.
const void* reachedAt(const void* memory);

}  // namespace deformable_contact_monitor
