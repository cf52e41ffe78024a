// The command line of measure_trade.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/options.h"
#include "tools/bags/bag_files.h"
#include "tools/measure_trade/mesh_frames.h"
#include "tools/measure_trade/trade_grid.h"

namespace deformable_contact_monitor {

struct TradeArguments {
  MeshFrameFiles meshes;  // no states if there is a bag
  BagFiles recorded;      // no bags if there are meshes
  TradeGrid grid;
  Options base;           // what the grid does not vary
  int least_cycles = 20;  // measured for each setting, in whole passes through the frames
  int repeats = 3;        // times that the grid is gone through, the cycles shared out
  int warm_up = 5;        // cycles before them, in each repeat
  std::optional<double> budget_ms;
  std::string out_folder = "trade";
  std::string config_file;  // empty: not wanted
  bool force = false;       // replace config_file
  bool swept = false;       // what instant motion loses, in place of the grid
  int every = 10;           // swept: frames that are kept, each so-many-th
  bool bounds = false;      // tolerances and budgets, in place of the grid
  std::vector<float> tolerances_m = {0, 0.001F, 0.005F, 0.02F};
  std::vector<double> budgets_ms = {0, 5, 20};  // 0: none
  std::string command;                          // all of it, to be typed again
};

// False if there is nothing to do, because --help or --version was asked for and is printed.
// Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, TradeArguments* arguments);

}  // namespace deformable_contact_monitor
