// Makes the detector, and the checker of states, that programs use: CUDA where that works, and the
// CPU elsewhere.
#pragma once

#include <functional>
#include <memory>

#include "core/backend_choice.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/state_checker.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

// Makes a detector pool (core/detector_pool.h) of the backends that are asked for.
// - kCpu: the CPU backend.
// - kAuto: CUDA. The CPU takes over where CUDA cannot be used or fails in a detection.
// - kCuda: the same as kAuto. With kRefuse as `without_cuda`, only CUDA is used, and its errors are
//   thrown.
// CUDA is tried again after a failure only with WithoutCuda::kTryAgain.
//
// `settings`: memory_limit_bytes also bounds the contacts that the CPU lists. Sets of enabled pairs
// have detectors of their own: on CUDA no more are made once all of them together use that much,
// and on the CPU they share their arrays.
// `changed`: is called with the state of CUDA when that changes, and when one of several devices is
// lost (BackendState::partly), from within this function or detect(). May be empty.
// `tilings`: if not null, the CPU decides within Options::tolerance_m and the deadline by bounds of
// these tilings. CUDA is always exact.
//
// Where the CPU takes over, detect() throws std::invalid_argument for vertices that are on a device
// (Scene::setDeviceVertices).
DCM_EXPORT std::unique_ptr<Detector> makeDetector(
    BackendChoice choice = BackendChoice::kAuto, WithoutCuda without_cuda = WithoutCuda::kRefuse,
    const CudaSettings& settings = CudaSettings(),
    const std::function<void(const BackendState&)>& changed = nullptr,
    const std::shared_ptr<TilingCache>& tilings = nullptr);

// Makes a checker of states of the backend that is asked for; `backend` and `changed` are those of
// makeDetector(). Where CUDA cannot be used or fails in a check, the CPU decides that check and all
// later ones; with kCuda and kRefuse the BackendError is thrown instead. With
// kTryAgain the CPU takes over as well, and CUDA is tried again in later checks, at most once a
// second.
DCM_EXPORT std::unique_ptr<StateChecker> makeStateChecker(
    BackendChoice choice = BackendChoice::kAuto, WithoutCuda without_cuda = WithoutCuda::kRefuse,
    const CudaSettings& settings = CudaSettings(),
    const std::function<void(const BackendState&)>& changed = nullptr);

}  // namespace deformable_contact_monitor
