// Decides whether rejected triangles leave it open how a pair stands.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// The rejected triangles of a body. `where` is put in front of their numbers.
struct Rejects {
  std::uint64_t all = 0;
  const std::vector<std::uint64_t>& by_part;  // empty: none, or the body has no parts
  const char* where = "";
};

// Returns why NONE and NEAR must not be claimed of one side of a pair (is_a: that of pair.a); empty
// if the rules tolerate its rejects. For a part, its own triangles count. For an object, the
// triangles outside its named parts count, because parts have states of their own; if there are
// none, or they are ALLOWED, at least one monitored part must be known. In a pair with a part of
// another object, all of its parts must be known, because two parts have no state of their own.
// Needs the report's scene.
std::string rejectsProblem(const CycleReport& report, const MonitoredPair& pair, bool is_a,
                           const Rejects& rejects, double tolerated_rejects);

// Returns why NONE and NEAR must not be claimed of any pair of a body: its own problem, or that its
// rejected triangles are not tolerated; empty if they may be. Of a body of several parts, some may
// be known, so its rejected triangles do not count. Needs the report's scene.
std::string whyUnknown(const CycleReport& report, BodyId id, double tolerated_rejects);

}  // namespace deformable_contact_monitor
