// The result of the Python module.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <string>

#include "core/detector.h"

namespace deformable_contact_monitor {

// What is certain of the distance of two bodies.
struct PythonDistance {
  PythonDistance(const BodyDistance& in_distance, const Scene& scene, float tolerance_m);

  BodyDistance distance;
  std::string state;  // "none", "near", "contact", "unknown"
};

// A copy of a result, as Python's own objects: it outlives detector and scene.
struct PythonResult {
  // What scene and options give is there, however few the contacts are: separations, geometry,
  // first_times, within_pad.
  PythonResult(const DetectionResult& result, const std::string& in_backend, const Scene& scene,
               const Options& options);

  pybind11::array pairs;         // (k, 4) uint32
  pybind11::object separations;  // (k,) float32, or None
  pybind11::object geometry;     // (k,) of deformable_contact._wire.GEOMETRY, or None
  pybind11::object first_times;  // (k, 2) float32, or None
  pybind11::object within_pad;   // (k,) bool, or None
  pybind11::list without_step;   // ids
  pybind11::list distances;      // PythonDistance
  bool complete, guaranteed, cut_off, started_cold;
  std::string cut_off_because, backend;
  std::uint64_t left_out, memory_bytes;
  double detect_ms, round_trip_ms;
  pybind11::dict counters, stages_ms;
};

// Adds the class Result.
void bindResult(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
