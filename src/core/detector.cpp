#include "core/detector.h"

#include <utility>

namespace deformable_contact_monitor {

void DetectionResult::begin(const Scene& scene, const Options& options, bool is_guaranteed) {
  contacts.clear();
  separations_m.clear();
  geometry.clear();
  first_times.clear();
  within_pad.clear();
  without_step.clear();
  distances.clear();
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
  memory_bytes = 0;
  round_trip_ms = 0;
}

void DetectionResult::cutOff(const std::string& because) {
  if (!cut_off) cut_off_because = because;
  cut_off = true;
}

void DetectionResult::swap(DetectionResult& other) {
  // A pmr container is moved without a copy only within one memory resource.
  if (contacts.get_allocator() != other.contacts.get_allocator()) {
    other.contacts.clear();
    other.contacts.moveTo(*contacts.get_allocator().resource());
  }
  std::swap(*this, other);
}

}  // namespace deformable_contact_monitor
