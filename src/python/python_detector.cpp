// Implements the Python class Detector: checks the arguments, runs detections without Python's
// global lock, and copies results into Python objects.
#include "python/python_detector.h"

#include <pybind11/stl.h>

#include <chrono>
#include <initializer_list>
#include <set>
#include <stdexcept>

#include "core/options.h"

namespace deformable_contact_monitor {
namespace py = pybind11;
namespace {

constexpr const char* kDetectorText = R"(Finds every contact of a scene's enabled pairs.

It keeps buffers and prototypes from cycle to cycle: use one for many cycles. For one thread at a
time: a call while another thread's detect() runs is refused by a RuntimeError. After a fork (os.fork, multiprocessing's 'fork') the
child may use it, on one thread; on CUDA, or if the fork came during detect(), it is refused there by
a RuntimeError, and 'auto' goes on on the CPU.)";

constexpr const char* kInitText = R"(Options, all but the backend by keyword only.

backend: 'cuda', 'cpu', or 'auto': CUDA where it can be used, else the CPU, for as long as CUDA
    fails (backend_problem says why).
device: of the CUDA devices, which one.
memory_limit_mib: for lists of contacts, and of candidates on CUDA [MiB].
motion: 'instant': contacts at one moment; 'swept': those at some time of the step from each body's
    earlier state (Scene.set_earlier) to its present one. Margins play no part then.
first_times: whether results have the time of each contact's begin; swept only.
adjacent_pairs: triangles of one body that share a vertex: 'beyond_shared' reports those that meet
    beyond what they share, 'skip' none.
predicates: 'exact', or 'conservative' (what double arithmetic cannot decide counts as contact).
overlap: share [0, 1] of a triangle that decides its clusters; below 1, contacts are lost.
clusters (0: from the scene), fuzzifier [1.05, 4], iterations [0, 100], refresh_period (>= 1):
    speed alone while overlap is 1 and predicates are exact.
threads: of the CPU backend; 0: all cores.
geometry: whether results have the geometry of each contact; instant only.
tolerance_m: how far off the distance of two bodies may be [m]; 0: exact. Above, the CPU decides
    pairs of two bodies by bounds (Result.distances), sooner, and lists the contacts that it saw on
    the way alone. The first detection of a topology takes about 1 ms longer per 1000 triangles;
    with max_time_s, bounds decide from the fifth on. CUDA is exact all the same. Instant only.
nearest: whether results have the distance and the nearest triangles of each enabled pair of two
    bodies within its margin (Result.nearest). The margin then costs a search and no list: pairs
    are those that touch.
near_pairs: with nearest, also list as pairs all triangles within the margin.
nearest_by_part: with nearest, find the same for each enabled pair of parts (Result.nearest_parts).
    Each costs a search of its own.

Raises ValueError that lists every value out of range; RuntimeError, with the reason, where
backend='cuda' cannot be used.)";

constexpr const char* kDetectText = R"(Finds every contact of the scene's enabled pairs.

max_time_s: when the cycle ends early [s], with what was found by then (Result.cut_off); None:
    never. Ctrl-C waits for the end of the cycle.
Other threads run meanwhile.
Warns (RuntimeWarning) where no pair of the scene is enabled.
Raises ValueError at a negative time; RuntimeError where the backend fails ('auto' goes on on the
CPU instead), or where another thread uses this detector.)";

constexpr int kMaxDevice = 1023;
constexpr std::int64_t kMaxMemoryMib = 1 << 20;

// Returns the one of `all` that has this name. Throws with all names if there is none.
template <class Choice>
Choice choiceOf(const std::string& argument, const std::string& name,
                std::initializer_list<Choice> all) {
  std::string names;
  for (const Choice choice : all) {
    if (name == toString(choice)) return choice;
    names += (names.empty() ? "" : ", ") + std::string(toString(choice));
  }
  throw std::invalid_argument(argument + " '" + name + "' is none of " + names);
}

// Warns as Python does, which shows each place once. Throws what a filter of the user makes of it.
void warnIfNothingIsEnabled(const Scene& scene) {
  if (!scene.enabledPairs().empty()) return;
  const char* const text =
      "no pair of the scene's bodies is enabled, so detect() finds nothing: call "
      "set_pair_enabled(a, b) first";
  if (PyErr_WarnEx(PyExc_RuntimeWarning, text, 1) != 0) throw py::error_already_set();
}

// Collects the keyword arguments of Detector().
std::unique_ptr<PythonDetector> makePythonDetector(
    const std::string& backend, std::int64_t device, std::int64_t memory_limit_mib,
    const std::string& adjacent_pairs, const std::string& predicates, float overlap, int clusters,
    float fuzzifier, int iterations, int refresh_period, int threads, bool geometry,
    const std::string& motion, bool first_times, float tolerance_m, bool nearest, bool near_pairs,
    bool nearest_by_part) {
  Options options;
  options.adjacent = choiceOf("adjacent_pairs", adjacent_pairs,
                              {AdjacentPairs::kBeyondShared, AdjacentPairs::kSkip});
  options.predicates = toPredicates(predicates);
  options.overlap = overlap;
  options.clusters = clusters;
  options.fuzzifier = fuzzifier;
  options.iterations = iterations;
  options.refresh_period = refresh_period;
  options.threads = threads;
  options.geometry = geometry;
  options.motion = choiceOf("motion", motion, {Motion::kInstant, Motion::kSwept});
  options.first_times = first_times;
  options.tolerance_m = tolerance_m;
  options.nearest = nearest;
  options.near_pairs = near_pairs;
  options.nearest_by_part = nearest_by_part;
  if (nearest_by_part && !nearest) {
    throw std::invalid_argument("nearest_by_part is true, which needs nearest=True");
  }
  if (tolerance_m > 0 && options.motion == Motion::kSwept) {
    throw std::invalid_argument("tolerance_m is above 0, which motion 'swept' does not know");
  }
  return std::make_unique<PythonDetector>(toBackendChoice(backend),
                                          toSettings(device, memory_limit_mib), options);
}

}  // namespace

CudaSettings toSettings(std::int64_t device, std::int64_t memory_limit_mib) {
  const auto require = [](const char* name, std::int64_t value, std::int64_t low,
                          std::int64_t high) {
    if (value < low || value > high) {
      throw std::invalid_argument(std::string(name) + " is " + std::to_string(value) +
                                  ", must be in [" + std::to_string(low) + ", " +
                                  std::to_string(high) + "]");
    }
  };
  require("device", device, 0, kMaxDevice);
  require("memory_limit_mib", memory_limit_mib, 1, kMaxMemoryMib);
  CudaSettings settings;
  settings.device = static_cast<int>(device);
  settings.memory_limit_bytes = static_cast<std::uint64_t>(memory_limit_mib) << 20;
  return settings;
}

SteadyTime deadlineIn(std::optional<double> max_time_s) {
  // Longer times would overflow the clock [s].
  constexpr double kForEver = 1e8;
  if (!max_time_s) return SteadyTime::max();
  if (!(*max_time_s >= 0)) {
    throw std::invalid_argument("max_time_s is " + std::to_string(*max_time_s) +
                                ", must be >= 0, or None");
  }
  if (*max_time_s > kForEver) return SteadyTime::max();
  return std::chrono::steady_clock::now() + std::chrono::duration_cast<SteadyTime::duration>(
                                                std::chrono::duration<double>(*max_time_s));
}

PythonDetector::PythonDetector(BackendChoice choice, const CudaSettings& settings,
                               const Options& options)
    : PythonDetector(choice, settings, options,
                     options.tolerance_m > 0 ? std::make_shared<TilingCache>() : nullptr) {}

PythonDetector::PythonDetector(BackendChoice choice, const CudaSettings& settings,
                               const Options& options, const std::shared_ptr<TilingCache>& tilings)
    : PythonBackend({"Detector", "detector", "detect()"}, choice,
                    [&](WithoutCuda without_cuda, const auto& tell) {
                      requireValid(options);
                      CudaSettings warm = settings;
                      warm.warm_up = options;
                      return makeDetector(choice, without_cuda, warm, tell, tilings);
                    }),
      options_(options),
      tilings_(tilings) {}

PythonResult PythonDetector::detect(PythonScene* scene, std::optional<double> max_time_s) {
  requireUnused();
  warnIfNothingIsEnabled(scene->scene());
  Options options = options_;
  options.limits.deadline = deadlineIn(max_time_s);
  return run(
      scene,
      [&](Detector* detector) -> const DetectionResult& {
        makeTilings(scene->scene(), options);
        return detector->detect(scene->scene(), options);
      },
      [&](const DetectionResult& result) {
        return PythonResult{result, backend(), scene->scene(), options_};
      });
}

// A cache begins a tiling when it was asked for it several times, once per cycle. Bodies that get
// none for want of memory cost nothing but these calls.
void PythonDetector::makeTilings(const Scene& scene, const Options& options) {
  if (tilings_ == nullptr || backend() != "cpu" || options.limits.any()) return;
  std::set<BodyId> bodies;
  for (const auto& [a, b] : scene.enabledPairs()) {
    if (a != b) bodies.insert({a, b});
  }
  bool all_are_there = false;
  for (std::uint32_t i = 0; i < TilingCache::kSettledAfter && !all_are_there; ++i) {
    all_are_there = true;
    for (const BodyId id : bodies) {
      const Body& body = scene.body(id);
      if (!body.device_vertices && tilings_->of(body) == nullptr) all_are_there = false;
    }
  }
  if (!all_are_there) tilings_->wait();
}

// Arguments are in the order of the stub file.
void bindDetector(py::module& module) {
  using Self = PythonDetector;
  const Options options;
  const CudaSettings settings;
  const auto memory_limit_mib = static_cast<std::int64_t>(settings.memory_limit_bytes >> 20);
  py::class_<Self> detector(module, "Detector", kDetectorText);
  detector
      .def(py::init(&makePythonDetector), py::arg("backend") = toString(BackendChoice::kAuto),
#if PYBIND11_VERSION_MAJOR > 2 || PYBIND11_VERSION_MINOR >= 6
           py::kw_only(),
#endif
           py::arg("device") = settings.device, py::arg("memory_limit_mib") = memory_limit_mib,
           py::arg("adjacent_pairs") = toString(options.adjacent),
           py::arg("predicates") = toString(options.predicates),
           py::arg("overlap") = options.overlap, py::arg("clusters") = options.clusters,
           py::arg("fuzzifier") = options.fuzzifier, py::arg("iterations") = options.iterations,
           py::arg("refresh_period") = options.refresh_period, py::arg("threads") = options.threads,
           py::arg("geometry") = options.geometry, py::arg("motion") = toString(options.motion),
           py::arg("first_times") = options.first_times,
           py::arg("tolerance_m") = options.tolerance_m, py::arg("nearest") = options.nearest,
           py::arg("near_pairs") = options.near_pairs,
           py::arg("nearest_by_part") = options.nearest_by_part, kInitText)
      .def("detect", &Self::detect, py::arg("scene").none(false),
           py::arg("max_time_s") = py::none(), kDetectText);
  bindBackend(&detector, "Forgets what earlier cycles left; exact results never depend on it.");
}

}  // namespace deformable_contact_monitor
