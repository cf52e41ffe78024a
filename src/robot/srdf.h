// Which links of a robot may touch each other, as its SRDF says.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// What MoveIt reads for its collision checks. The order of a pair's links does not matter. A pair
// in `disabled` beats one in `enabled`, which beats `disabled_links`.
struct Srdf {
  struct Pair {
    std::string a, b;    // links
    std::string reason;  // "Adjacent", "Never", ...; may be empty
  };

  std::string robot;                     // its name
  std::vector<Pair> disabled;            // disable_collisions: may touch
  std::vector<Pair> enabled;             // enable_collisions
  std::set<std::string> disabled_links;  // disable_default_collisions: may touch every link

  bool operator==(const Srdf& other) const;
};

// So large a document, and so many pairs and links in it, are read at most.
constexpr std::size_t kMaxSrdfBytes = std::size_t{16} << 20U;
constexpr std::size_t kMostSrdfRules = 100000;

// Other elements, at whatever place, are left out and cost nothing if they are malformed. Throws
// std::invalid_argument, "SRDF, line N: <what>".
Srdf readSrdf(const std::string& xml);

// Of a file, whose name, `path`, begins every message. Throws std::runtime_error if it is not a
// regular file or cannot be read, and as readSrdf().
Srdf readSrdfFile(const std::string& path);

// One line for each of: it is of another robot than `robot` (empty: nobody knows), and it names
// links that are not among `links`, the first of them listed.
std::vector<std::string> srdfWarnings(const Srdf& srdf, const std::string& robot,
                                      const std::set<std::string>& links);

}  // namespace deformable_contact_monitor
