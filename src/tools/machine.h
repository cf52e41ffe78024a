// Where something was measured.
#pragma once

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

}  // namespace deformable_contact_monitor
