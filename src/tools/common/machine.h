// Where something was measured.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// As Linux tells it; empty what it does not tell.
struct Machine {
  std::string system;      // "Debian GNU/Linux 12 (bookworm)"
  std::string cpu;         // model
  unsigned cores = 0;      // logical
  std::string gpu_driver;  // NVIDIA's
  std::vector<std::string> gpus;
};

Machine thisMachine();

// The same for a file, with the compiler.
nlohmann::json machineJson();

}  // namespace deformable_contact_monitor
