// Copies a DetectionResult into numpy arrays and Python lists, and binds the class Result. Lists of
// plain structs are copied in one piece; assertions make sure that their memory is a table of rows.
#include "python/python_result.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "core/body_distance.h"
#include "core/common/rejected_bodies.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

static_assert(sizeof(TrianglePair) == 4 * sizeof(std::uint32_t) &&
                  std::is_standard_layout<TrianglePair>::value,
              "a list of pairs is a table of four columns");

// Returns (k, 4) uint32: body_a, triangle_a, body_b, triangle_b.
py::array pairTable(const TrianglePairs& contacts) {
  const auto* const from = reinterpret_cast<const std::uint32_t*>(contacts.data());
  return py::array_t<std::uint32_t>({contacts.size(), std::size_t{4}}, from);
}

static_assert(sizeof(FirstContact) == 2 * sizeof(float) &&
                  std::is_standard_layout<FirstContact>::value,
              "a list of times is a table of two columns");

// Returns (k, 2) float32: low, high.
py::array timeTable(const std::vector<FirstContact>& times) {
  const auto* const from = reinterpret_cast<const float*>(times.data());
  return py::array_t<float>({times.size(), std::size_t{2}}, from);
}

// numpy's bool has one byte, as the flags do.
py::array_t<bool> flagList(const std::vector<std::uint8_t>& flags) {
  py::array_t<bool> list(std::vector<std::size_t>{flags.size()});
  std::copy(flags.begin(), flags.end(), list.mutable_data());
  return list;
}

// Returns records of the wire format. Its fields have the order and the types of PairGeometry's
// members, but no padding at the end, so each record is copied without it.
py::array geometryTable(const HostList<PairGeometry>& geometry) {
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

// Returns the counters by their names.
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

// Returns how many triangles were rejected, by (body, part). The result has only bodies with named
// parts; here, 0 is the part of the others.
py::dict rejectedParts(const DetectionResult& result, const RejectedBodies& rejected) {
  py::dict dict;
  for (const RejectedPart& of : result.rejected_parts) {
    dict[py::make_tuple(of.body, of.part)] = of.count;
  }
  for (BodyId id = 0; id < rejected.counts().size(); ++id) {
    const RejectedTriangles& of = rejected.counts()[id];
    if (of.by_part.empty() && of.count > 0) dict[py::make_tuple(id, PartId{0})] = of.count;
  }
  return dict;
}

// Returns the text of repr().
std::string describe(const PythonResult& result) {
  return "<Result: " + std::to_string(result.pairs.shape(0)) + " contacts, " +
         (result.complete ? "complete" : "not complete") + ">";
}

// Returns the text of repr() of a NearestPair.
std::string describeNearest(const PythonNearest& pair) {
  return "<NearestPair: " + pair.name_a + " and " + pair.name_b + ", " +
         std::to_string(pair.distance_m) + " m>";
}

constexpr const char* kDistancesText = R"(What is certain of the distance of pairs of two bodies.

A list of BodyDistance, ascending, of each enabled pair of two bodies, where the detection looked at
bounds (Detector(tolerance_m=...); on the CPU with max_time_s from the fifth detection of a
topology on); else empty, and pairs say all.)";

constexpr const char* kDistanceText = R"(What is certain of the distance of two bodies [m].)";

constexpr const char* kStateText =
    R"('none': farther apart than the margin; 'near': apart, and within
margin and tolerance; 'contact': two points are at most tolerance_m apart; 'unknown': not decided
in time, or one of the two has rejected triangles (Result.rejected_parts) and the others do not
touch: nobody knows where those are. All but the last are certain.)";

constexpr const char* kNearestText =
    R"(The nearest triangles of each enabled pair of two bodies that is at most its margin apart.

A list of NearestPair, ascending by (body_a, body_b); None unless Detector(nearest=True). A pair of
bodies that is missing is farther apart than the larger of its margins (Scene.set_margin), unless
cut_off is true or one of the two has rejected triangles (rejected_parts): then nothing is known of
it. Rejected triangles take no part, so a distance of such a body is an upper bound. Also in swept
motion, distances are those of the present moment. A body with itself has no distance.)";

constexpr const char* kNearestPartsText =
    R"(The same for each enabled pair of parts of two bodies of which one has named parts.

NearestPair by (body_a, part_a, body_b, part_b), ascending; None unless
Detector(nearest=True, nearest_by_part=True).)";

constexpr const char* kNearestPairText =
    R"(The nearest triangles of two bodies. Of several at the same distance, the first.)";

constexpr const char* kPairsText =
    R"(The contacts: (k, 4) uint32, body_a triangle_a body_b triangle_b.

Each unordered pair once, (body_a, triangle_a) before (body_b, triangle_b), the rows sorted.)";

constexpr const char* kSeparationsText = R"(Distance of each contact's triangles [m]: (k,) float32.

0 where they intersect. None where all of them do: no body that takes part has a margin, motion is
swept, or Detector(nearest=True) without near_pairs.)";

constexpr const char* kGeometryText =
    R"(Geometry of each contact: (k,) of messages.GEOMETRY, in the rows of pairs.

Fields: point_a, point_b (3,) float32 [m]: ends of the intersection segment (of the longest chord
where coplanar; equal where they touch at a point); of triangles that are apart, the closest points
of a and of b. normal (3,): unit vector from a to b, b moves along it to get clear; zero: undefined.
separation [m]: > 0: distance; <= 0: minus the length of the shortest translation that parts the two
triangles. flags: sum of 1 coplanar, 2 normal undefined, 4 separation undefined, 8 degenerate (a
triangle without area), 16 normal not unique.
None unless Detector(geometry=True), and where max_time_s left no time for it.)";

constexpr const char* kFirstTimesText =
    R"(When each contact begins: (k, 2) float32, low and high, in the rows of pairs.

Parts [0, 1] of the step: certainly not before low, certainly at some time in [low, high]; at most
2^-20 apart where predicates are exact. 0 and 0: at its beginning. These are the times of the straight
ways, from which pads may differ. Of what within_pad marks: the time before which the two are farther
apart than their pads, and 1.
None unless Detector(motion='swept', first_times=True).)";

constexpr const char* kWithinPadText =
    R"(Which contacts are none on the straight ways, but may be one within the pads: (k,) bool.

Some of them stay farther apart than their pads, by up to 1/2048 of their way.
None unless motion is swept and some body that takes part has a pad.)";

constexpr const char* kWithoutStepText =
    R"(Ids of the bodies that took part in swept motion without an earlier state.

They stood still. Empty in instant motion.)";

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

PythonDistance::PythonDistance(const BodyDistance& in_distance, const Scene& scene,
                               float tolerance_m)
    : BodyDistance(in_distance), state(toString(decide(in_distance, scene, tolerance_m))) {}

// Copies everything: the detector overwrites its result in the next cycle.
PythonResult::PythonResult(const DetectionResult& result, const std::string& in_backend,
                           const Scene& scene, const Options& options)
    : pairs(pairTable(result.contacts)),
      separations(py::none()),
      geometry(py::none()),
      first_times(py::none()),
      within_pad(py::none()),
      nearest(py::none()),
      nearest_parts(py::none()),
      complete(result.isComplete()),
      guaranteed(result.guaranteed),
      cut_off(result.cut_off),
      started_cold(result.started_cold),
      cut_off_because(result.cut_off_because),
      backend(in_backend),
      left_out(result.left_out),
      memory_bytes(result.memory_bytes),
      memory_is_whole(result.memory_is_whole),
      detect_ms(result.detect_ms),
      round_trip_ms(result.round_trip_ms),
      counters(toDict(result.counters)) {
  const bool swept = options.motion == Motion::kSwept;
  // Separations exist only with margins; swept motion has no margins.
  if (scene.anyMargin() && !swept && (options.near_pairs || !options.nearest)) {
    separations = py::array_t<float>(result.separations_m.size(), result.separations_m.data());
  }
  if (options.geometry && result.geometry.size() == result.contacts.size()) {
    geometry = geometryTable(result.geometry);
  }
  if (options.first_times) first_times = timeTable(result.first_times);
  if (swept && scene.anyPad()) within_pad = flagList(result.within_pad);
  const auto named = [&scene](const NearestPair& pair) {
    return PythonNearest{pair, scene.body(pair.pair.body_a).name,
                         scene.body(pair.pair.body_b).name};
  };
  if (options.nearest) {
    py::list all;
    for (const NearestPair& pair : result.nearest) all.append(named(pair));
    nearest = all;
  }
  if (options.nearest_by_part) {
    py::dict all;
    for (const auto& [of, pair] : result.nearest_parts) {
      all[py::make_tuple(of.body_a, of.part_a, of.body_b, of.part_b)] = named(pair);
    }
    nearest_parts = all;
  }
  for (const BodyId body : result.without_step) without_step.append(body);
  const RejectedBodies rejected(scene, options.motion, result.counters.rejected);
  rejected_parts = rejectedParts(result, rejected);
  for (const BodyDistance& distance : result.distances) {
    distances.append(PythonDistance(rejected.certain(distance), scene, options.tolerance_m));
  }
  for (const auto& [stage, ms] : result.stages_ms) stages_ms[py::str(stage)] = ms;
}

namespace {

// Returns what reads a point or a direction of an object as (x, y, z).
template <class Self, class Owner>
auto tupleOf(Vec3f Owner::*member) {
  return [member](const Self& self) {
    const Vec3f& v = self.*member;
    return py::make_tuple(v.x, v.y, v.z);
  };
}

// Returns what reads the two triangles of an object.
template <class Self, class Owner>
auto trianglesOf(TrianglePair Owner::*member) {
  return [member](const Self& self) {
    return py::make_tuple((self.*member).triangle_a, (self.*member).triangle_b);
  };
}

// Adds the class BodyDistance.
void bindDistance(py::module& module) {
  using Self = PythonDistance;
  py::class_<Self>(module, "BodyDistance", kDistanceText)
      .def_readonly("body_a", &Self::body_a, "The lower id.")
      .def_readonly("body_b", &Self::body_b, "The other id.")
      .def_readonly("state", &Self::state, kStateText)
      .def_readonly("low_m", &Self::low_m,
                    "No two points are nearer; 0: nothing is known, as of bodies with rejected "
                    "triangles.")
      .def_readonly("high_m", &Self::high_m,
                    "point_a and point_b are at most so far apart; inf: there are none.")
      .def_property_readonly("triangles", trianglesOf<Self>(&Self::witness), "Of the two points.")
      .def_property_readonly("point_a", tupleOf<Self>(&Self::point_a),
                             "On body_a, in the scene frame [m].")
      .def_property_readonly("point_b", tupleOf<Self>(&Self::point_b),
                             "On body_b, in the scene frame [m].")
      .def_readonly("is_listed", &Self::is_listed,
                    "Whether Result.pairs has all contacts of the two. False for bodies with "
                    "rejected triangles.")
      .def_readonly("contact_count", &Self::contact_count, "How many it has of them.");
}

// Adds the class NearestPair.
void bindNearest(py::module& module) {
  using Self = PythonNearest;
  py::class_<Self>(module, "NearestPair", kNearestPairText)
      .def_property_readonly(
          "body_a", [](const Self& self) { return self.pair.body_a; }, "The lower id.")
      .def_property_readonly(
          "body_b", [](const Self& self) { return self.pair.body_b; }, "The other id.")
      .def_property_readonly(
          "names", [](const Self& self) { return py::make_tuple(self.name_a, self.name_b); },
          "Of the two bodies.")
      .def_property_readonly("triangles", trianglesOf<Self>(&Self::pair),
                             "The two triangles: of body_a, of body_b.")
      .def_readonly("distance_m", &Self::distance_m,
                    "Distance of the two bodies [m]; 0: they touch.")
      .def_property_readonly("point_a", tupleOf<Self>(&Self::point_a),
                             "The nearest point on body_a, in the scene frame [m].")
      .def_property_readonly("point_b", tupleOf<Self>(&Self::point_b),
                             "The nearest point on body_b, in the scene frame [m].")
      .def_property_readonly("normal", tupleOf<Self>(&Self::normal),
                             "Unit vector from a to b, in the scene frame; zero if they touch.")
      .def("__repr__", &describeNearest);
}

}  // namespace

void bindResult(py::module& module) {
  using Self = PythonResult;
  bindDistance(module);
  bindNearest(module);
  py::class_<Self>(module, "Result", "What one detect() found. Its arrays are its own.")
      .def_readonly("pairs", &Self::pairs, kPairsText)
      .def_readonly("separations_m", &Self::separations, kSeparationsText)
      .def_readonly("geometry", &Self::geometry, kGeometryText)
      .def_readonly("first_times", &Self::first_times, kFirstTimesText)
      .def_readonly("within_pad", &Self::within_pad, kWithinPadText)
      .def_readonly("without_step", &Self::without_step, kWithoutStepText)
      .def_readonly("distances", &Self::distances, kDistancesText)
      .def_readonly("nearest", &Self::nearest, kNearestText)
      .def_readonly("nearest_parts", &Self::nearest_parts, kNearestPartsText)
      .def_readonly(
          "rejected_parts", &Self::rejected_parts,
          "{(body, part): triangles with a NaN or infinite vertex}; 0: no named part. They "
          "take no part. Where vertices of a body are on a device, only bodies with "
          "named parts are listed.")
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
                    "Device memory that this process takes, the driver's context and the stacks of "
                    "kernels included; 0 on the CPU.")
      .def_readonly("memory_is_whole", &Self::memory_is_whole,
                    "Whether the driver told memory_bytes. If not, as on Jetson, it is only what "
                    "the library has allocated.")
      .def("__repr__", &describe);
}

}  // namespace deformable_contact_monitor
