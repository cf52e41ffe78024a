// The rules of a robot's SRDF: which of its links may touch each other.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Holds the elements that MoveIt reads for its collision checks. The order of a pair's links does
// not matter. A pair in `disabled` has precedence over one in `enabled`, which has precedence over
// `disabled_links`.
struct Srdf {
  // A pair of links with a rule of its own.
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

// readSrdf() rejects a document that is larger than this or has more rules.
constexpr std::size_t kMaxSrdfBytes = std::size_t{16} << 20U;
constexpr std::size_t kMostSrdfRules = 100000;

// Reads an SRDF document. Other elements are ignored, also where they are malformed. Throws
// std::invalid_argument, "SRDF, line N: <what>".
Srdf readSrdf(const std::string& xml);

// Reads an SRDF file. Every error message begins with `path`. Throws std::runtime_error if it is
// not a regular file or cannot be read, and the errors of readSrdf().
Srdf readSrdfFile(const std::string& path);

// Returns the rules with `prefix` before each name that makes the name of one of `links`. Other
// names stay as they are: they may be those of rigid objects.
Srdf prefixed(const Srdf& srdf, const std::string& prefix, const std::set<std::string>& links);

// Returns one line for each of these facts: the SRDF is for another robot than `robot` (empty: not
// known), and it names links that are not among `links` (the first of them are listed).
std::vector<std::string> srdfWarnings(const Srdf& srdf, const std::string& robot,
                                      const std::set<std::string>& links);

}  // namespace deformable_contact_monitor
