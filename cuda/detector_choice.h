// Which backend runs: CUDA or the CPU. Decided here for node and tools.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/detector.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {

enum class BackendChoice { kAuto, kCuda, kCpu };

// "auto", "cuda", "cpu".
const char* toString(BackendChoice choice);
// The inverse. Throws std::invalid_argument at any other name.
BackendChoice toBackendChoice(const std::string& name);

// What becomes of kCuda where CUDA cannot be used.
enum class WithoutCuda {
  kFallBack,  // the CPU takes over: somebody waits for contacts
  kRefuse,    // CudaError: somebody measures or compares, and what is called cuda must be CUDA
};

// settings.memory_limit_bytes holds on the CPU too.
// kCpu is the CPU backend. kAuto is CUDA, and the CPU once CUDA cannot be made or fails in a
// detection; so is kCuda with kFallBack. The change is for good and calls fell_back(why), one line,
// once. kCuda with kRefuse is CUDA alone and throws as makeCudaDetector() does.
std::unique_ptr<Detector> makeChosenDetector(
    BackendChoice choice, WithoutCuda without_cuda, const CudaSettings& settings,
    const std::function<void(const std::string&)>& fell_back);

}  // namespace deformable_contact_monitor
