// Implements the Python classes StateChecker and StateResults.
#include "python/python_states.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

#include "python/array_arguments.h"
#include "python/python_detector.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

constexpr const char* kCheckerText = R"(Tells what would touch if some bodies stood elsewhere.

For planners, which ask for thousands of states of a robot beside meshes that stay as they are. Each
answer is that of a Detector of its own, exact. It keeps data of bodies from check to check: use one
for many checks. For one thread at a time: a call while another thread's check() runs is refused by a
RuntimeError.)";

constexpr const char* kCheckerInitText = R"(Options, all but the backend by keyword only.

backend: 'cuda', 'cpu', or 'auto': CUDA where it can be used, else the CPU (backend_problem says
    why).
device: of the CUDA devices, which one.
memory_limit_mib: for lists of candidates on CUDA [MiB].
threads: of the CPU backend; 0: all cores.

Raises ValueError at a value out of range; RuntimeError, with the reason, where backend='cuda'
cannot be used.)";

constexpr const char* kCheckText = R"(Decides states: in each, the bodies have other poses.

bodies: ids of the k bodies that move, each once.
poses: (n, k, 4, 4) real numbers, scene frame from body frame: the poses of the bodies in their order,
    state by state, in host memory or, as CuPy, Numba and PyTorch have it, in that of a CUDA device,
    from where it is copied. Each is a rotation and a translation, with the last row 0 0 0 1. A state
    with a pose that is not finite is unknown. Robot.poses() makes them of joint positions.
pairs: whether results list all pairs of bodies that touch (StateResults.pairs). Otherwise a state is
    done at its first contact.
nearest: whether results have the distance and the nearest triangles of each state within the margins
    (Scene.set_margin).
max_time_s: when the check ends early [s]; states that were not decided are unknown. None: never.
Where a body has triangles with a NaN or infinite vertex, no state is free (StateResults.unknown).
Only enabled pairs of two bodies of which one moves are looked at. Other threads run meanwhile.
Raises ValueError for a wrong shape, a pose that is not rigid, a body that does not exist or is there
twice, and a negative time; RuntimeError where the backend fails ('auto' goes on on the CPU instead),
or where another thread uses this checker.)";

// Returns the poses as the core has them. Throws std::invalid_argument for another shape than (n,
// k, 4, 4), for last rows that are not 0 0 0 1, and for finite poses that are not rigid.
std::vector<RigidTransform> toPoses(py::handle poses, std::size_t bodies) {
  using Doubles = py::array_t<double, kPlain>;
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("poses " + what); };
  const py::array given = toHostArray(poses, "poses");
  const char kind = given.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u') refuse("must be real numbers");
  if (given.ndim() != 4 || given.shape(1) != static_cast<py::ssize_t>(bodies) ||
      given.shape(2) != 4 || given.shape(3) != 4) {
    refuse("must have shape (n, " + std::to_string(bodies) + ", 4, 4), but have " +
           std::string(py::str(given.attr("shape"))));
  }
  const auto numbers = Doubles::ensure(given);
  if (!numbers) throw py::error_already_set();
  std::vector<RigidTransform> all(static_cast<std::size_t>(numbers.size()) / 16);
  const double* from = numbers.data();
  for (std::size_t i = 0; i < all.size(); ++i, from += 16) {
    const double* const last = from + 12;
    const bool is_nan = std::isnan(last[0] + last[1] + last[2] + last[3]);
    if (!is_nan && (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1)) {
      refuse("of state " + std::to_string(i / bodies) + ": the last row of pose " +
             std::to_string(i % bodies) + " is not 0 0 0 1");
    }
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) all[i].rotation[3 * r + c] = from[4 * r + c];
      all[i].translation[r] = is_nan ? last[0] + last[1] + last[2] + last[3] : from[4 * r + 3];
    }
    if (isFinite(all[i]) && !isRotation(all[i].rotation)) {
      refuse("of state " + std::to_string(i / bodies) + ": pose " + std::to_string(i % bodies) +
             " is no rotation: it scales, shears or mirrors");
    }
  }
  return all;
}

py::array flags(const std::vector<StateAnswer>& states, bool (*is)(PairDecision)) {
  py::array_t<bool> list(std::vector<std::size_t>{states.size()});
  bool* const to = list.mutable_data();
  for (std::size_t i = 0; i < states.size(); ++i) to[i] = is(states[i].decision);
  return py::array(std::move(list));
}

// Returns an array with a row for each state, filled by write(answer, row).
template <class Number, class Write>
py::object rows(const std::vector<StateAnswer>& states, std::vector<std::size_t> shape,
                const Write& write) {
  shape.insert(shape.begin(), states.size());
  py::array_t<Number> list(shape);
  const std::size_t width =
      states.empty() ? 0 : static_cast<std::size_t>(list.size()) / states.size();
  Number* to = list.mutable_data();
  for (const StateAnswer& answer : states) {
    write(answer, to);
    to += width;
  }
  return py::object(std::move(list));
}

void writePoint(const Vec3f& point, float* to) {
  to[0] = point.x;
  to[1] = point.y;
  to[2] = point.z;
}

float distanceOf(const StateAnswer& answer) {
  if (answer.decision == PairDecision::kOpen) return std::numeric_limits<float>::quiet_NaN();
  if (answer.decision == PairDecision::kNone) return std::numeric_limits<float>::infinity();
  return answer.nearest.distance_m;
}

// Collects the keyword arguments of StateChecker().
std::unique_ptr<PythonStateChecker> makePythonStateChecker(const std::string& backend,
                                                           std::int64_t device,
                                                           std::int64_t memory_limit_mib,
                                                           int threads) {
  requireThreads(threads);
  return std::make_unique<PythonStateChecker>(toBackendChoice(backend),
                                              toSettings(device, memory_limit_mib), threads);
}

// Returns the results of a scene with rejected triangles: nobody knows where these are, so states
// in which the other triangles do not touch are unknown.
StateResults withRejectedUnknown(const StateResults& results) {
  StateResults certain = results;
  for (StateAnswer& answer : certain.states) {
    if (answer.decision != PairDecision::kContact) answer = StateAnswer();
  }
  return certain;
}

// Warns as Python does where every state is free because nothing is looked at.
void warnIfNothingIsLookedAt(const Scene& scene, const std::vector<BodyId>& moved) {
  const auto isMoved = [&moved](BodyId id) {
    return std::find(moved.begin(), moved.end(), id) != moved.end();
  };
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (isMoved(a) || isMoved(b)) return;
  }
  const char* const text =
      "no pair with one of the bodies that move is enabled, so every state is free: call "
      "set_pair_enabled(a, b) first";
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text, 1) != 0) throw py::error_already_set();
}

}  // namespace

PythonStates::PythonStates(const StateResults& results, const StateOptions& options,
                           std::string in_backend)
    : touches(flags(results.states, [](PairDecision d) { return d == PairDecision::kContact; })),
      free(flags(
          results.states,
          [](PairDecision d) { return d == PairDecision::kNone || d == PairDecision::kNear; })),
      unknown(flags(results.states, [](PairDecision d) { return d == PairDecision::kOpen; })),
      distances(py::none()),
      nearest_pairs(py::none()),
      points(py::none()),
      normals(py::none()),
      pairs(py::none()),
      cut_off(results.cut_off),
      cut_off_because(results.cut_off_because),
      backend(std::move(in_backend)),
      check_ms(results.check_ms) {
  if (options.nearest) {
    const std::vector<StateAnswer>& states = results.states;
    distances =
        rows<float>(states, {}, [](const StateAnswer& of, float* to) { *to = distanceOf(of); });
    nearest_pairs = rows<std::uint32_t>(states, {4}, [](const StateAnswer& of, std::uint32_t* to) {
      const TrianglePair& pair = of.nearest.pair;
      to[0] = pair.body_a;
      to[1] = pair.triangle_a;
      to[2] = pair.body_b;
      to[3] = pair.triangle_b;
    });
    points = rows<float>(states, {2, 3}, [](const StateAnswer& of, float* to) {
      writePoint(of.nearest.point_a, to);
      writePoint(of.nearest.point_b, to + 3);
    });
    normals = rows<float>(
        states, {3}, [](const StateAnswer& of, float* to) { writePoint(of.nearest.normal, to); });
  }
  if (options.pairs) {
    static_assert(sizeof(TouchingBodies) == 3 * sizeof(std::uint32_t),
                  "a list of pairs is a table of three columns");
    pairs =
        py::array_t<std::uint32_t>({results.pairs.size(), std::size_t{3}},
                                   reinterpret_cast<const std::uint32_t*>(results.pairs.data()));
  }
  for (const RejectedPart& of : results.rejected) {
    rejected_parts[py::make_tuple(of.body, of.part)] = of.count;
  }
}

PythonStateChecker::PythonStateChecker(BackendChoice choice, const CudaSettings& settings,
                                       int threads)
    : PythonBackend({"StateChecker", "checker", "check()"}, choice,
                    [&](WithoutCuda without_cuda, const auto& tell) {
                      return makeStateChecker(choice, without_cuda, settings, tell);
                    }),
      threads_(threads) {}

PythonStates PythonStateChecker::check(PythonScene* scene, const std::vector<std::int64_t>& bodies,
                                       py::handle poses, bool pairs, bool nearest,
                                       std::optional<double> max_time_s) {
  requireUnused();
  StateBatch batch;
  for (const std::int64_t id : bodies) {
    if (id < 0 || id > std::numeric_limits<BodyId>::max()) {
      throw std::invalid_argument("body " + std::to_string(id) + " does not exist");
    }
    batch.moved.push_back(static_cast<BodyId>(id));
  }
  if (bodies.empty()) throw std::invalid_argument("bodies has none: no body moves");
  const std::vector<RigidTransform> all = toPoses(poses, bodies.size());
  warnIfNothingIsLookedAt(scene->scene(), batch.moved);
  batch.count = all.size() / bodies.size();
  batch.poses = all.data();
  StateOptions options;
  options.pairs = pairs;
  options.nearest = nearest;
  options.threads = threads_;
  options.limits.deadline = deadlineIn(max_time_s);
  return run(
      scene,
      [&](StateChecker* checker) -> const StateResults& {
        return checker->check(scene->scene(), batch, options);
      },
      [&](const StateResults& results) {
        return results.rejected.empty()
                   ? PythonStates{results, options, backend()}
                   : PythonStates{withRejectedUnknown(results), options, backend()};
      });
}

// Arguments are in the order of the stub file.
void bindStates(py::module& module) {
  const CudaSettings settings;
  const auto memory_limit_mib = static_cast<std::int64_t>(settings.memory_limit_bytes >> 20);
  using Self = PythonStateChecker;
  py::class_<Self> checker(module, "StateChecker", kCheckerText);
  checker
      .def(py::init(&makePythonStateChecker), py::arg("backend") = toString(BackendChoice::kAuto),
#if PYBIND11_VERSION_MAJOR > 2 || PYBIND11_VERSION_MINOR >= 6
           py::kw_only(),
#endif
           py::arg("device") = settings.device, py::arg("memory_limit_mib") = memory_limit_mib,
           py::arg("threads") = 0, kCheckerInitText)
      .def("check", &Self::check, py::arg("scene").none(false), py::arg("bodies"), py::arg("poses"),
           py::arg("pairs") = false, py::arg("nearest") = false, py::arg("max_time_s") = py::none(),
           kCheckText);
  bindBackend(&checker, "Forgets what earlier checks left; results never depend on it.");
  py::class_<PythonStates>(module, "StateResults", "What StateChecker.check() found.")
      .def_readonly("touches", &PythonStates::touches, "(n,) bool: some bodies touch.")
      .def_readonly("free", &PythonStates::free,
                    "(n,) bool: certainly, no bodies touch, however near they are.")
      .def_readonly("unknown", &PythonStates::unknown,
                    "(n,) bool: not decided (cut_off), or a pose is not finite, or takes vertices "
                    "beyond float32, or some body that was looked at has triangles with a NaN or "
                    "infinite vertex (rejected_parts) and the others do not touch. Never free.")
      .def_readonly("distances", &PythonStates::distances,
                    "(n,) float32, of the nearest two bodies [m]: 0 where bodies touch, inf where "
                    "all are beyond their margins, NaN where unknown. None without nearest.")
      .def_readonly("nearest_pairs", &PythonStates::nearest_pairs,
                    "(n, 4) uint32: body_a triangle_a body_b triangle_b, where a distance is "
                    "finite; else 0. None without nearest.")
      .def_readonly("points", &PythonStates::points,
                    "(n, 2, 3) float32: the nearest points on body_a and body_b, scene frame [m]. "
                    "None without nearest.")
      .def_readonly("normals", &PythonStates::normals,
                    "(n, 3) float32: unit vectors from body_a to body_b; 0 where bodies touch. "
                    "None without nearest.")
      .def_readonly("pairs", &PythonStates::pairs,
                    "(k, 3) uint32, ascending: state body_a body_b, of all bodies that touch. None "
                    "without pairs.")
      .def_readonly("rejected_parts", &PythonStates::rejected_parts,
                    "{(body, part): triangles with a NaN or infinite vertex}, of pairs that were "
                    "looked at; 0: no named part. While there are any, no state is free. Where "
                    "they may be ignored, leave them out of the mesh (Scene.set_mesh).")
      .def_readonly("cut_off", &PythonStates::cut_off, "Whether time ran out.")
      .def_readonly("cut_off_because", &PythonStates::cut_off_because,
                    "'no time'; empty: it was not cut off.")
      .def_readonly("backend", &PythonStates::backend, "What ran: 'cpu' or 'cuda'.")
      .def_readonly("check_ms", &PythonStates::check_ms, "Time of the whole check [ms].")
      .def("__len__", [](const PythonStates& self) { return self.touches.size(); })
      .def("__repr__", [](const PythonStates& self) {
        return "<StateResults: " + std::to_string(self.touches.size()) + " states>";
      });
}

}  // namespace deformable_contact_monitor
