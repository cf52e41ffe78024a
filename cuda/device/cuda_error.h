// Reports CUDA failures as exceptions.
#pragma once

#include "core/backend_error.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// Thrown when a CUDA call fails, or when the CUDA backend does not support what it is asked for.
// what() names the call and CUDA's reason.
class DCM_EXPORT CudaError : public BackendError {
 public:
  using BackendError::BackendError;
};

}  // namespace deformable_contact_monitor
