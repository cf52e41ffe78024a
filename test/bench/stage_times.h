// Where a cycle's time goes, for the benchmarks.
#pragma once

#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "core/detector.h"
#include "tools/common/sample_statistics.h"

namespace deformable_contact_monitor {

// Collects the stage times of several cycles of one detector.
struct StageTimes {
  std::vector<std::string> names;  // of the last cycle, in its order
  std::map<std::string, std::vector<double>> ms;

  void add(const DetectionResult& result) {
    names.clear();
    for (const auto& [name, stage_ms] : result.stages_ms) {
      names.push_back(name);
      ms[name].push_back(stage_ms);
    }
  }

  // A row: medians and p95 [us].
  void print(const std::string& scene) const {
    std::printf("| %s |", scene.c_str());
    for (const std::string& name : names) {
      std::printf(" %s %.1f (%.1f) |", name.c_str(), 1e3 * median(ms.at(name)),
                  1e3 * percentile(ms.at(name), 0.95));
    }
    std::printf("\n");
    std::fflush(stdout);
  }
};

}  // namespace deformable_contact_monitor
