// Declares a fuzz target: a function that tries one input, and its name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Tries `size` bytes; any bytes must do no harm. Returns whether they got past the target's first
// check, which is the target's own matter: an input that is refused at once tests little. What an
// input must not do ends the process: an exception that escapes, a sanitizer's finding, or
// reportFinding().
using TryInput = bool (*)(const std::uint8_t* data, std::size_t size);

struct FuzzTarget {
  std::string name;  // also of its folder in corpus/
  TryInput try_input;
};

// All of this program: one under libFuzzer, all in fuzz_corpus_test. In no order.
std::vector<FuzzTarget>& fuzzTargets();

// Made once per target, at namespace scope.
struct FuzzTargetEntry {
  FuzzTargetEntry(const char* name, TryInput try_input) {
    fuzzTargets().push_back({name, try_input});
  }
};

// Ends the process, after `what` on standard error.
[[noreturn]] void reportFinding(const std::string& what);

inline void requireThat(bool holds, const char* what) {
  if (!holds) reportFinding(what);
}

}  // namespace deformable_contact_monitor
