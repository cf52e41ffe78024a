// Who says what touches in the cycles of an evaluation.
#include "tools/evaluate_bag/contact_source.h"

#include <utility>

#include "tools/common/backend_choice.h"

namespace deformable_contact_monitor {

DetectedContacts::DetectedContacts(std::unique_ptr<Detector> detector, bool looks_within,
                                   double swept_tolerance_m, std::shared_ptr<TilingCache> tilings)
    : detector_(std::move(detector)),
      looks_within_(looks_within),
      swept_tolerance_m_(swept_tolerance_m),
      tilings_(std::move(tilings)),
      steps_(*detector_) {}

void DetectedContacts::find(Scene* scene, CycleReport* cycle) {
  if (tilings_ != nullptr) makeTilings(*scene, tilings_.get());  // a bag waits for them
  cycle->result = &detector_->detect(*scene, cycle->options);
  if (looks_within_) noteInside(noLimit(), &containment_, cycle);
  steps_.run(cycle->options, swept_tolerance_m_, scene, cycle);
}

}  // namespace deformable_contact_monitor
