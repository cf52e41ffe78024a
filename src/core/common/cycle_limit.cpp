#include "core/common/cycle_limit.h"

namespace deformable_contact_monitor {
namespace {

const CycleLimit no_limit{Limits()};

}  // namespace

bool CycleLimit::look() const {
  if (limits_.stop != nullptr && limits_.stop->load(std::memory_order_relaxed)) {
    why_.store("stopped", std::memory_order_relaxed);
  } else if (std::chrono::steady_clock::now() >= limits_.deadline) {
    why_.store(kNoTime, std::memory_order_relaxed);
  }
  return wasOver();
}

const CycleLimit& noLimit() { return no_limit; }

}  // namespace deformable_contact_monitor
