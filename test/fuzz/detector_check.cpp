// A cycle of the CPU backend held against brute force.
#include "detector_check.h"

#include <cmath>
#include <cstring>

#include "fuzz_target.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kSmall = 200;  // triangles

bool sameBits(float a, float b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void requireInScene(const Scene& scene, const DetectionResult& result) {
  const TrianglePair* before = nullptr;
  for (const TrianglePair& pair : result.contacts) {
    requireThat(before == nullptr || *before < pair, "contacts are not ascending");
    requireThat(pair.body_a < scene.bodyCount() && pair.body_b < scene.bodyCount() &&
                    pair.triangle_a < scene.body(pair.body_a).mesh.triangleCount() &&
                    pair.triangle_b < scene.body(pair.body_b).mesh.triangleCount(),
                "a contact of no triangles");
    requireThat(scene.pairEnabled(pair.body_a, pair.body_b), "a contact of a pair that is off");
    before = &pair;
  }
  requireThat(result.separations_m.size() == (scene.anyMargin() ? result.contacts.size() : 0),
              "separations do not go with contacts");
}

// Returns whether all contacts of `some` are also in `all`. If `ask_separations` is set, their
// separations must be equal too.
bool isSubset(const DetectionResult& some, const DetectionResult& all, bool ask_separations) {
  std::size_t j = 0;
  for (std::size_t i = 0; i < some.contacts.size(); ++i) {
    while (j < all.contacts.size() && all.contacts[j] < some.contacts[i]) ++j;
    if (j == all.contacts.size() || !(all.contacts[j] == some.contacts[i])) return false;
    const bool has_separation = ask_separations && !some.separations_m.empty();
    if (has_separation && !sameBits(some.separations_m[i], all.separations_m[j])) return false;
  }
  return true;
}

void compare(const DetectionResult& found, const DetectionResult& expected,
             const Options& options) {
  const bool is_whole = options.overlap == 1 && !found.cut_off;
  requireThat(found.left_out == 0, "contacts were left out of a small scene");
  if (options.predicates == Predicates::kExact) {
    requireThat(isSubset(found, expected, true),
                "a contact or separation that brute force has not");
    requireThat(!is_whole || found.contacts.size() == expected.contacts.size(),
                "a contact of brute force is missing");
  } else if (is_whole) {  // conservative
    requireThat(isSubset(expected, found, false), "conservative lost a contact");
    requireThat(found.contacts.size() - expected.contacts.size() <= found.counters.undecided,
                "more contacts than were undecided");
  }
  requireThat(found.cut_off || found.counters.rejected == expected.counters.rejected,
              "rejected triangles are counted otherwise");
}

}  // namespace

const DetectionResult& detectChecked(Detector* detector, const Scene& scene,
                                     const Options& options) {
  const DetectionResult& found = detector->detect(scene, options);
  requireInScene(scene, found);
  requireThat(found.guaranteed == isGuaranteed(options), "a guarantee that does not hold");
  if (scene.triangleCount() > kSmall) return found;
  Options exact;
  exact.adjacent = options.adjacent;
  compare(found, makeBruteForceDetector()->detect(scene, exact), options);
  return found;
}

}  // namespace deformable_contact_monitor
