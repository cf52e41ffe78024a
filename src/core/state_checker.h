// Asks "what if": would bodies touch if some of them stood elsewhere? For planners, which ask for
// thousands of states of a robot beside meshes that stay as they are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/body_distance.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/limits.h"
#include "core/rigid_transform.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The states to check. In each of them the moved bodies have other poses than in the scene; all
// other bodies stay where they are.
struct DCM_EXPORT StateBatch {
  std::vector<BodyId> moved;  // each once, in any order
  std::size_t count = 0;      // of states
  // Poses of the moved bodies in their order, state by state: count x moved.size(), scene frame
  // from body frame. They need not be rotations, as in Scene::setPose().
  const RigidTransform* poses = nullptr;
};

// What is asked of each state. Predicates are exact.
struct DCM_EXPORT StateOptions {
  bool pairs = false;    // list all pairs of bodies that touch; else a state is done at its first
  bool nearest = false;  // find the nearest pair within the margins
  int threads = 0;       // of the CPU backend, in [0, 1024]; 0: one per core
  Limits limits;         // end the check early; none by default
};

struct DCM_EXPORT StateAnswer {
  // - kContact: two bodies touch.
  // - kNear: they do not, but two bodies are within their margin. Only if StateOptions::nearest.
  // - kNone: neither is so.
  // - kOpen: not known. The check was cut off before the state was decided; or one of its poses is
  //   not finite; or there is no contact, but a pose takes a vertex that was received finite beyond
  //   the largest float32, so that a triangle was left out.
  PairDecision decision = PairDecision::kOpen;
  // The nearest pair of the state, if StateOptions::nearest and `decision` is kContact or kNear.
  // It is the one with the least distance_m among those of all pairs of bodies
  // (DetectionResult::nearest); of several with equal distances, such as 0 for bodies that touch,
  // the one with the least (body_a, body_b).
  NearestPair nearest;
};

// Two bodies that touch in a state, body_a < body_b.
struct DCM_EXPORT TouchingBodies {
  std::uint32_t state;
  BodyId body_a, body_b;

  bool operator==(const TouchingBodies& o) const {
    return state == o.state && body_a == o.body_a && body_b == o.body_b;
  }
  bool operator<(const TouchingBodies& o) const {
    if (state != o.state) return state < o.state;
    return body_a != o.body_a ? body_a < o.body_a : body_b < o.body_b;
  }
};

struct DCM_EXPORT StateResults {
  std::vector<StateAnswer> states;  // StateBatch::count
  // All pairs of bodies that touch in the states that were decided, ascending. Empty unless
  // StateOptions::pairs.
  std::vector<TouchingBodies> pairs;
  // How many triangles take no part in any state because a vertex was received non-finite, by body
  // and part, ascending; 0 is the part of bodies without named parts. Only bodies of pairs that
  // were looked at, and parts with such triangles, are listed. They change no decision: a caller
  // that needs the whole body makes kOpen of kNone and kNear.
  std::vector<RejectedPart> rejected;
  bool cut_off = false;         // the limits left some state open
  std::string cut_off_because;  // kNoTime or "stopped"; empty: it was not
  double check_ms = 0;          // the whole check
};

// Decides states. Each decision is what Detector::detect() would find, to the bit, in a scene with
// the state's poses in which only these pairs are enabled: the enabled pairs of two different
// bodies, at least one of which is moved. (Other pairs do not depend on the state.) Parts, margins
// and radii count as there. Backends give equal results. A checker keeps data of bodies from check
// to check. One thread at a time.
class DCM_EXPORT StateChecker {
 public:
  StateChecker() = default;
  StateChecker(const StateChecker&) = delete;
  StateChecker& operator=(const StateChecker&) = delete;
  virtual ~StateChecker() = default;

  // Returns "cpu" or "cuda".
  virtual std::string backend() const = 0;

  // Decides all states, or as many as the limits allow; earlier states are begun first. The results
  // belong to the checker and are valid until the next call. Throws std::invalid_argument for a
  // moved body that does not exist or is named twice, poses that are a null pointer, a state number
  // beyond 32 bits, threads out of range on the CPU, and vertices on a device that this backend
  // cannot read. Throws a std::runtime_error (BackendError) if the backend fails.
  virtual const StateResults& check(const Scene& scene, const StateBatch& batch,
                                    const StateOptions& options) = 0;

  // Forgets what earlier checks left. Results never depend on that.
  virtual void reset() = 0;
};

// Makes a checker that runs on threads of its own TBB arena (see StateOptions::threads).
DCM_EXPORT std::unique_ptr<StateChecker> makeCpuStateChecker();

}  // namespace deformable_contact_monitor
