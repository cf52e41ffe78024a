// Expectations: which bodies must touch in a bag, and when. They make a bag a regression test.
//
// An expectation names two bodies, and says whether they touch sometime, always or never in a time
// interval. The states that the node would publish decide.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// One entry of the yaml file.
struct Expectation {
  enum class Touches { kSometime, kAlways, kNever };

  std::string link, object;  // names of two bodies, in any order; equal: self-contact
  Touches touches = Touches::kSometime;
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();  // after the first cycle [s]
  std::uint32_t min_pairs = 1;  // fewer triangle pairs do not count as a touch
  std::string problem;          // why it can never hold; empty: it can
};

// Reads a yaml list of {link, object, touches: sometime|always|never, from_s, to_s, min_pairs}.
// Throws std::runtime_error that names the file and every problem, in one line.
std::vector<Expectation> readExpectations(const std::string& path);

// Sets the problem of each expectation that names something else than an object or a link with
// geometry. `links` are all links of the robot.
void checkBodies(const std::vector<std::string>& bodies, const std::set<std::string>& links,
                 std::vector<Expectation>* expectations);

// Checks expectations on the cycles of one run:
// - A cycle in which the pair is UNKNOWN, ALLOWED or not monitored proves nothing, so `always` and
//   `never` fail.
// - An expectation without any cycle in its time fails.
// - In swept motion, PASSED breaks `never` and fulfils `sometime`; for `always` it is not a touch.
// - With a tolerance, a contact may have more pairs than were found, so fewer than min_pairs (if
//   above 1) prove nothing either.
class ExpectationJudge {
 public:
  explicit ExpectationJudge(std::vector<Expectation> expectations);

  // Takes the states after a cycle, in the order of stamps. Only pairs that the cycle checked
  // count.
  void look(const ContactStates& states);

  struct Verdict {
    std::string text;     // the expectation in words
    std::string failure;  // empty: it holds
  };
  // Returns a verdict for each expectation. Call it after the last cycle.
  std::vector<Verdict> verdicts() const;

 private:
  // Counts what was seen of one expectation so far.
  struct Record {
    Expectation expectation;
    std::uint64_t cycles = 0, touching = 0, unknown = 0;
    bool is_monitored = false;
    std::string first_break;  // for always and never: when it broke first, and the state then
    std::uint32_t most_pairs = 0;
  };

  // Checks one expectation at a time after the first cycle [s].
  void look(const ContactStates& states, double since_s, Record* record) const;

  std::vector<Record> records_;
  ros::Time start_;
  bool started_ = false;
};

}  // namespace deformable_contact_monitor
