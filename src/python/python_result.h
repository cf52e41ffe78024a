// The class Result of the Python module.
//
// Lists become numpy arrays, which own their memory.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <string>

#include "core/detector.h"

namespace deformable_contact_monitor {

// The bounds of the distance of two bodies, and the state that follows from them.
struct PythonDistance : BodyDistance {
  // Decides the state by the bodies' margins and the tolerance [m].
  PythonDistance(const BodyDistance& in_distance, const Scene& scene, float tolerance_m);

  std::string state;  // "none", "near", "contact", "unknown"
};

// The nearest triangles of two bodies, and the bodies' names.
struct PythonNearest : NearestPair {
  std::string name_a, name_b;
};

// A copy of a result as Python objects. It outlives detector and scene.
struct PythonResult {
  // The lists that scene and options ask for exist even without contacts: separations, geometry,
  // first_times, within_pad.
  PythonResult(const DetectionResult& result, const std::string& in_backend, const Scene& scene,
               const Options& options);

  // The contacts, in ascending order. All arrays below have a row for each of them.
  pybind11::array pairs;         // (k, 4) uint32
  pybind11::object separations;  // (k,) float32, or None
  pybind11::object geometry;     // (k,) of deformable_contact._wire.GEOMETRY, or None
  pybind11::object first_times;  // (k, 2) float32, or None
  pybind11::object within_pad;   // (k,) bool, or None
  // Not of contacts: a list of PythonNearest, and a dictionary of them by (body_a, part_a, body_b,
  // part_b), or None.
  pybind11::object nearest, nearest_parts;
  // Lists of bodies or pairs of bodies.
  pybind11::list without_step;    // ids
  pybind11::list distances;       // PythonDistance
  pybind11::dict rejected_parts;  // counts by (body, part)
  // How the cycle went, as in DetectionResult.
  bool complete, guaranteed, cut_off, started_cold;
  std::string cut_off_because, backend;
  std::uint64_t left_out, memory_bytes;
  bool memory_is_whole;
  double detect_ms, round_trip_ms;
  pybind11::dict counters, stages_ms;
};

// Adds the class Result.
void bindResult(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
