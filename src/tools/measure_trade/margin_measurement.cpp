#include "tools/measure_trade/margin_measurement.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/steady_time.h"
#include "tools/measure_trade/trade_grid.h"

namespace deformable_contact_monitor {
namespace {

// Returns the least distance of each two bodies, from the nearest pairs or from the list.
std::vector<std::pair<BodyPair, float>> distancesOf(const DetectionResult& result, MarginUse use) {
  std::map<BodyPair, float> least;
  if (use == MarginUse::kNearest) {
    for (const NearestPair& pair : result.nearest) {
      least[{pair.pair.body_a, pair.pair.body_b}] = pair.distance_m;
    }
  } else if (use == MarginUse::kNearPairs) {
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      const TrianglePair& pair = result.contacts[i];
      if (pair.body_a == pair.body_b) continue;
      const float distance_m = result.separationM(i);
      const auto [found, is_new] = least.emplace(BodyPair{pair.body_a, pair.body_b}, distance_m);
      found->second = std::min(found->second, distance_m);
    }
  }
  return {least.begin(), least.end()};
}

}  // namespace

const char* toString(MarginUse use) {
  constexpr const char* kNames[] = {"touching", "nearest", "near_pairs"};
  return kNames[static_cast<std::size_t>(use)];
}

std::string describe(const MarginSetting& setting) {
  std::string text = setting.backend + ", " + toString(setting.use);
  if (setting.use != MarginUse::kIgnored) {
    text += ", margin " + numberText(setting.margin_m) + " m";
  }
  return text;
}

FrameDistances measureMargin(FrameSource* frames, const CycleCounts& cycles, const Options& options,
                             Detector* detector, MarginMeasurement* sum) {
  Options chosen = options;
  chosen.nearest = sum->setting.use == MarginUse::kNearest;
  chosen.near_pairs = sum->setting.use == MarginUse::kNearPairs;
  frames->setMargin(sum->setting.use == MarginUse::kIgnored ? 0 : sum->setting.margin_m);
  FrameDistances distances;
  forEachCycle(frames, cycles, [&](std::size_t frame, bool is_counted) {
    if (frame == 0) distances.clear();
    const SteadyTime start = std::chrono::steady_clock::now();
    const DetectionResult& result = detector->detect(frames->scene(), chosen);
    const double ms = 1e3 * toSeconds(std::chrono::steady_clock::now() - start);
    if (result.cut_off || result.left_out > 0) {
      throw std::runtime_error(
          "not all pairs were found, so there is nothing to compare with: " +
          (result.cut_off ? result.cut_off_because : "memory_limit_mib; set smaller --margins-m"));
    }
    distances.push_back(distancesOf(result, sum->setting.use));
    if (!is_counted) return;
    if (sum->ms.size() == frame) sum->rejected += result.counters.rejected;  // the first pass
    sum->ms.push_back(ms);
    sum->triangle_pairs += result.contacts.size() + result.left_out;
    sum->body_pairs += sum->setting.use == MarginUse::kIgnored ? result.touchingBodies().size()
                                                               : distances.back().size();
  });
  return distances;
}

void compareDistances(const FrameDistances& expected, const FrameDistances& found,
                      MarginMeasurement* sum) {
  constexpr double kRounding = 1e-6;
  const auto isSame = [](const std::pair<BodyPair, float>& a, const std::pair<BodyPair, float>& b) {
    return a.first == b.first && std::abs(double{a.second} - b.second) <= kRounding * a.second;
  };
  for (std::size_t i = 0; i < std::min(expected.size(), found.size()); ++i) {
    if (std::equal(expected[i].begin(), expected[i].end(), found[i].begin(), found[i].end(),
                   isSame)) {
      continue;
    }
    sum->broken = describe(sum->setting) + " has other distances than the list of near pairs, in " +
                  "frame " + std::to_string(i + 1);
    return;
  }
}

}  // namespace deformable_contact_monitor
