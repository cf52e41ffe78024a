// The settings that measure_trade tries.
//
// The grid has a full part, which shows how the most important options act together, and a part in
// which the others vary one at a time.
#pragma once

#include <string>
#include <vector>

#include "core/options.h"

namespace deformable_contact_monitor {

// One point of the grid.
struct Setting {
  std::string backend;  // "cpu" or "cuda"
  Options options;
};

// The values to try. No list is empty.
struct TradeGrid {
  std::vector<std::string> backends = {"cpu"};
  std::vector<float> overlaps = {0, 0.25F, 0.5F, 0.75F, 1};
  std::vector<Predicates> predicates = {Predicates::kExact, Predicates::kConservative};
  std::vector<int> clusters = {0, 16, 64, 256, 1024};
  std::vector<float> fuzzifiers = {2, 1.5F, 3};
  std::vector<int> iterations = {1, 0, 3};
  std::vector<int> refresh_periods = {1, 4, 16};
};

// Returns the settings to measure, for each backend:
// - all combinations of overlaps, predicates and clusters, with the first value of the other lists;
// - then the other values of those lists, one at a time, with the largest overlap, the strictest
//   predicates and the first number of clusters.
// Everything else is as in `base`. No setting comes twice.
std::vector<Setting> settingsOf(const TradeGrid& grid, const Options& base);

// Returns whether the node runs with these options if none of them is set.
bool isDefault(const Setting& setting);

// Returns the setting in words: "cpu, exact, overlap 0.5, clusters auto", and what else differs
// from the defaults.
std::string describe(const Setting& setting);

// Returns the shortest text that reads back as the same number.
std::string numberText(double value);
std::string numberText(float value);

}  // namespace deformable_contact_monitor
