// The class Detector of the Python module.
//
// A detector keeps its warm start between calls, so use one detector for one sequence of scenes.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/common/forks.h"
#include "core/tiling_cache.h"
#include "cuda/detector_choice.h"
#include "python/python_result.h"
#include "python/python_scene.h"

namespace deformable_contact_monitor {

// A detector and its options. Callers must hold Python's global lock, which is released during a
// detection. A call from another thread in that time throws std::runtime_error. So does a call in a
// process that was forked in that time.
class PythonDetector {
 public:
  // Throws std::invalid_argument with all problems(options), and std::runtime_error if a backend
  // that was asked for by name cannot be used.
  PythonDetector(BackendChoice choice, const CudaSettings& settings, const Options& options);
  PythonDetector(const PythonDetector&) = delete;
  PythonDetector& operator=(const PythonDetector&) = delete;

  // Finds all contacts of the scene's enabled pairs. `max_time_s` is the time after which the cycle
  // ends early [s]; nothing: never. Throws std::invalid_argument if it is negative. Warns if no
  // pair is enabled.
  PythonResult detect(PythonScene* scene, std::optional<double> max_time_s);

  // Makes the next cycle a cold start.
  void reset();

  // Returns the name of the backend that ran last.
  const std::string& backend() const { return backend_; }
  // Returns why CUDA is not used, or not for every scene, in one line. Empty: it is used, or was
  // not asked for.
  const std::string& backendProblem() const { return backend_problem_; }

 private:
  // Throws std::runtime_error if another thread's detection uses this detector, or did so when this
  // process was forked.
  void requireUnused() const;
  // Waits for the tilings of all bodies in pairs of two, if bounds are to decide without a
  // deadline.
  void makeTilings(const Scene& scene, const Options& options);
  // Copies what the detector reports about itself.
  void update();

  // The options of every detection, which the constructor has checked.
  Options options_;
  BackendState state_;                    // written while detecting
  std::shared_ptr<TilingCache> tilings_;  // null: there is no tolerance
  std::unique_ptr<Detector> detector_;
  ProcessMark detecting_;
  std::string backend_, backend_problem_;
};

// Checks the ranges that CudaSettings cannot hold. Throws std::invalid_argument.
CudaSettings toSettings(std::int64_t device, std::int64_t memory_limit_mib);

// Returns the time at which a cycle ends early; the far future without a limit [s]. Throws
// std::invalid_argument if it is negative.
SteadyTime deadlineIn(std::optional<double> max_time_s);

// Adds the class Detector.
void bindDetector(
    pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
