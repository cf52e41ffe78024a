// Finds where the clock of a recording went back, as when a simulator starts anew.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Follows the stamps of several sources, such as frames or topics. A single message with a wrong
// stamp is no jump: a source's time has jumped if its stamps are elsewhere for a second.
class TimeJumps {
 public:
  struct Jump {
    ros::Time received;  // when the first message from after the jump was recorded
    ros::Time from, to;  // stamps before and after it
  };

  // Says how a stamp continues those of its source.
  enum class Fit {
    kFits,
    kOdd,   // it is far from those before it, and maybe wrong
    kAnew,  // those before it do not count any more: the time has jumped
  };

  // Takes a stamp. Call it in the order of receipt.
  Fit look(const std::string& source, const ros::Time& stamp, const ros::Time& received);

  // Returns the jumps that went back, in the order of receipt. The whole recording jumps with the
  // first source that does.
  const std::vector<Jump>& all() const { return jumps_; }

  // Returns how many jumps came before what was received then.
  std::size_t partAt(const ros::Time& received) const;

  // Returns whether a message was sent before a jump and recorded just after it.
  bool isLeftover(const ros::Time& stamp, const ros::Time& received) const;

 private:
  struct Source {
    ros::Time newest;  // zero: none yet
    ros::Time odd;     // the first of the latest stamps that do not fit; zero: the last one fits
    ros::Time odd_received;
  };

  void add(const Source& source);

  std::map<std::string, Source> sources_;
  std::vector<Jump> jumps_;
};

}  // namespace deformable_contact_monitor
