#include "fuzz_target.h"

#include <cstdio>
#include <cstdlib>

namespace deformable_contact_monitor {

std::vector<FuzzTarget>& fuzzTargets() {
  static std::vector<FuzzTarget> targets;
  return targets;
}

void reportFinding(const std::string& what) {
  std::fprintf(stderr, "FINDING: %s\n", what.c_str());
  std::abort();
}

}  // namespace deformable_contact_monitor
