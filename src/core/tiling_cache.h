// Tilings of bodies, made on a thread of their own while detection goes on without them.
#pragma once

#include <cstdint>
#include <memory>

#include "core/export.h"
#include "core/scene.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Keeps one tiling for each Body::topology_revision. One thread at a time calls it. Its destructor
// waits for the thread, which stops within a few milliseconds.
class DCM_EXPORT TilingCache {
 public:
  // How often a topology must be asked for before its tiling is begun. Topologies that change all
  // the time never get one.
  static constexpr std::uint32_t kSettledAfter = 4;

  TilingCache();
  ~TilingCache();
  TilingCache(const TilingCache&) = delete;
  TilingCache& operator=(const TilingCache&) = delete;

  // Returns the body's tiling by surface, of the mesh as it was when the tiling was begun. Returns
  // null while it is being made, and for good if memory or threads are not enough. Call it for each
  // body in every cycle: what several cycles do not ask for is forgotten.
  std::shared_ptr<const Tiling> of(const Body& body) noexcept;

  // Waits until all tilings that were begun are made. For tests and benchmarks.
  void wait();

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace deformable_contact_monitor
