// detect_contacts: finds every contact between the triangles of mesh files. Needs no ROS. Reads the
// meshes into a scene, detects once or repeatedly, and writes the reports that were asked for.
//
// Exit code: 0, or 2 with one line on standard error. Reports are made from the last detection,
// times from all of them. Outputs are opened before the detection, so that a file that cannot be
// written is found early.
#include <chrono>
#include <csignal>
#include <cstdio>
#include <list>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/mesh_file.h"
#include "tools/common/backend_choice.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/run_tool.h"
#include "tools/detect_contacts/contact_report.h"
#include "tools/detect_contacts/detect_arguments.h"
#include "tools/detect_contacts/nearest_report.h"
#include "tools/detect_contacts/parts_file.h"

namespace deformable_contact_monitor {
namespace {

// Prints a note to standard error.
void note(const std::string& what) {
  std::fprintf(stderr, "detect_contacts: note: %s\n", what.c_str());
}

// Reads a mesh file. Prints a note for each thing that may not be meant as it was read.
TriangleMesh readNotedMeshFile(const std::string& file, MeshFileReport* report) {
  TriangleMesh mesh = readMeshFile(file, report);
  for (const std::string& of_file : report->notes) note(file + ": " + of_file);
  return mesh;
}

// Returns the vertices of the earlier file. Both states must have the same faces, because vertex i
// moves from its place in the first file to that in the second. The triangles of polygons are those
// of the later file. Throws std::runtime_error, naming the later file, if the faces differ.
std::vector<float> earlierVertices(const std::string& earlier_file, const std::string& later_file,
                                   const TriangleMesh& later, const MeshFileReport& later_report) {
  MeshFileReport report;
  TriangleMesh earlier = readNotedMeshFile(earlier_file, &report);
  if (earlier.vertexCount() != later.vertexCount() || report.fans != later_report.fans) {
    throw std::runtime_error(later_file + ": is no later state of " + earlier_file +
                             ", for its triangles are others");
  }
  return std::move(earlier.vertices);
}

// Makes a body of each file, or of each two files with --swept. Enables each pair of two bodies,
// and with --self each body with itself. The later file gives a body its name and its present mesh.
Scene readScene(const DetectArguments& arguments, Progress* progress) {
  Scene scene;
  // With --swept, a body has two files: the earlier state, then the later one.
  const std::size_t states = arguments.swept() ? 2 : 1;
  for (std::size_t first = 0; first < arguments.meshes.size(); first += states) {
    const std::string& file = arguments.meshes[first + states - 1];
    progress->set("reading " + file);
    MeshFileReport report;
    const BodyId body = scene.addBody(file, readNotedMeshFile(file, &report));
    if (arguments.swept()) {
      scene.setEarlier(
          body, RigidTransform(),
          earlierVertices(arguments.meshes[first], file, scene.body(body).mesh, report));
    }
    scene.setMargin(body, arguments.margin_m);
    for (BodyId other = 0; other < body; ++other) scene.setPairEnabled(other, body, true);
    scene.setPairEnabled(body, body, arguments.self);
  }
  if (!arguments.parts_file.empty()) readParts(arguments.parts_file, &scene);
  return scene;
}

// Detects `repeat` times, adds the times, and returns the last result, which belongs to the
// detector. The deadline is set anew for each detection.
const DetectionResult& detect(const DetectArguments& arguments, const Scene& scene,
                              Detector* detector, DetectionTimes* times, Progress* progress) {
  const std::string of_all = " of " + std::to_string(arguments.repeat);
  const DetectionResult* result = nullptr;
  for (int cycle = 1; cycle <= arguments.repeat; ++cycle) {
    progress->set("detecting, cycle " + std::to_string(cycle) + of_all);
    Options options = arguments.options;
    if (arguments.budget_ms) {
      options.limits.deadline =
          std::chrono::steady_clock::now() + fromSeconds(*arguments.budget_ms / 1e3);
    }
    result = &detector->detect(scene, options);
    times->add(*result);
  }
  return *result;
}

// One requested report, its text, and the file that it goes to.
struct Report {
  explicit Report(const std::string& path) : to_output(path == "-"), file(path) {}

  const bool to_output;
  OutputFile file;
  std::string text;
};

// Writes files first and standard output last, so that the files are complete even if the reader of
// standard output ends. The summary goes to standard output if no report does.
void writeReports(const std::string& summary, std::list<Report>* reports) {
  Report* last = nullptr;
  for (Report& report : *reports) {
    if (report.to_output) {
      last = &report;
    } else {
      report.file.write(report.text);
    }
  }
  if (last != nullptr) {
    last->file.write(last->text);
  } else {
    OutputFile("-").write(summary);
  }
}

// Prints notes about what the lists alone do not show: contacts that are missing, input that could
// not be used, and distances that are not known.
void warn(const DetectArguments& arguments, const DetectionResult& result,
          const NearestBodies& bodies) {
  if (result.left_out > 0) {
    note(std::to_string(result.left_out) +
         " contacts more were found than --memory-limit has room for");
  }
  if (result.cut_off) {
    note("the result is not complete, not all pairs were looked at (" + result.cut_off_because +
         ")");
  }
  if (!result.distances.empty() && arguments.options.tolerance_m > 0) {
    note("with --tolerance-m the list has the contacts seen on the way, not all");
  }
  if (arguments.meshes.size() == (arguments.swept() ? 2 : 1) && !arguments.self) {
    note("one body and no --self, so there is nothing to test");
  }
  if (result.counters.rejected > 0) {
    note("the result is not complete, " + std::to_string(result.counters.rejected) +
         " triangles have a NaN or infinite vertex");
  }
  for (const std::string& what : nearestNotes(bodies, arguments.options.tolerance_m)) note(what);
}

// Throws if the backend would silently ignore --margin. FCL lists only triangles that intersect,
// but it knows distances of bodies.
void requireMargins(const DetectArguments& arguments, const Detector& detector) {
  if (supportsMargins(detector) || arguments.margin_m == 0) return;
  if (arguments.options.near_pairs) {
    throw std::invalid_argument("--near-pairs: backend " + detector.backend() +
                                " lists no near pairs; use --backend auto");
  }
  if (!arguments.options.nearest) {
    throw std::invalid_argument("--margin: backend " + detector.backend() +
                                " has no margins; use --backend auto");
  }
}

// Does everything after parsing. A tolerance or a budget needs tilings, which are built before the
// first detection, so that all detections use them. The progress line is removed before results are
// written to the terminal. Throws std::exception, whose text is one line.
void run(const DetectArguments& arguments) {
  // Detection with bounds uses tilings: groups of triangles with boxes around them.
  const auto tilings = arguments.bounded() ? std::make_shared<TilingCache>() : nullptr;
  CudaSettings cuda = arguments.cuda;
  cuda.warm_up = arguments.options;
  const std::unique_ptr<Detector> detector = makeDetector(
      arguments.backend, WithoutCuda::kFallBack, cuda,
      [](const std::string& why) {
        std::fprintf(stderr, "detect_contacts: warning: %s\n", why.c_str());
      },
      tilings);
  requireMargins(arguments, *detector);
  std::list<Report> reports;
  // Opens a report's file if it was asked for. The list never moves its elements, so pointers stay
  // valid.
  const auto open = [&reports](const std::string& path) {
    return path.empty() ? nullptr : &reports.emplace_back(path);
  };
  DetectionTimes times;
  const DetectionResult* last = nullptr;  // the detector's
  NearestBodies nearest_bodies;
  std::string text;
  {
    Progress progress("starting");
    const Scene scene = readScene(arguments, &progress);
    if (tilings != nullptr) {
      progress.set("grouping triangles");
      makeTilings(scene, tilings.get());
    }
    Report* const pairs = open(arguments.pairs_file);
    Report* const times_of_pairs = open(arguments.times_file);
    Report* const geometry = open(arguments.geometry_file);
    Report* const nearest = open(arguments.nearest_file);
    Report* const json = open(arguments.json_file);
    // The result belongs to the detector, which outlives the reports.
    last = &detect(arguments, scene, detector.get(), &times, &progress);
    progress.set("writing");
    const std::string backend = detector->backend();
    if (nearest != nullptr) {
      nearest_bodies = nearestBodies(scene, *last, arguments.options.tolerance_m);
      nearest->text = nearestLines(nearest_bodies);
    }
    if (pairs != nullptr) pairs->text = pairLines(last->contacts);
    if (times_of_pairs != nullptr) times_of_pairs->text = timeLines(*last);
    if (geometry != nullptr) geometry->text = geometryLines(*last);
    if (json != nullptr) json->text = jsonReport(arguments, scene, backend, *last, times);
    text = summary(arguments, scene, backend, *last, times);
  }
  // Notes come before the results, so that the results are the last lines on a terminal.
  warn(arguments, *last, nearest_bodies);
  writeReports(text, &reports);
}

}  // namespace
}  // namespace deformable_contact_monitor

// The summary or a report may be piped into a program that stops reading early. That is no error.
int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  // A reader of standard output that ends early, such as `head`, then causes an error code and not
  // the end of the process.
  std::signal(SIGPIPE, SIG_IGN);
  return dcm::runTool("detect_contacts", [argc, argv] {
    dcm::DetectArguments arguments;
    try {
      if (dcm::parseArguments(argc, argv, &arguments)) dcm::run(arguments);
    } catch (const std::system_error& error) {
      if (error.code() != std::errc::broken_pipe) throw;  // else the reader has seen enough
    }
    return 0;
  });
}
