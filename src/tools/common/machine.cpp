// Where something was measured.
#include "tools/common/machine.h"

#include <filesystem>
#include <fstream>
#include <system_error>
#include <thread>

namespace deformable_contact_monitor {
namespace {

// What follows `separator` on the first line that begins with `key`, without blanks and quotes
// around it.
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

}  // namespace deformable_contact_monitor
