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
  TilingCache();
  ~TilingCache();
  TilingCache(const TilingCache&) = delete;
  TilingCache& operator=(const TilingCache&) = delete;

  // By surface; null while it is being made, which this begins once the body had the same topology
  // for `settled_after` calls. What no body of later calls has is forgotten.
  std::shared_ptr<const Tiling> of(const Body& body);

  // Waits until all that was asked for is there: for tests and benchmarks.
  void wait();

 private:
  class Worker;
  std::unique_ptr<Worker> worker_;
};

}  // namespace deformable_contact_monitor
