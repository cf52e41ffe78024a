// The settings that measure_trade tries.
#pragma once

#include <string>
#include <vector>

#include "core/options.h"

namespace deformable_contact_monitor {

struct Setting {
  std::string backend;  // "cpu" or "cuda"
  Options options;
};

// Values to try. No list is empty.
struct TradeGrid {
  std::vector<std::string> backends = {"cpu"};
  std::vector<float> overlaps = {0, 0.25F, 0.5F, 0.75F, 1};
  std::vector<Predicates> predicates = {Predicates::kExact, Predicates::kConservative,
                                        Predicates::kFast};
  std::vector<int> clusters = {0, 16, 64, 256, 1024};
  std::vector<float> fuzzifiers = {2, 1.5F, 3};
  std::vector<int> iterations = {1, 0, 3};
  std::vector<int> refresh_periods = {1, 4, 16};
};

// For each backend: overlaps x predicates x clusters in full, with the first of the other lists;
// then the rest of those lists, one value at a time, at the largest overlap, the strictest
// predicates and the first clusters. What is not in the grid is as in `base`. None comes twice.
std::vector<Setting> settingsOf(const TradeGrid& grid, const Options& base);

// "cpu, exact, overlap 0.5, clusters auto", and what of the rest differs from the defaults.
std::string describe(const Setting& setting);

// The shortest text that reads back as the same number.
std::string numberText(double value);
std::string numberText(float value);

}  // namespace deformable_contact_monitor
