// A motion of a robot that a file tells: joint positions over time, and when links take hold of the
// object.
#pragma once

#include <string>
#include <vector>

namespace deformable_contact_monitor {

// The links take hold of what of the object is near them, or let go of it.
struct ScriptedHold {
  double time_s = 0;
  std::vector<std::string> links;  // empty: lets go of everything
  double radius_m = 0;
  bool begins_again = false;  // the script does, and the object with it
};

// Moves from one point of the file to the next, and rests at each for an instant.
class JointScript {
 public:
  // Reads a yaml file:
  //   joints: [shoulder, elbow]
  //   points: [[0, 0.1, 0.2], [2.5, 0.3, 0.2]]   # time [s], then a position per joint [rad or m]
  //   hold: [[1.5, 0.03, left_finger, right_finger], [2.5]]   # time, radius [m], links; or release
  //   loop: true                 # begins again after the last point, with the object; default
  //   false
  // Throws std::runtime_error, "<path>: <what>", if it is something else, or if times do not
  // ascend.
  explicit JointScript(const std::string& path);

  const std::vector<std::string>& names() const { return names_; }

  // Returns one position per name at `time_s` [s]; before the first point those of the first one,
  // and after the last one those of the last.
  std::vector<double> positions(double time_s) const;

  // Returns what happens after `after_s` and not after `until_s`, in this order.
  std::vector<ScriptedHold> holds(double after_s, double until_s) const;

 private:
  struct Point {
    double time_s;
    std::vector<double> positions;
  };

  double inTheScript(double time_s) const;

  std::vector<std::string> names_;
  std::vector<Point> points_;
  std::vector<ScriptedHold> holds_;
  bool loops_ = false;
};

}  // namespace deformable_contact_monitor
