#include "cuda/memory/cycle_buffers.cuh"

namespace deformable_contact_monitor {

bool CycleBuffers::grow(const CycleSizes& s) {
  const std::size_t clusters = s.clusters;
  bool moved = counters_.grow(1);
  moved |= params_.grow(1);
  moved |= prototypes_.grow(clusters);
  moved |= live_prototypes_.grow(clusters);
  moved |= list_reach_.grow(clusters);
  moved |= neighbours_.grow(clusters * kMostNeighbours);
  moved |= neighbour_cluster_.grow(clusters * kMostNeighbours);
  moved |= membership_sums_.grow(clusters);
  moved |= samples_.grow(s.samples);
  moved |= bins_.grow(clusters + 1);
  moved |= next_bins_.grow(clusters + 1);
  moved |= member_count_.grow((clusters + 1) * kCountStride);
  moved |= members_.grow(s.members);
  moved |= wide_.grow(s.triangles);
  moved |= lists_.grow(s.list_words);
  moved |= frames_.grow(clusters);
  moved |= moments_.grow(clusters);
  moved |= sweep_boxes_.grow(s.members + std::size_t{64});  // sweeps read on
  moved |= world_boxes_.grow(s.members);
  moved |= sweep_keys_.grow(s.members);
  moved |= sweep_ids_.grow(s.members);
  moved |= bucket_begin_.grow(clusters * (kBuckets + 1));
  moved |= units_.grow(s.units);
  moved |= candidates_.grow(s.candidates);
  moved |= open_.grow(s.candidates);
  moved |= contacts_.grow(s.contacts);
  moved |= separations_m_.grow(s.contacts);
  host_counters_.grow(1);
  return moved;
}

void CycleBuffers::view(CycleView& cycle) {
  cycle.params = params_.data();
  cycle.counters = counters_.data();
  cycle.host_counters = host_counters_.data();
  cycle.prototypes = prototypes_.data();
  cycle.live_prototypes = live_prototypes_.data();
  cycle.list_reach = list_reach_.data();
  cycle.neighbours = neighbours_.data();
  cycle.neighbour_cluster = neighbour_cluster_.data();
  cycle.membership_sums = membership_sums_.data();
  cycle.samples = samples_.data();
  cycle.bins = bins_.data();
  cycle.next_bins = next_bins_.data();
  cycle.member_count = member_count_.data();
  cycle.members = members_.data();
  cycle.member_capacity = static_cast<std::uint32_t>(members_.size());
  cycle.wide = wide_.data();
  cycle.lists = lists_.data();
  cycle.list_capacity = static_cast<std::uint32_t>(lists_.size());
  cycle.frames = frames_.data();
  cycle.moments = moments_.data();
  cycle.sweep_boxes = sweep_boxes_.data();
  cycle.world_boxes = world_boxes_.data();
  cycle.sweep_keys = sweep_keys_.data();
  cycle.sweep_ids = sweep_ids_.data();
  cycle.bucket_begin = bucket_begin_.data();
  cycle.units = units_.data();
  cycle.unit_capacity = static_cast<std::uint32_t>(units_.size());
  cycle.candidates = candidates_.data();
  cycle.candidate_capacity = static_cast<std::uint32_t>(candidates_.size());
  cycle.open = open_.data();
  cycle.contacts = contacts_.data();
  cycle.separations_m = separations_m_.data();
  cycle.contact_capacity = static_cast<std::uint32_t>(contacts_.size());
}

std::uint64_t CycleBuffers::bytes() const {
  return counters_.bytes() + params_.bytes() + prototypes_.bytes() + live_prototypes_.bytes() +
         list_reach_.bytes() + neighbours_.bytes() + neighbour_cluster_.bytes() +
         membership_sums_.bytes() + samples_.bytes() + bins_.bytes() + next_bins_.bytes() +
         member_count_.bytes() + members_.bytes() + wide_.bytes() + lists_.bytes() +
         frames_.bytes() + moments_.bytes() + sweep_boxes_.bytes() + world_boxes_.bytes() +
         sweep_keys_.bytes() + sweep_ids_.bytes() + bucket_begin_.bytes() + units_.bytes() +
         candidates_.bytes() + open_.bytes() + contacts_.bytes() + separations_m_.bytes();
}

}  // namespace deformable_contact_monitor
