// Finds where the clock of a recording went back, as when a simulator starts anew.
#pragma once

#include <ros/time.h>

#include <cstddef>
#include <deque>
#include <map>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Follows the stamps of several sources: frames, joints and topics of meshes. A late message is no
// jump: a source's time has jumped if its stamps are elsewhere for a second, or if they went back
// and rose from there to where they had been, while no other source of that clock just went on.
class TimeJumps {
 public:
  struct Jump {
    ros::Time received;  // when the first message from after the jump was recorded
    ros::Time from, to;  // stamps before and after it
    // When sources went back that did so later than the first, because they are slower.
    std::map<std::string, ros::Time> later{};
  };

  // Says how a stamp continues those of its source.
  enum class Fit {
    kFits,
    kOdd,   // it is far from those before it, and maybe wrong
    kAnew,  // those before it do not count any more: the time has jumped
  };

  // Meshes may have a clock of their own: they make no jump where any transform goes on.
  enum class Kind { kPose, kMesh };

  // Takes a stamp. Call it in the order of receipt.
  Fit look(const std::string& source, Kind kind, const ros::Time& stamp, const ros::Time& received);

  // Finds a jump shortly before the end of the recording. Call it after the last stamp.
  void finish();

  // Returns the jumps that went back, in the order of receipt. The whole recording jumps with the
  // first source that does.
  const std::vector<Jump>& all() const { return jumps_; }

  // Returns how many jumps came before what was received then.
  std::size_t partAt(const ros::Time& received) const;
  // Returns how many jumps the source had made then. It may send for a moment what is from before.
  std::size_t partOf(const std::string& source, const ros::Time& received) const;

 private:
  struct Message {
    ros::Time stamp, received;
  };
  struct Source {
    Kind kind = Kind::kPose;
    ros::Time newest;  // zero: none yet
    // The first and the last of the latest stamps that do not fit; zero: the last one fits.
    Message odd, last_odd;
    std::size_t odd_count = 0;
    bool is_awaited = false;  // nothing was received of it since the last jump
    std::deque<Message> recent;

    bool isOdd() const { return !odd.stamp.isZero(); }
    bool isBack() const { return isOdd() && odd.stamp < newest; }
    double backBy() const;
    std::deque<Message>::const_iterator firstOdd() const;
    double clockBackBy() const;
    bool precedes(const Source& other) const;
    void beginAnew(const ros::Time& stamp);
    void beginAfterJump();
    void addOdd(const Message& message);
    void remember(const Message& message);
  };

  static bool goesOn(const Message& before, const Message& after, double tolerance_s);
  Fit fitOf(const std::string& name, Source* source, const Message& message);
  bool isLeftover(const Source& source, const Message& message) const;
  bool isContradicted(const std::string& name) const;
  bool jump(const std::string& name);

  std::map<std::string, Source> sources_;
  std::vector<Jump> jumps_;
};

// Return the names of sources.
inline std::string frameSource(const std::string& frame) { return "frame " + frame; }
inline std::string jointSource(const std::string& joint) { return "joint " + joint; }
inline std::string topicSource(const std::string& topic) { return "topic " + topic; }

}  // namespace deformable_contact_monitor
