// The settings on which the decision about a pair of triangles depends.
#pragma once

namespace deformable_contact_monitor {

// The treatment of pairs of triangles of one body that share a vertex (equal coordinates as
// received).
enum class AdjacentPairs {
  kBeyondShared,  // a contact iff they intersect outside the convex hull of their shared vertices
  kSkip,          // never a contact
};

enum class Predicates {
  kExact,         // the pair set equals the definition for every finite float32 input
  kConservative,  // a pair that double arithmetic cannot decide counts as a contact
};

}  // namespace deformable_contact_monitor
