// The command line of measure_trade.
//
// Five measurements share the command line: the grid, --swept, --tolerance, --margins and --states.
// Options that belong to another measurement are errors.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/options.h"
#include "tools/common/bag_files.h"
#include "tools/measure_trade/frame_source.h"
#include "tools/measure_trade/trade_grid.h"

namespace deformable_contact_monitor {

// The options of measure_trade.
struct TradeArguments {
  MeshFrameFiles meshes;  // empty if bags are given
  BagFiles recorded;      // empty if meshes are given
  TradeGrid grid;
  Options base;           // options that the grid does not vary
  int least_cycles = 20;  // cycles of each setting, rounded up to whole passes through the frames
  int repeats = 3;        // the cycles are divided among so many passes through the grid
  int warm_up = 5;        // cycles before the measured ones, in each repeat
  int most_frames = 100;  // of bags, spread evenly over them; 0: all
  std::optional<double> budget_ms;
  bool writes_budget = false;  // config_file gets budget_ms
  std::string out_folder = "trade";
  std::string config_file;  // parameters to write; empty: none
  bool force = false;       // replace an existing config_file
  bool swept = false;       // measure what instant motion loses instead of the grid
  int every = 10;           // swept: every n-th frame is kept
  bool bounds = false;      // measure tolerances and budgets instead of the grid
  std::vector<float> tolerances_m = {0, 0.001F, 0.005F, 0.02F};
  std::vector<double> budgets_ms = {0, 5, 20};  // 0: none
  bool margins = false;                         // measure what margins cost instead of the grid
  std::vector<float> margins_m = {0.02F, 0.1F};
  int states = 0;  // measure so many states of the robot instead of the grid; 0: measure the grid
  std::string urdf;
  float states_margin_m = 0.1F;
  std::string command;  // the whole command, to be typed again
};

// Returns false if --help or --version was asked for and is printed, so nothing is left to do.
// Throws std::invalid_argument, one line, on bad usage.
bool parseArguments(int argc, char** argv, TradeArguments* arguments);

}  // namespace deformable_contact_monitor
