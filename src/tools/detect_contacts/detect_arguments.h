// The command line of detect_contacts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/options.h"
#include "cuda/cuda_detector.h"

namespace deformable_contact_monitor {

struct DetectArguments {
  std::vector<std::string> meshes;  // swept: in twos, a body's earlier and later state
  bool self = false;                // also contacts of each body with itself
  std::string backend = "auto";     // one of backendNames()
  CudaSettings cuda;
  Options options;
  float margin_m = 0;
  std::optional<double> budget_ms;  // of each detection
  int repeat = 1;
  // Empty: not wanted; "-": standard output.
  std::string pairs_file, times_file, geometry_file, json_file;

  // Whether less than all contacts is asked for: then states of bodies are.
  bool bounded() const { return options.tolerance_m > 0 || budget_ms; }
  bool swept() const { return options.motion == Motion::kSwept; }
};

// False if there is nothing to do, because --help or --version was asked for and is printed.
// Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, DetectArguments* arguments);

}  // namespace deformable_contact_monitor
