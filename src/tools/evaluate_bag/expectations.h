// Who must touch whom in a bag, and when.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

struct Expectation {
  enum class Touches { kSometime, kAlways, kNever };

  std::string link, object;  // any two bodies, in any order; equal: the body with itself
  Touches touches = Touches::kSometime;
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();  // since the first cycle
  std::uint32_t min_pairs = 1;                                        // that make a touch
  std::string problem;  // why it cannot hold, whatever the cycles show; empty: it can
};

// From a yaml list of {link, object, touches: sometime|always|never, from_s, to_s, min_pairs}.
// Throws std::runtime_error that names the file and every problem, in one line.
std::vector<Expectation> readExpectations(const std::string& path);

// Gives those a problem that name no body: neither an object nor a link with geometry. `links` are
// all that the robot has.
void checkBodies(const std::vector<std::string>& bodies, const std::set<std::string>& links,
                 std::vector<Expectation>* expectations);

// Judges one run's cycles. A cycle in which the pair is UNKNOWN, ALLOWED or not monitored is no
// proof of anything: `always` and `never` fail by it. So do expectations without a single cycle in
// their time. In swept motion a pair that has passed breaks `never` and is enough for `sometime`;
// for `always` it is no touch. With a tolerance a contact may have more pairs than were seen, so
// that fewer than min_pairs (above 1) are no proof either.
class ExpectationJudge {
 public:
  explicit ExpectationJudge(std::vector<Expectation> expectations);

  // Cycles in the order of their stamps; each speaks of the pairs that it looked at alone.
  void look(const ContactStates& states);

  struct Verdict {
    std::string text;     // the expectation, for people
    std::string failure;  // empty: it holds
  };
  // After the last cycle.
  std::vector<Verdict> verdicts() const;

 private:
  struct Record {
    Expectation expectation;
    std::uint64_t cycles = 0, touching = 0, unknown = 0;
    bool is_monitored = false;
    std::string first_break;  // of always or never: when and what was seen
    std::uint32_t most_pairs = 0;
  };

  void look(const ContactStates& states, double since_s, Record* record) const;

  std::vector<Record> records_;
  ros::Time start_;
  bool started_ = false;
};

}  // namespace deformable_contact_monitor
