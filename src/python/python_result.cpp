#include "python/python_result.h"

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

static_assert(sizeof(TrianglePair) == 4 * sizeof(std::uint32_t) &&
                  std::is_standard_layout<TrianglePair>::value,
              "a list of pairs is a table of four columns");

py::array pairTable(const std::vector<TrianglePair>& contacts) {
  const auto* const from = reinterpret_cast<const std::uint32_t*>(contacts.data());
  return py::array_t<std::uint32_t>({contacts.size(), std::size_t{4}}, from);
}

// Records of the wire format, which the members are in the order of, without what pads them.
py::array geometryTable(const std::vector<PairGeometry>& geometry) {
  constexpr std::size_t kBytes = offsetof(PairGeometry, flags) + sizeof(PairGeometry::flags);
  static_assert(kBytes == 41 && std::is_standard_layout<PairGeometry>::value,
                "members stand one behind the other");
  const py::object type = py::module::import("deformable_contact._wire").attr("GEOMETRY");
  py::array table(py::dtype::from_args(type), std::vector<std::size_t>{geometry.size()});
  auto* const to = static_cast<unsigned char*>(table.mutable_data());
  for (std::size_t i = 0; i < geometry.size(); ++i) {
    std::memcpy(to + i * kBytes, &geometry[i], kBytes);
  }
  return table;
}

// The tools' and the node's word: undecided pairs are in the list, so nothing is missing.
bool isComplete(const DetectionResult& result) {
  return result.guaranteed && result.counters.rejected == 0 && result.left_out == 0 &&
         !result.cut_off;
}

py::dict toDict(const Counters& counters) {
  py::dict dict;
  dict["triangles"] = counters.triangles;
  dict["rejected"] = counters.rejected;
  dict["posed"] = counters.posed;
  dict["culled"] = counters.culled;
  dict["clustered"] = counters.clustered;
  dict["large"] = counters.large;
  dict["clusters"] = counters.clusters;
  dict["cluster_entries"] = counters.cluster_entries;
  dict["largest_cluster"] = counters.largest_cluster;
  dict["interval_overlaps"] = counters.interval_overlaps;
  dict["candidates"] = counters.candidates;
  dict["exact"] = counters.exact;
  dict["undecided"] = counters.undecided;
  return dict;
}

std::string describe(const PythonResult& result) {
  return "<Result: " + std::to_string(result.pairs.shape(0)) + " contacts, " +
         (result.complete ? "complete" : "not complete") + ">";
}

constexpr const char* kPairsText =
    R"(The contacts: (k, 4) uint32, body_a triangle_a body_b triangle_b.

Each unordered pair once, (body_a, triangle_a) before (body_b, triangle_b), the rows sorted.)";

constexpr const char* kSeparationsText = R"(Distance of each contact's triangles [m]: (k,) float32.

0 where they intersect. None where no body that takes part has a margin: then all of them do.)";

constexpr const char* kGeometryText =
    R"(Geometry of each contact: (k,) of messages.GEOMETRY, in the rows of pairs.

Fields: point_a, point_b (3,) float32 [m]: ends of the intersection segment (of the longest chord
where coplanar; equal where they touch at a point); of triangles that are apart, the closest points
of a and of b. normal (3,): unit vector from a to b, b moves along it to get clear; zero: undefined.
separation [m]: > 0: distance; <= 0: minus the length of the shortest translation that parts the two
triangles. flags: sum of 1 coplanar, 2 normal undefined, 4 separation undefined, 8 degenerate (a
triangle without area), 16 normal not unique.
None unless Detector(geometry=True), and where max_time_s left no time for it.)";

constexpr const char* kCompleteText = R"(Whether the list is all there is.

True iff the result is guaranteed, and nothing was cut off, left out or rejected. Without it, a pair
that is not in the list may be a contact.)";

constexpr const char* kCutOffText = R"(Whether the cycle ended early: others may be missing.

The pairs that were found are contacts; cut_off_because says why it ended.)";

constexpr const char* kLeftOutText = R"(Contacts that were counted but are not in the list.

The memory limit was reached, or no time was left to sort them. Which ones is arbitrary.)";

constexpr const char* kCountersText = R"(Work done in this cycle, by name [triangles or pairs].

triangles (in the scene), rejected (a vertex is not finite), posed, culled, clustered, large,
clusters, cluster_entries, largest_cluster, interval_overlaps, candidates, exact (undecided by
floating point), undecided (of the contacts: assumed to be some, by conservative predicates).)";

}  // namespace

PythonResult::PythonResult(const DetectionResult& result, const std::string& in_backend,
                           bool any_margin, bool with_geometry)
    : pairs(pairTable(result.contacts)),
      separations(py::none()),
      geometry(py::none()),
      complete(isComplete(result)),
      guaranteed(result.guaranteed),
      cut_off(result.cut_off),
      started_cold(result.started_cold),
      cut_off_because(result.cut_off_because),
      backend(in_backend),
      left_out(result.left_out),
      memory_bytes(result.memory_bytes),
      detect_ms(result.detect_ms),
      round_trip_ms(result.round_trip_ms),
      counters(toDict(result.counters)) {
  if (any_margin) {
    separations = py::array_t<float>(result.separations_m.size(), result.separations_m.data());
  }
  if (with_geometry && result.geometry.size() == result.contacts.size()) {
    geometry = geometryTable(result.geometry);
  }
  for (const auto& [stage, ms] : result.stages_ms) stages_ms[py::str(stage)] = ms;
}

void bindResult(py::module& module) {
  using Self = PythonResult;
  py::class_<Self>(module, "Result", "What one detect() found. Its arrays are its own.")
      .def_readonly("pairs", &Self::pairs, kPairsText)
      .def_readonly("separations_m", &Self::separations, kSeparationsText)
      .def_readonly("geometry", &Self::geometry, kGeometryText)
      .def_readonly("complete", &Self::complete, kCompleteText)
      .def_readonly("guaranteed", &Self::guaranteed,
                    "Whether the settings in force cannot lose a contact.")
      .def_readonly("cut_off", &Self::cut_off, kCutOffText)
      .def_readonly("cut_off_because", &Self::cut_off_because,
                    "'no time' or 'memory_limit_mib'; empty: it was not cut off.")
      .def_readonly("left_out", &Self::left_out, kLeftOutText)
      .def_readonly("backend", &Self::backend, "What ran: 'cpu' or 'cuda'.")
      .def_readonly("started_cold", &Self::started_cold,
                    "Whether nothing of earlier cycles was of use, so that this one took longer.")
      .def_readonly("counters", &Self::counters, kCountersText)
      .def_readonly("stages_ms", &Self::stages_ms, "Time of each stage [ms], by name, in order.")
      .def_readonly("detect_ms", &Self::detect_ms,
                    "From vertices in the backend's memory to contacts there [ms].")
      .def_readonly("round_trip_ms", &Self::round_trip_ms,
                    "From the scene to sorted contacts in host memory [ms].")
      .def_readonly("memory_bytes", &Self::memory_bytes,
                    "In use on a device; 0 where that is not counted.")
      .def("__repr__", &describe);
}

}  // namespace deformable_contact_monitor
