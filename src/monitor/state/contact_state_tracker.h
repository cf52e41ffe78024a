// Keeps the state of each monitored pair of bodies over time, and makes events of its changes.
//
// What decides a pair's state:
//   ALLOWED            monitoredPairs() (monitor/rules): the pair is not computed
//   NONE NEAR CONTACT  PairStates::atStamp() (pair_state.cpp), from the sums of pair_summary.cpp
//   PASSED             PairStates::inInterval(): touched since the last cycle, not at the stamp
//   UNKNOWN            one of them where contacts may be missing, or this tracker where a pair has
//                      not been computed yet, is too old, or was forgotten
// Which of a cycle's findings replace what is known, how long a state has lasted, and when a
// contact begins and ends (debouncing) is decided in contact_state_tracker.cpp.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>
#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "monitor/cycle_report.h"
#include "monitor/state/pair_state.h"

namespace deformable_contact_monitor {

// Any thread may call any function at any time: states also grow old while a cycle runs.
class ContactStateTracker {
 public:
  // Throws std::invalid_argument if a debounce count is below 1.
  explicit ContactStateTracker(const StateRules& rules);

  // Takes over the report's list of pairs. A new pair is UNKNOWN; an open contact whose pair is
  // gone ends ("no longer monitored"). Pairs are identified by the names of their bodies.
  // Then sets the states of the cycle's pairs (isOfCycle) as PairStates finds them, with three
  // exceptions:
  // - If only the partner of the object that triggered the cycle has no mesh for that stamp, what
  //   is known of the pair stays, because the partner has cycles of its own.
  // - What is known of a later stamp stays, except that a NONE or NEAR becomes PASSED if the pair
  //   touched in the report's interval. If the mesh of the object that triggered the cycle was
  //   refused or deleted, nothing stays.
  // - With motion: swept, NONE and NEAR also say that the pair did not touch since its last cycle.
  //   If the pair was known at any time since it was forgotten but has no time interval, or one
  //   that starts later than its known state, that cannot be said, and they become UNKNOWN.
  // States follow each cycle at once. Only events are debounced.
  void update(const CycleReport& report);

  // Makes every known state UNKNOWN, because of `why`, that used data of either body older than
  // max_age_s at `now`, and every one that is more than a second ahead of `now`, because the clock
  // went back. Returns whether there was one.
  bool expire(const ros::Time& now, const std::string& why);

  // Returns all pairs in the order of the last report. `stamp` is that of the header; UNKNOWN and
  // ALLOWED are stamped `now`. If `now` is zero, there is no clock: every pair is UNKNOWN and the
  // message is not complete, even if it is empty. centroid and mean_normal are those of
  // PairSummary. min_separation [m] is +inf without a triangle pair, and NaN where the state is
  // UNKNOWN or ALLOWED. `since` is never negative. It counts from the beginning of the state. An
  // UNKNOWN shorter than since_survives_s does not interrupt the state if the same state follows
  // it (with swept motion, a NONE or NEAR only if a step covers the time between them); the
  // UNKNOWN's own `since` counts from when it was reported.
  ContactStates states(const ros::Time& stamp, const ros::Time& now) const;

  // Returns the events since the last call, oldest first. An END with a reason does not come from
  // the geometry: the pair became UNKNOWN or ALLOWED, which is not debounced, or was forgotten.
  std::vector<ContactEvent> takeEvents();

  // Forgets what is known of the pairs of `body`, or of all pairs if it is empty. They are UNKNOWN
  // because of `reason`, and their `since` starts anew.
  void forget(const std::string& body, const std::string& reason, const ros::Time& now);

  // Forgets all pairs, and from now on finds nothing in reports of an epoch before this one
  // (CycleReport::epoch): they are of cycles that had begun before.
  void discard(const std::string& reason, const ros::Time& now, std::uint64_t epoch);

 private:
  // The pieces of a pair's bodies whose contacts rules leave out of its state, such as what a link
  // holds. Each number encodes one piece of each body: the part that the piece was taken from, and
  // whether it is held.
  struct LeftOut {
    std::vector<std::uint32_t> pieces;               // ascending
    std::shared_ptr<const HeldPart> held_a, held_b;  // of the bodies

    // Returns true if everything that `before` left out is still left out. `a` and `b` are the
    // bodies as they are now.
    bool covers(const LeftOut& before, const BodyStatus& a, const BodyStatus& b) const;
  };
  struct Track {
    ContactState state;            // as it was last found; UNKNOWN and ALLOWED have no stamp
    ros::Time oldest_data;         // of a known state: the older stamp of its bodies' data
    std::string whole_a, whole_b;  // the bodies' names, also where the state is of a part
    ros::Time entered;  // stamp at which the state began; of UNKNOWN and ALLOWED, the time
    // For an UNKNOWN state: the state before it (UNKNOWN if there is none), when it began, and the
    // last stamp at which it was found.
    std::uint8_t state_before = ContactState::UNKNOWN;
    ros::Time entered_before, found_before;
    bool open = false;           // BEGIN was sent, END was not
    int cycles = 0;              // cycles in a row that speak for a change of `open`
    std::string listed_problem;  // why a body was not known when all pairs were listed last
    LeftOut left_out;            // the pieces that the state does not cover

    bool isKnown() const {
      return state.state != ContactState::UNKNOWN && state.state != ContactState::ALLOWED;
    }
  };

  void forgetLocked(const std::string& body, const std::string& reason, const ros::Time& now);
  // Returns whether the pairs are others than before.
  bool listPairs(const CycleReport& report);
  void listLeftOut(const CycleReport& report);
  void updateTrack(const CycleReport& report, const MonitoredPair& pair, const PairStates& found,
                   Track* track);
  bool applyInterval(const CycleReport& report, const IntervalFinding& interval,
                     ContactState* state, Track* track);
  void updateOlder(const CycleReport& report, const IntervalFinding& interval, Track* track);
  void noteBodyProblem(const std::string& problem, Track* track) const;
  bool resumes(const ContactState& state, const IntervalFinding& interval, const ros::Time& now,
               const Track& track) const;
  void enter(ContactState state, const ros::Time& when, Track* track);
  void interrupt(std::uint8_t state, const std::string& reason, const ros::Time& now, Track* track);
  void debounce(const ros::Time& stamp, std::uint8_t before, float first_low, Track* track);
  void addEvent(const Track& track, std::uint8_t type, const ros::Time& stamp,
                const std::string& reason, float first_low = 0);

  const StateRules rules_;

  mutable std::mutex mutex_;  // guards all that follows
  std::string frame_;         // frame and number of the last report's cycle
  std::uint64_t cycle_ = 0, epoch_ = 0;
  bool is_list_ = false;  // the last report is no cycle, but lists all pairs
  std::shared_ptr<const std::vector<PartPair>> allowed_parts_;  // the last report's
  AttachedObjects attached_;                                    // the last report's
  std::vector<Track> tracks_;  // in the order of the last report's pairs
  std::vector<ContactEvent> events_;
};

}  // namespace deformable_contact_monitor
