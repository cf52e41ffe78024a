// Suggests a known name for one that was mistyped.
#include "robot/nearest_name.h"

#include <algorithm>
#include <numeric>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kLongest = 100;  // the time is the product of both lengths

// Returns the Levenshtein distance of two names, computed row by row.
std::size_t editCount(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0U);
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

}  // namespace

// Suggests a known name only if at most a third of the longer name's letters, and one more, must be
// edited. The first of several names that are equally near is suggested.
std::string nearestNameHint(const std::string& name, const std::vector<std::string>& known) {
  if (name.size() > kLongest) return "";
  const std::string* nearest = nullptr;
  std::size_t fewest = kLongest;
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongest) continue;
    const std::size_t edits = editCount(name, candidate);
    const std::size_t longer = std::max(name.size(), candidate.size());
    if (edits >= std::min(fewest, longer) || edits > 1 + longer / 3) continue;
    fewest = edits;
    nearest = &candidate;
  }
  return nearest == nullptr ? "" : " (did you mean '" + *nearest + "'?)";
}

}  // namespace deformable_contact_monitor
