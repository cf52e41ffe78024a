// The detector of the Python module.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>

#include "cuda/detector_choice.h"
#include "python/python_result.h"
#include "python/python_scene.h"

namespace deformable_contact_monitor {

// A detector and its options. For threads that hold Python's global lock, which is released while
// it detects; another thread's call is refused then (std::runtime_error).
class PythonDetector {
 public:
  // Throws std::invalid_argument, listing all problems(options); a std::runtime_error where the
  // backend was asked for by name and cannot be used.
  PythonDetector(BackendChoice choice, const CudaSettings& settings, const Options& options);
  PythonDetector(const PythonDetector&) = delete;
  PythonDetector& operator=(const PythonDetector&) = delete;

  // `max_time_s`: the cycle ends early then; none: never.
  PythonResult detect(PythonScene* scene, std::optional<double> max_time_s);

  void reset();

  const std::string& backend() const { return backend_; }
  // Why CUDA is not used or not for every scene, one line; empty: it is, or was not asked for.
  const std::string& backendProblem() const { return backend_problem_; }

 private:
  void requireUnused() const;
  // Takes over what the detector says of itself.
  void update();

  Options options_;
  BackendState state_;  // written while detecting
  std::unique_ptr<Detector> detector_;
  bool detecting_ = false;
  std::string backend_, backend_problem_;
};

// Adds the class Detector.
void bindDetector(
    pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
