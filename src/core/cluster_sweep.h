// One cluster: principal axes, interval sort, sweep, and the verdicts on what it finds.
#pragma once

#include <cstdint>
#include <vector>

#include "core/body_groups.h"
#include "core/cluster_assignment.h"
#include "core/detector.h"
#include "core/lane_triangle.h"
#include "core/narrow_phase.h"
#include "core/principal_axes.h"

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
};

// A triangle as the narrow phase wants it.
struct Contender {
  LaneTriangle lanes;
  PlaneFilter plane;
  std::uint32_t triangle;  // in the working set

  Contender() = default;
  Contender(const WorkingSet& set, std::uint32_t t)
      : lanes(set.posed(t)), plane(set.posed(t)), triangle(t) {}
};

// Decides candidates one by one; holds what a thread needs for that.
class CandidateJudge {
 public:
  CandidateJudge(const SweepInput& input, SweepOutput& output) : input_(input), output_(output) {}

  // Two triangles whose boxes overlap.
  void judge(const Contender& a, const Contender& b);

 private:
  void judgeAdjacent(const Contender& a, const Contender& b, const SharedVertices& shared);
  void report(const Contender& a, const Contender& b, const Verdict& verdict);
  Triangle received(std::uint32_t t) const;

  const SweepInput& input_;
  SweepOutput& output_;
  PredicateState state_;
};

// Sweeps clusters; keeps its buffers from cluster to cluster. One per thread.
class ClusterSweeper {
 public:
  explicit ClusterSweeper(const SweepInput& input) : input_(input) {}

  void sweep(std::uint32_t cluster);

  SweepOutput& output() { return output_; }

 private:
  struct Member {
    std::uint32_t regular, group;
    Interval interval[3];
  };
  // Two positions in sweep order whose boxes along the principal axes overlap.
  struct Hit {
    std::uint32_t a, b;
  };
  // Members of one group of bodies: a range of the sorted arrays.
  struct Segment {
    std::uint32_t group, begin, end;
  };

  void sortMembers();
  void sweepWithin(const Segment& s);
  void sweepAcross(const Segment& rows, const Segment& columns, bool closed);
  void scan(std::uint32_t row, std::uint32_t begin, std::uint32_t end);
  bool owns(std::uint32_t a, std::uint32_t b) const;
  void judgeHits();

  const SweepInput& input_;
  SweepOutput output_;
  std::uint32_t cluster_ = 0;
  std::vector<Member> members_;
  std::vector<std::uint64_t> order_;
  std::vector<Segment> segments_;
  std::vector<float> lo_, hi_;                        // along the first axis
  std::vector<std::uint32_t> packed_lo_, packed_hi_;  // along the other two
  std::vector<Aabb> boxes_;
  std::vector<Contender> contenders_;
  std::vector<const std::uint32_t*> clusters_;  // of each member, ascending
  std::vector<Hit> hits_;                       // of which hit_count_ are in use
  std::size_t hit_count_ = 0;
};

}  // namespace deformable_contact_monitor
