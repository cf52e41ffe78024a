// The class Detector of the Python module.
//
// A detector keeps its warm start between calls, so use one detector for one sequence of scenes.
#pragma once

#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/tiling_cache.h"
#include "python/python_backend.h"
#include "python/python_result.h"

namespace deformable_contact_monitor {

// A detector and its options.
class PythonDetector : public PythonBackend<Detector> {
 public:
  // Throws std::invalid_argument with all problems(options), and std::runtime_error if a backend
  // that was asked for by name cannot be used.
  PythonDetector(BackendChoice choice, const CudaSettings& settings, const Options& options);

  // Finds all contacts of the scene's enabled pairs. `max_time_s` is the time after which the cycle
  // ends early [s]; nothing: never. Throws std::invalid_argument if it is negative. Warns if no
  // pair is enabled.
  PythonResult detect(PythonScene* scene, std::optional<double> max_time_s);

 private:
  PythonDetector(BackendChoice choice, const CudaSettings& settings, const Options& options,
                 const std::shared_ptr<TilingCache>& tilings);
  // Waits for the tilings of all bodies in pairs of two, if bounds are to decide without a
  // deadline.
  void makeTilings(const Scene& scene, const Options& options);

  // The options of every detection, which the constructor has checked.
  Options options_;
  std::shared_ptr<TilingCache> tilings_;  // null: there is no tolerance
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
