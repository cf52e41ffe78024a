// CUDA failures as exceptions.
#pragma once

#include "core/backend_error.h"
#include "core/export.h"

namespace deformable_contact_monitor {

// A call into CUDA failed, or there is something that the CUDA backend cannot do; what() names the
// call and CUDA's reason.
class DCM_EXPORT CudaError : public BackendError {
 public:
  using BackendError::BackendError;
};

}  // namespace deformable_contact_monitor
