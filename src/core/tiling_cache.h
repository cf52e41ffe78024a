// Tilings of bodies, made on a thread of their own while detection goes on without.
#pragma once

#include <cstdint>
#include <memory>

#include "core/export.h"
#include "core/scene.h"
#include "core/tiling.h"

namespace deformable_contact_monitor {

// Keeps one by topology_revision. One thread at a time asks; its end waits for the thread, which
// stops early.
class DCM_EXPORT TilingCache {
 public:
  // So often a topology is asked for before its tiling is begun.
  static constexpr std::uint32_t kSettledAfter = 4;

  TilingCache();
  ~TilingCache();
  TilingCache(const TilingCache&) = delete;
  TilingCache& operator=(const TilingCache&) = delete;

  // By surface, as the body's mesh is when that is begun; null while it is being made, and for good
  // if that failed. To be asked once a cycle for each body: once three times as many calls as there
  // are bodies did not ask for a topology, it is forgotten. Never throws.
  std::shared_ptr<const Tiling> of(const Body& body) noexcept;

  // Waits until all that was begun is there: for tests and benchmarks.
  void wait();

 private:
  class Worker;
  class Memory;
  std::unique_ptr<Worker> worker_;
  std::unique_ptr<Memory> memory_;
};

}  // namespace deformable_contact_monitor
