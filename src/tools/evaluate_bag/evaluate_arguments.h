// The command line of evaluate_bag.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/bags/bag_files.h"
#include "tools/bags/bag_part.h"
#include "tools/common/scene_object.h"

namespace deformable_contact_monitor {

struct EvaluateArguments {
  BagFiles files;
  std::string expectations;  // yaml; empty: none
  std::string out = "evaluation";
  // What to run, each with each; empty: as the configuration says.
  std::vector<std::string> backends, predicates;
  std::vector<float> overlaps;
  std::optional<int> threads;       // of the cpu backend, in place of the configuration's
  bool pairs = false;               // also pairs.csv
  bool report = true;               // report.html
  SceneObject object;               // one that is not in the bags
  std::optional<BagPart> part;      // find the contacts of this part alone, and write `records`
  std::string records;              // file to write
  std::vector<std::string> joined;  // records of all parts, in place of detection; empty: none
};

// False if there is nothing to do, because --help or --version was asked for and is printed.
// Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, EvaluateArguments* arguments);

}  // namespace deformable_contact_monitor
