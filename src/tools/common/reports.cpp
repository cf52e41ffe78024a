// Makes text for JSON and CSV, describes the machine, and starts plot scripts.
#include "tools/common/reports.h"

#include <boost/process.hpp>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>

namespace deformable_contact_monitor {
namespace {

// Returns what follows `separator` on the first line that begins with `key`, without the blanks and
// quotes around it.
std::string valueOf(const std::filesystem::path& file, const std::string& key, char separator) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.find(separator);
    if (line.rfind(key, 0) != 0 || at == std::string::npos) continue;
    const std::size_t first = line.find_first_not_of(" \t\"", at + 1);
    const std::size_t last = line.find_last_not_of(" \t\"");
    return first == std::string::npos ? "" : line.substr(first, last - first + 1);
  }
  return "";
}

}  // namespace

std::string csvField(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string jsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

// Everything comes from files, so no NVIDIA library is needed.
Machine thisMachine() {
  Machine machine;
  machine.system = valueOf("/etc/os-release", "PRETTY_NAME", '=');
  machine.cpu = valueOf("/proc/cpuinfo", "model name", ':');
  machine.cores = std::thread::hardware_concurrency();
  const std::filesystem::path nvidia = "/proc/driver/nvidia";
  machine.gpu_driver = valueOf(nvidia / "version", "NVRM version", ':');
  std::error_code none;
  for (const auto& gpu : std::filesystem::directory_iterator(nvidia / "gpus", none)) {
    machine.gpus.push_back(valueOf(gpu.path() / "information", "Model", ':'));
  }
  return machine;
}

nlohmann::json machineJson() {
  const Machine machine = thisMachine();
  return {{"system", machine.system},         {"cpu", machine.cpu},   {"cores", machine.cores},
          {"gpu_driver", machine.gpu_driver}, {"gpus", machine.gpus}, {"compiler", __VERSION__}};
}

void runPlotScript(const std::string& name, const std::vector<std::string>& arguments,
                   const std::function<void(const std::string&)>& warn) {
  namespace bp = boost::process;
  const std::string script =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
  std::error_code error;
  const int code = bp::system(bp::exe = script, bp::args = arguments, error);
  if (error) {
    warn("no plots: " + script + ": " + error.message());
  } else if (code != 0) {
    warn("no plots; the line above says why");
  }
}

}  // namespace deformable_contact_monitor
