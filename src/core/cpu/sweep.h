// One cluster: principal axes, interval sort, sweep, and the verdicts on what it finds.
#pragma once

#include <cstdint>
#include <vector>

#include "core/cpu/interval_scan.h"
#include "core/cpu/judge.h"
#include "core/rules/principal_axes.h"

namespace deformable_contact_monitor {

// Sweeps clusters; keeps its buffers from cluster to cluster. One per thread.
class ClusterSweeper {
 public:
  explicit ClusterSweeper(const SweepInput& input) : input_(input), judge_(input, output_) {}
  ClusterSweeper(const ClusterSweeper&) = delete;
  ClusterSweeper& operator=(const ClusterSweeper&) = delete;

  void sweep(std::uint32_t cluster);

  SweepOutput& output() { return output_; }

 private:
  // What is computed for a member before its place in the order is known.
  struct Projected {
    std::uint32_t group;
    Vec3f scaled[3];
    Interval interval[3];
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
  CandidateJudge judge_;
  std::uint32_t cluster_ = 0;
  std::vector<Projected> projected_;
  std::vector<std::uint64_t> order_;
  std::vector<Segment> segments_;
  std::vector<float> lo_, hi_;                        // along the first axis
  std::vector<std::uint32_t> packed_lo_, packed_hi_;  // along the other two
  std::vector<Aabb> boxes_;
  std::vector<Contender> contenders_;
  std::vector<const std::uint32_t*> clusters_;  // of each member, ascending
  std::vector<char> alone_;                     // each member's only cluster is this one
  std::vector<Hit> hits_;                       // of which hit_count_ are in use
  std::size_t hit_count_ = 0;
};

}  // namespace deformable_contact_monitor
