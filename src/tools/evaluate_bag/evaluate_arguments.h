// The command line of evaluate_bag.
//
// Options that are not given keep the configuration's values.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/common/bag_files.h"
#include "tools/simulation/scene_object.h"

namespace deformable_contact_monitor {

// The options of evaluate_bag.
struct EvaluateArguments {
  BagFiles files;
  std::string expectations;  // yaml file; empty: none
  std::string out = "evaluation";
  // Each backend runs with each predicate and overlap. An empty list: as the configuration says.
  std::vector<std::string> backends, predicates;
  std::vector<float> overlaps;
  std::optional<int> threads;  // of the cpu backend; nothing: as the configuration says
  std::string geometry;        // one of kGeometryKinds; empty: as the configuration says
  bool pairs = false;          // also write pairs.csv
  bool report = true;          // draw report.html
  SceneObject object;          // an object that is not in the bags
};

// Returns false if --help or --version was asked for and is printed, so nothing is left to do.
// Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, EvaluateArguments* arguments);

}  // namespace deformable_contact_monitor
