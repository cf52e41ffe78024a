// main() of the benchmarks on real data.
#pragma once

#include <cstdio>
#include <functional>
#include <string>

#include "test_data.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {

// Runs a benchmark like runTool(). Without test data it prints that and exits with 0.
inline int runBenchmark(const std::string& name, const std::function<int()>& body) {
  if (testDataIsThere()) return runTool(name, body);
  std::printf("SKIPPED: no test data at %s\n", testDataDir().c_str());
  return 0;
}

}  // namespace deformable_contact_monitor
