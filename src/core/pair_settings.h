// The settings that verdicts on pairs of triangles depend on.
#pragma once

namespace deformable_contact_monitor {

// Pairs of one body's triangles that share a vertex (bit-equal coordinates as received).
enum class AdjacentPairs {
  kBeyondShared,  // a contact iff they meet beyond the hull of the shared points
  kSkip,          // never a contact
};

enum class Predicates {
  kExact,         // the pair set equals the definition for every finite float32 input
  kConservative,  // a verdict that double arithmetic cannot decide counts as contact
  kFast,          // float32 only: may err either way
};

}  // namespace deformable_contact_monitor
