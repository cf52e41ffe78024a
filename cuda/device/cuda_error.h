// CUDA failures as exceptions.
#pragma once

#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

// A call into CUDA failed; what() names the call and CUDA's reason.
class CudaError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace deformable_contact_monitor
