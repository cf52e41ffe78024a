// Which backend runs: CUDA or the CPU. Decided here for node, tools and other programs.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/detector.h"
#include "core/export.h"
#include "core/fallback_detector.h"
#include "core/tiling_cache.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {

enum class BackendChoice { kAuto, kCuda, kCpu };

// "auto", "cuda", "cpu".
DCM_EXPORT const char* toString(BackendChoice choice);
// The inverse. Throws std::invalid_argument at any other name.
DCM_EXPORT BackendChoice toBackendChoice(const std::string& name);

// What becomes of kCuda where CUDA cannot be used.
enum class WithoutCuda {
  kTryAgain,  // the CPU takes over until CUDA works again: somebody waits for contacts, for days
  kFallBack,  // the CPU takes over for good: somebody waits for contacts, once
  kRefuse,    // BackendError: somebody measures or compares, and what is called cuda must be CUDA
};

// settings.memory_limit_bytes holds on the CPU too. Sets of enabled pairs that take turns have
// detectors of their own (makePairSetDetector): the bound is for each, and no more are made once
// together they take as much.
// kCpu is the CPU backend. kAuto is CUDA, and the CPU where CUDA cannot be made or fails in a
// detection, by makeFallbackDetector()'s rules, which tell `changed`; so is kCuda unless with
// kRefuse: that is CUDA alone and throws as makeCudaDetector() does. Only with kTryAgain is CUDA
// tried again.
// Where one of several devices is lost, `changed` is told of that too (BackendState::partly).
// `changed` may be empty. Where the CPU takes over, detect() refuses vertices that are on a device
// (Scene::setDeviceVertices).
// `tilings`: null: exact. Else what runs on the CPU is bounded by these (makeBoundedDetector); CUDA
// is exact whatever the tolerance.
DCM_EXPORT std::unique_ptr<Detector> makeDetector(
    BackendChoice choice = BackendChoice::kAuto, WithoutCuda without_cuda = WithoutCuda::kRefuse,
    const CudaSettings& settings = CudaSettings(),
    const std::function<void(const BackendState&)>& changed = nullptr,
    const std::shared_ptr<TilingCache>& tilings = nullptr);

}  // namespace deformable_contact_monitor
