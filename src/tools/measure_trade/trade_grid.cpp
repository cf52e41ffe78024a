// The settings that measure_trade tries.
#include "tools/measure_trade/trade_grid.h"

#include <algorithm>
#include <limits>
#include <locale>
#include <sstream>
#include <tuple>

namespace deformable_contact_monitor {
namespace {

// Returns true if two settings are equal in everything that the grid varies.
bool same(const Setting& a, const Setting& b) {
  const auto values = [](const Setting& s) {
    const Options& o = s.options;
    return std::tie(s.backend, o.overlap, o.predicates, o.clusters, o.fuzzifier, o.iterations,
                    o.refresh_period);
  };
  return values(a) == values(b);
}

// Returns the shortest text that reads back as this number: a number that was given with few digits
// appears with those again. Tries more digits, from those that every decimal survives.
template <class Number>
std::string shortest(Number value) {
  // Tries more digits until the text reads back as the same number.
  int digits = std::numeric_limits<Number>::digits10;
  while (true) {
    std::stringstream text;
    text.imbue(std::locale::classic());
    text.precision(digits);
    text << value;
    std::string written = text.str();
    Number read = 0;
    text >> read;
    if (read == value || digits == std::numeric_limits<Number>::max_digits10) return written;
    ++digits;
  }
}

}  // namespace

std::string numberText(double value) { return shortest(value); }
std::string numberText(float value) { return shortest(value); }

// The order matters: of equal settings the first one stays, and reports list them in this order.
std::vector<Setting> settingsOf(const TradeGrid& grid, const Options& base) {
  std::vector<Setting> settings;
  const auto add = [&settings](const Setting& setting) {
    const auto is_same = [&setting](const Setting& other) { return same(setting, other); };
    if (std::none_of(settings.begin(), settings.end(), is_same)) settings.push_back(setting);
  };
  for (const std::string& backend : grid.backends) {
    Setting setting{backend, base};
    Options& options = setting.options;
    options.fuzzifier = grid.fuzzifiers.front();
    options.iterations = grid.iterations.front();
    options.refresh_period = grid.refresh_periods.front();
    for (const Predicates predicates : grid.predicates) {
      for (const float overlap : grid.overlaps) {
        for (const int clusters : grid.clusters) {
          options.predicates = predicates;
          options.overlap = overlap;
          options.clusters = clusters;
          add(setting);
        }
      }
    }
    options.overlap = *std::max_element(grid.overlaps.begin(), grid.overlaps.end());
    options.predicates = *std::min_element(grid.predicates.begin(), grid.predicates.end());
    options.clusters = grid.clusters.front();
    // Adds a setting for each value of an option, which then has the first value again.
    const auto vary = [&](auto Options::*option, const auto& values) {
      for (const auto value : values) {
        options.*option = value;
        add(setting);
      }
      options.*option = values.front();
    };
    vary(&Options::fuzzifier, grid.fuzzifiers);
    vary(&Options::iterations, grid.iterations);
    vary(&Options::refresh_period, grid.refresh_periods);
  }
  return settings;
}

bool isDefault(const Setting& setting) { return same(setting, {setting.backend, Options()}); }

std::string describe(const Setting& setting) {
  const Options& options = setting.options;
  const Options usual;
  std::string text = setting.backend + ", " + toString(options.predicates) + ", overlap " +
                     numberText(options.overlap) + ", clusters " +
                     (options.clusters == 0 ? "auto" : std::to_string(options.clusters));
  if (options.fuzzifier != usual.fuzzifier) text += ", fuzzifier " + numberText(options.fuzzifier);
  if (options.iterations != usual.iterations) {
    text += ", iterations " + std::to_string(options.iterations);
  }
  if (options.refresh_period != usual.refresh_period) {
    text += ", refresh period " + std::to_string(options.refresh_period);
  }
  return text;
}

}  // namespace deformable_contact_monitor
