// How each monitored pair of bodies stands, of when that is, and since when; begin and end of
// contact, debounced.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>
#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "monitor/cycle_report.h"
#include "monitor/state/pair_finding.h"
#include "monitor/state/pair_summary.h"
#include "monitor/state/state_rules.h"
#include "monitor/state/step_verdicts.h"

namespace deformable_contact_monitor {

// Threads may call every function at any time: states grow old while a cycle runs.
class ContactStateTracker {
 public:
  // Throws std::invalid_argument at counts below 1.
  explicit ContactStateTracker(const StateRules& rules);

  // Takes over which pairs there are: one that is new is UNKNOWN, an open contact whose pair is
  // gone ends ("no longer monitored"); pairs are told apart by their bodies' names. Then the states
  // of the cycle's pairs (isOfCycle) at the report's stamp:
  // - UNKNOWN if a body of it is, or if no detection ran; also where no contact that is listed is
  // the
  //   pair's, if contacts or too many triangles of its bodies were left out, or if the report is
  //   too old already. But where only the partner of the object that triggered has no mesh for that
  //   stamp, what is known of the pair stays: the partner has cycles too.
  // - else CONTACT, also where a part of one is within the other (inside), or NEAR when every
  // triangle pair is apart (within the margin), or NONE. What is known of a later stamp stays.
  // - where the result has the pair's distance, by decide() (core/body_distance.h) instead;
  // UNKNOWN,
  //   with distance_low, where that is open.
  // - in swept motion PASSED, in place of NEAR and NONE, where the pair touched in its step;
  // UNKNOWN
  //   where the step may have missed that, or where there is no step and the pair was known before:
  //   NONE then says nothing of the time in between. Also for a stamp before what is known.
  // States follow each cycle at once (only events are debounced).
  void update(const CycleReport& report);

  // Every known state that is older than max_age_s at `now` is UNKNOWN, because of `why`. Returns
  // whether there was one.
  bool expire(const ros::Time& now, const std::string& why);

  // All pairs in the order of the last report. `stamp`: of the header; UNKNOWN and ALLOWED are
  // stamped `now`. centroid and mean_normal: as in PairSummary. min_separation [m] is +inf without
  // a triangle pair and NaN where the state is UNKNOWN or ALLOWED. `since` is never below zero. It
  // counts from when the state began, also beyond an UNKNOWN that was said for less than
  // since_survives_s if the state is the one before it; UNKNOWN's own counts from when it was said.
  ContactStates states(const ros::Time& stamp, const ros::Time& now) const;

  // Events since the last call, oldest first. An END with a reason is not the geometry's: the pair
  // became UNKNOWN or ALLOWED (at once, not debounced), or was forgotten.
  std::vector<ContactEvent> takeEvents();

  // What is known of the pairs of `body`, or of all if it is empty, is forgotten: they are UNKNOWN
  // because of `reason`, which no `since` survives.
  void forget(const std::string& body, const std::string& reason, const ros::Time& now);

 private:
  struct Track {
    ContactState state;  // as it was last found; UNKNOWN and ALLOWED without a stamp
    ros::Time entered;   // stamp with which its state began; UNKNOWN, ALLOWED: when
    // While it is UNKNOWN: the state before that (UNKNOWN: none), and when that one began.
    std::uint8_t state_before = ContactState::UNKNOWN;
    ros::Time entered_before;
    bool open = false;  // BEGIN was sent, END not yet
    int cycles = 0;     // in a row that speak for a change of `open`

    bool isKnown() const {
      return state.state != ContactState::UNKNOWN && state.state != ContactState::ALLOWED;
    }
  };

  void listPairs(const CycleReport& report);
  void look(const CycleReport& report, const MonitoredPair& pair, const PairSummary& summary,
            const StepVerdicts& steps, Track* track);
  bool lookAtStep(const CycleReport& report, const StepVerdict& step, ContactState* state,
                  Track* track);
  void lookBack(const CycleReport& report, const StepVerdict& step, Track* track);
  bool resumes(const ContactState& state, const ros::Time& now, const Track& track) const;
  void enter(ContactState state, const ros::Time& when, Track* track);
  void interrupt(std::uint8_t state, const std::string& reason, const ros::Time& now, Track* track);
  void debounce(const ros::Time& stamp, std::uint8_t before, float first_low, Track* track);
  void addEvent(const Track& track, std::uint8_t type, const ros::Time& stamp,
                const std::string& reason, float first_low = 0);

  const StateRules rules_;

  mutable std::mutex mutex_;  // guards what follows
  std::string frame_;         // of the last report, and its cycle
  std::uint64_t cycle_ = 0;
  std::vector<Track> tracks_;  // in the order of its pairs
  std::vector<ContactEvent> events_;
};

}  // namespace deformable_contact_monitor
