// The classes StateChecker and StateResults of the Python module.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/state_checker.h"
#include "python/python_backend.h"

namespace deformable_contact_monitor {

// A copy of StateResults as Python objects. It outlives checker and scene.
struct PythonStates {
  PythonStates(const StateResults& results, const StateOptions& options, std::string in_backend);

  pybind11::array touches, free, unknown;  // (n,) bool: exactly one of them, for each state
  // (n,) float32: 0 where bodies touch, +inf where nothing is within its margin, NaN where unknown;
  // (n, 4) uint32; (n, 2, 3) float32; (n, 3) float32. Without a nearest pair 0. Or None.
  pybind11::object distances, nearest_pairs, points, normals;
  pybind11::object pairs;  // (k, 3) uint32: state, body_a, body_b; or None
  pybind11::dict rejected_parts;
  bool cut_off;
  std::string cut_off_because, backend;
  double check_ms;
};

// A checker and its settings.
class PythonStateChecker : public PythonBackend<StateChecker> {
 public:
  // Throws std::invalid_argument for settings out of range, and std::runtime_error if a backend
  // that was asked for by name cannot be used.
  PythonStateChecker(BackendChoice choice, const CudaSettings& settings, int threads);

  // Decides states in which these bodies have these poses, (n, k, 4, 4).
  PythonStates check(PythonScene* scene, const std::vector<std::int64_t>& bodies,
                     pybind11::handle poses, bool pairs, bool nearest,
                     std::optional<double> max_time_s);

 private:
  int threads_;
};

// Adds the classes StateChecker and StateResults.
void bindStates(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
