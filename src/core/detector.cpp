#include "core/detector.h"

#include <algorithm>

namespace deformable_contact_monitor {

void Counters::addWork(const Counters& part) {
  clustered += part.clustered;
  large += part.large;
  cluster_entries += part.cluster_entries;
  largest_cluster = std::max(largest_cluster, part.largest_cluster);
  interval_overlaps += part.interval_overlaps;
  candidates += part.candidates;
  exact += part.exact;
  undecided += part.undecided;
}

void DetectionResult::begin(const Scene& scene, const Options& options, bool is_guaranteed) {
  contacts.clear();
  separations_m.clear();
  geometry.clear();
  first_times.clear();
  within_pad.clear();
  without_step.clear();
  distances.clear();
  nearest.clear();
  nearest_parts.clear();
  rejected_parts.clear();
  for (BodyId id = 0; options.motion == Motion::kSwept && id < scene.bodyCount(); ++id) {
    if (!scene.body(id).earlier && scene.takesPart(id)) without_step.push_back(id);
  }
  left_out = 0;
  cut_off = false;
  cut_off_because.clear();
  guaranteed = is_guaranteed;
  started_cold = false;
  counters = Counters();
  counters.triangles = scene.triangleCount();
  stages_ms.clear();
  detect_ms = 0;
  memory_bytes = detector_bytes = 0;
  memory_is_whole = false;
  round_trip_ms = 0;
}

std::set<std::pair<BodyId, BodyId>> DetectionResult::touchingBodies() const {
  std::set<std::pair<BodyId, BodyId>> bodies;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (touches(i)) bodies.insert({contacts[i].body_a, contacts[i].body_b});
  }
  return bodies;
}

void DetectionResult::cutOff(const std::string& because) {
  if (!cut_off) cut_off_because = because;
  cut_off = true;
}

void DetectionResult::swap(DetectionResult& other) {
  // A pmr container is moved without a copy only within one memory resource.
  const auto toSameMemory = [](auto& list, auto& other_list) {
    if (list.get_allocator() == other_list.get_allocator()) return;
    other_list.clear();
    other_list.moveTo(*list.get_allocator().resource());
  };
  toSameMemory(contacts, other.contacts);
  toSameMemory(geometry, other.geometry);
  std::swap(*this, other);
}

}  // namespace deformable_contact_monitor
