// detect_contacts: every contact between the triangles of mesh files. Needs no ROS.
#include <csignal>
#include <cstdio>
#include <memory>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "core/mesh_files/mesh_file.h"
#include "tools/common/backend_choice.h"
#include "tools/common/output_file.h"
#include "tools/common/progress.h"
#include "tools/common/run_tool.h"
#include "tools/detect_contacts/contact_report.h"
#include "tools/detect_contacts/detect_arguments.h"

namespace deformable_contact_monitor {
namespace {

Scene readScene(const DetectArguments& arguments, Progress* progress) {
  Scene scene;
  for (const std::string& file : arguments.meshes) {
    progress->set("reading " + file);
    const BodyId body = scene.addBody(file, readMeshFile(file));
    scene.setMargin(body, arguments.margin_m);
    for (BodyId other = 0; other < body; ++other) scene.setPairEnabled(other, body, true);
    scene.setPairEnabled(body, body, arguments.self);
  }
  return scene;
}

const DetectionResult& detect(const DetectArguments& arguments, const Scene& scene,
                              Detector* detector, DetectionTimes* times, Progress* progress) {
  const std::string of_all = " of " + std::to_string(arguments.repeat);
  const DetectionResult* result = nullptr;
  for (int cycle = 1; cycle <= arguments.repeat; ++cycle) {
    progress->set("detecting, cycle " + std::to_string(cycle) + of_all);
    result = &detector->detect(scene, arguments.options);
    times->add(*result);
  }
  return *result;
}

// What goes to standard output comes last, so that the files are whole if its reader goes away.
void writeReports(const DetectArguments& arguments, const std::string& pairs,
                  const std::string& json, const std::string& summary, OutputFile* pairs_file,
                  OutputFile* json_file) {
  const bool pairs_last = arguments.pairs_file == "-";
  if (pairs_file != nullptr && !pairs_last) pairs_file->write(pairs);
  if (json_file != nullptr) json_file->write(json);
  if (pairs_file != nullptr && pairs_last) pairs_file->write(pairs);
  if (!pairs_last && arguments.json_file != "-") OutputFile("-").write(summary);
}

// What a user who reads the pairs alone would not see.
void warn(const DetectArguments& arguments, const DetectionResult& result) {
  if (result.left_out > 0) {
    std::fprintf(
        stderr,
        "detect_contacts: note: %llu contacts more were found than --memory-limit has room "
        "for\n",
        static_cast<unsigned long long>(result.left_out));
  }
  if (result.cut_off) {
    std::fprintf(stderr,
                 "detect_contacts: note: the result is not complete, not all pairs were looked at "
                 "(%s)\n",
                 result.cut_off_because.c_str());
  }
  if (arguments.meshes.size() == 1 && !arguments.self) {
    std::fputs("detect_contacts: note: one mesh and no --self, so there is nothing to test\n",
               stderr);
  }
  if (result.counters.rejected > 0) {
    std::fprintf(stderr,
                 "detect_contacts: note: the result is not complete, %llu triangles have a NaN or "
                 "infinite vertex\n",
                 static_cast<unsigned long long>(result.counters.rejected));
  }
}

void run(const DetectArguments& arguments) {
  const std::unique_ptr<Detector> detector = makeDetector(
      arguments.backend, WithoutCuda::kFallBack, arguments.cuda, [](const std::string& why) {
        std::fprintf(stderr, "detect_contacts: warning: %s\n", why.c_str());
      });
  if (arguments.margin_m != 0 && !supportsMargins(*detector)) {
    throw std::invalid_argument("--margin: backend " + detector->backend() +
                                " has no margins; use --backend auto");
  }
  std::optional<OutputFile> pairs_file, json_file;
  DetectionTimes times;
  const DetectionResult* last = nullptr;  // the detector's
  std::string pairs, json, text;
  {
    Progress progress("starting");
    const Scene scene = readScene(arguments, &progress);
    if (!arguments.pairs_file.empty()) pairs_file.emplace(arguments.pairs_file);
    if (!arguments.json_file.empty()) json_file.emplace(arguments.json_file);
    last = &detect(arguments, scene, detector.get(), &times, &progress);
    progress.set("writing");
    const std::string backend = detector->backend();
    if (pairs_file) pairs = pairLines(last->contacts);
    if (json_file) json = jsonReport(arguments, scene, backend, *last, times);
    text = summary(scene, backend, *last, times);
  }
  warn(arguments, *last);
  writeReports(arguments, pairs, json, text, pairs_file ? &*pairs_file : nullptr,
               json_file ? &*json_file : nullptr);
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
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
