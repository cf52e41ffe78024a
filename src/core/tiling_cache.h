// Tilings of bodies, made on a thread of their own while detection goes on without.
#pragma once

#include <cstdint>
#include <memory>

#include "core/export.h"
#include "core/scene.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Keeps one by topology_revision. One thread at a time asks. Its end waits for the thread, which
// stops within some milliseconds.
class DCM_EXPORT TilingCache {
 public:
  // So often a topology is asked for before its tiling is begun.
  static constexpr std::uint32_t kSettledAfter = 4;

  TilingCache();
  ~TilingCache();
  TilingCache(const TilingCache&) = delete;
  TilingCache& operator=(const TilingCache&) = delete;

  // By surface, of the mesh as it is when that is begun; null while it is being made, and for good
  // where memory or threads do not suffice. To be asked for each body in every cycle: what some
  // cycles do not ask for is forgotten.
  std::shared_ptr<const Tiling> of(const Body& body) noexcept;

  // Waits until all that was begun is there: for tests and benchmarks.
  void wait();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace deformable_contact_monitor
