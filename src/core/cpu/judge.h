// From pairs whose boxes overlap to contacts: the narrow phase as the CPU runs it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/body_groups.h"
#include "core/cpu/assign.h"
#include "core/cpu/lane_triangle.h"
#include "core/detector.h"
#include "core/predicates/narrow_phase.h"

namespace deformable_contact_monitor {

// A contact between two triangles of the working set, a < b.
struct WorkingContact {
  std::uint32_t a = 0, b = 0;
  float separation_m = 0;
};

// What all sweeps of a cycle read.
struct SweepInput {
  const Scene& scene;
  const WorkingSet& set;
  const SizeSplit& split;
  const ClusterAssignment& assignment;
  const BodyGroups& groups;
  const std::vector<float>& slack;  // per body [scaled]
  const Options& options;
};

// What one thread adds to.
struct SweepOutput {
  std::vector<WorkingContact> contacts;
  std::uint64_t interval_overlaps = 0, candidates = 0, exact = 0, undecided = 0;
  double sort_ms = 0, sweep_ms = 0, narrow_ms = 0;

  void add(const SweepOutput& part);
};

// A triangle as the narrow phase wants it.
struct Contender {
  LaneTriangle lanes;
  IntLanes vertex_id;
  PlaneFilter plane;
  std::uint32_t triangle = 0;  // in the working set
  std::uint32_t body = 0;

  Contender() = default;
  Contender(const Triangle& posed, const std::uint32_t id[3], std::uint32_t t,
            std::uint32_t body_of_t)
      : lanes(posed), vertex_id(identityLanes(id)), plane(posed), triangle(t), body(body_of_t) {}
};

// Two positions in an array of contenders.
struct Hit {
  std::uint32_t a, b;
};

class CandidateJudge {
 public:
  CandidateJudge(const SweepInput& input, SweepOutput& output) : input_(input), output_(output) {}

  // Two triangles whose boxes overlap.
  void judge(const Contender& a, const Contender& b);

  // As above for each of the hits, of which it leaves rubbish behind. Stage by stage over all of
  // them, so that the usual outcomes cost no mispredicted branch.
  void judge(const std::vector<Contender>& contenders, Hit* hits, std::size_t count);

 private:
  void judgeSeparate(const Contender& a, const Contender& b);
  void judgeAdjacent(const Contender& a, const Contender& b);
  void report(const Contender& a, const Contender& b, const Verdict& verdict);
  float marginOf(const Contender& a, const Contender& b) const;

  const SweepInput& input_;
  SweepOutput& output_;
  PredicateState state_;
  std::vector<Hit> neighbours_;
};

}  // namespace deformable_contact_monitor
