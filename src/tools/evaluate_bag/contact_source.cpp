// Who says what touches in the cycles of an evaluation.
#include "tools/evaluate_bag/contact_source.h"

#include <utility>

namespace deformable_contact_monitor {

DetectedContacts::DetectedContacts(std::unique_ptr<Detector> detector, bool looks_within,
                                   double swept_tolerance_m)
    : detector_(std::move(detector)),
      looks_within_(looks_within),
      swept_tolerance_m_(swept_tolerance_m),
      steps_(*detector_) {}

void DetectedContacts::find(Scene* scene, CycleReport* cycle) {
  cycle->result = &detector_->detect(*scene, cycle->options);
  if (looks_within_) noteInside(noLimit(), &containment_, cycle);
  steps_.run(cycle->options, swept_tolerance_m_, scene, cycle);
}

}  // namespace deformable_contact_monitor
