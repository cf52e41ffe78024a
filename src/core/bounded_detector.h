// Contacts within a stated distance error, and within a stated time.
#pragma once

#include <memory>

#include "core/detector.h"
#include "core/export.h"
#include "core/tiling_cache.h"

namespace deformable_contact_monitor {

// Decides pairs of two bodies by bounds of their tiles (tiling.h), as far down as it takes, and
// gives DetectionResult::distances, decided by decide() (body_distance.h):
// - options.tolerance_m above 0: each pair until it is decided. Contacts are not listed, but for
//   those that were seen on the way; so `guaranteed` is false then.
// - limits.deadline set: pairs take turns, the most doubtful tiles first. With tolerance 0 they are
//   listed after that, as long as there is time. What the deadline ends is cut_off; each pair has
//   what is certain by then.
// Else, and in swept motion, `exact` does all of it. A body with itself, and pairs of bodies whose
// tiling is not made yet or whose vertices are on a device, go to `exact` always; it has what time
// the other pairs leave, and a part that it needs to end in; of its pairs of two bodies
// `distances` say what its list says.
// Bounds and verdicts are exact, whatever options.predicates and overlap, which are for `exact`;
// without a deadline the result is the same for any number of threads. `tilings`: null: its own;
// one thread at a time.
DCM_EXPORT std::unique_ptr<Detector> makeBoundedDetector(
    std::unique_ptr<Detector> exact, std::shared_ptr<TilingCache> tilings = nullptr);

}  // namespace deformable_contact_monitor
