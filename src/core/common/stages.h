// The stages of a detection cycle in their order, and how long they take.
#pragma once

#include <array>
#include <cstddef>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {

enum class Stage {
  kTransform,
  kCluster,
  kAssign,
  kSort,
  kSweep,
  kOversized,
  kNarrowPhase,
  kNearest,
  kOutput
};

constexpr std::size_t kStageCount = 9;

constexpr std::array<const char*, kStageCount> kStageNames = {
    "transform", "cluster",      "assign",  "sort",  "sweep",
    "oversized", "narrow_phase", "nearest", "output"};

// The time that each stage of one cycle took [ms].
class StageTimes {
 public:
  void add(Stage stage, double ms) { ms_[static_cast<std::size_t>(stage)] += ms; }

  // Adds all times of another cycle, multiplied by `share`.
  void add(const StageTimes& other, double share) {
    for (std::size_t s = 0; s < kStageCount; ++s) ms_[s] += share * other.ms_[s];
  }

  double of(Stage stage) const { return ms_[static_cast<std::size_t>(stage)]; }

  double totalMs() const { return std::accumulate(ms_.begin(), ms_.end(), 0.0); }

  // Returns the time of each stage by its name [ms], in the order of stages. kNearest is there only
  // if it ran.
  std::vector<std::pair<std::string, double>> byName() const {
    std::vector<std::pair<std::string, double>> times;
    times.reserve(kStageCount);
    for (std::size_t s = 0; s < kStageCount; ++s) {
      const bool has_run = s != static_cast<std::size_t>(Stage::kNearest) || ms_[s] > 0;
      if (has_run) times.emplace_back(kStageNames[s], ms_[s]);
    }
    return times;
  }

 private:
  std::array<double, kStageCount> ms_{};
};

}  // namespace deformable_contact_monitor
