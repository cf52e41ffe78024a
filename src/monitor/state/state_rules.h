// By which rules the states of pairs follow from cycles.
#pragma once

namespace deformable_contact_monitor {

struct StateRules {
  int debounce_on_cycles = 1;   // a contact begins after so many cycles of CONTACT in a row, >= 1
  int debounce_off_cycles = 1;  // and ends after so many without, >= 1
  double max_age_s = 0.5;       // a state that is older is not known any more
  // The share of a body's triangles that may be rejected (for a non-finite vertex) while NONE and
  // NEAR are claimed of it, [0, 1].
  double tolerated_rejects = 0;
  // A state that comes back after less than this of UNKNOWN goes on, as `since` counts, >= 0.
  double since_survives_s = 0;
  // [m], of the detection's options: what DetectionResult::distances were found with.
  float tolerance_m = 0;
};

}  // namespace deformable_contact_monitor
