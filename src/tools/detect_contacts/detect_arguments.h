// Reads the command line of detect_contacts into one structure. --help describes every option.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/backend_choice.h"
#include "core/options.h"

namespace deformable_contact_monitor {

// The options, with their defaults. Lengths are in the meshes' unit.
struct DetectArguments {
  std::vector<std::string> meshes;  // swept: in twos, a body's earlier and later state
  bool self = false;                // also contacts of each body with itself
  std::string backend = "auto";     // one of backendNames()
  CudaSettings cuda;
  // The settings of the detector, as the core takes them (core/options.h).
  Options options;
  float margin_m = 0;
  std::string parts_file;           // empty: bodies have no parts
  std::optional<double> budget_ms;  // time limit of each detection
  int repeat = 1;
  // File names. Empty: not written; "-": standard output.
  std::string pairs_file, times_file, geometry_file, nearest_file, json_file;

  // Returns whether --tolerance-m or --budget-ms asks for states of bodies, not for all contacts.
  bool bounded() const { return options.tolerance_m > 0 || budget_ms; }
  // Returns whether contacts are sought over a time interval, not at one moment.
  bool swept() const { return options.motion == Motion::kSwept; }
};

// Parses the command line. Returns false if --help or --version was printed and nothing is left to
// do. Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, DetectArguments* arguments);

}  // namespace deformable_contact_monitor
