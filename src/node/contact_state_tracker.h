// How each monitored pair of bodies stands, and since when; begin and end of contact, debounced.
#pragma once

#include <deformable_contact_monitor/ContactEvent.h>
#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "node/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class ContactStateTracker {
 public:
  // A contact begins after `debounce_on_cycles` cycles of CONTACT in a row and ends after
  // `debounce_off_cycles` without. Throws std::invalid_argument unless both are >= 1.
  ContactStateTracker(int debounce_on_cycles, int debounce_off_cycles);

  // One state per report.pairs, in that order; states follow each cycle at once (only events are
  // debounced). ALLOWED pairs are not computed; else UNKNOWN if either body is unknown, if no
  // detection ran, or if it left contacts out of its list and none that is listed is the pair's;
  // else CONTACT, or NEAR when every triangle pair is apart (within the margin).
  // centroid [m]: mean over the triangle pairs of the mean of their six corners. mean_normal: from
  // link triangles' own normals weighted by area; zero without a link, or where they cancel out.
  // min_separation [m] is +inf without a triangle pair and NaN where the state is UNKNOWN or
  // ALLOWED. `since` counts header stamps, never below zero. Pairs are told apart by their bodies'
  // names; an open contact whose pair is gone from the report ends ("no longer monitored").
  ContactStates update(const CycleReport& report);

  // Events since the last call, oldest first. An END with a reason is not the geometry's: the pair
  // became UNKNOWN or ALLOWED (at once, not debounced), or the tracker was reset.
  std::vector<ContactEvent> takeEvents();

  // Ends every open contact with `reason` and forgets all states and times.
  void reset(const std::string& reason);

 private:
  using Names = std::pair<std::string, std::string>;

  struct Track {
    std::uint8_t state = ContactState::UNKNOWN;
    ros::Time entered;       // when `state` began
    bool open = false;       // BEGIN was sent, END not yet
    int cycles = 0;          // in a row that speak for a change of `open`
    std::uint64_t seen = 0;  // number of the latest update with this pair
  };

  void advance(const Names& names, const ContactState& state, const std::string& interruption,
               Track* track);
  void addEvent(const Names& names, std::uint8_t type, std::uint32_t pair_count,
                const std::string& reason);
  void dropUnseen();

  int debounce_on_cycles_;
  int debounce_off_cycles_;
  std::uint64_t updates_ = 0;
  std_msgs::Header header_;  // of the latest update
  std::map<Names, Track> tracks_;
  std::vector<ContactEvent> events_;
};

}  // namespace deformable_contact_monitor
