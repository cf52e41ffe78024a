// Three lines in which some compilers leave out the rounding to float32, unless flags forbid it.
// Compiled at -O3 with the flags that all targets of this project have.
#include "rounded_lines.h"

namespace deformable_contact_monitor {

void roundTwo(const double* a, double* o) {
  float f = static_cast<float>(a[0] * 3), g = static_cast<float>(a[1] * 3);
  o[0] = f;
  o[1] = g;
}

}  // namespace deformable_contact_monitor
