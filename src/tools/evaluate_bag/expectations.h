// Expectations: which bodies must touch in a bag, and when, and which must keep apart. They make a
// bag a regression test.
//
// An expectation names two bodies, and says whether they touch sometime, always or never in a time
// interval, or how far apart they stay in it. The states that the node would publish decide.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>
#include <ros/time.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// The names of states, in the order of ContactState's constants.
constexpr const char* kStateNames[] = {"NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED"};

// One entry of the yaml file.
struct Expectation {
  enum class Touches { kSometime, kAlways, kNever };

  std::string link, object;  // names of two bodies, in any order; equal: self-contact
  Touches touches = Touches::kSometime;
  double from_s = 0, to_s = std::numeric_limits<double>::infinity();  // after the first cycle [s]
  std::uint32_t min_pairs = 1;  // fewer triangle pairs do not count as a touch
  double keeps_m = 0;           // above 0: the two stay so far apart; `touches` means nothing then
  std::string problem;          // why it can never hold; empty: it can
};

// Reads a yaml list of {link, object, touches: sometime|always|never, from_s, to_s, min_pairs}, or
// with keeps_m in the place of touches and min_pairs. Throws std::runtime_error that names the file
// and every problem, in one line.
std::vector<Expectation> readExpectations(const std::string& path);

// Sets the problem of each expectation that names something else than an object or a link with
// geometry. `links` are all links of the robot.
void checkBodies(const std::vector<std::string>& bodies, const std::set<std::string>& links,
                 std::vector<Expectation>* expectations);

// Sets the problem of each keeps_m that cannot be shown: above the margin of its two bodies,
// because a state NONE says only that they are farther apart than that, or of a body with itself.
// Sets that of a min_pairs above 1 if `near_pairs` may count among the pairs, because they are no
// touches. `marginOf` returns the margin of a body or part [m], and the body that a part is of.
struct BodyMargin {
  std::string body;
  double margin_m = 0;
};
void checkMargins(const std::function<BodyMargin(const std::string&)>& marginOf, bool near_pairs,
                  std::vector<Expectation>* expectations);

// Checks expectations on the cycles of one run:
// - A cycle in which the pair is UNKNOWN, ALLOWED or not monitored proves nothing, so `always` and
//   `never` fail. So does a gap between two cycles of the pair, or after the last one, in which its
//   state grew too old. A pair is UNKNOWN, too, while it is NONE or NEAR but a part of it UNKNOWN.
// - An expectation without any cycle in its time fails.
// - In swept motion, PASSED breaks `never` and fulfils `sometime`; for `always` it is not a touch.
// - A contact may have more pairs than were found with a tolerance, where triangles were rejected,
//   or where memory was short. Then fewer than min_pairs (if above 1) prove nothing either.
// - keeps_m holds in a cycle if the two are certainly at least so far apart: NONE, or NEAR at such
//   a distance. Everything else breaks it, UNKNOWN too.
// - A pair that is UNKNOWN because a transform is missing, in a cycle at an edge of the recording
//   (BagContents::isAtEdge), is not judged in that cycle.
class ExpectationJudge {
 public:
  // A state holds for max_age_s [s].
  explicit ExpectationJudge(std::vector<Expectation> expectations,
                            double max_age_s = std::numeric_limits<double>::infinity());

  // Takes the states after a cycle, in the order of stamps. Only pairs that the cycle checked
  // count. `found_all`: no triangle was rejected, and no contact left out.
  void look(const ContactStates& states, bool at_edge = false, bool found_all = true);

  // Returns in how many cycles at an edge some expectation was not judged.
  std::uint64_t unjudgedCycles() const { return unjudged_; }

  struct Verdict {
    std::string text;     // the expectation in words
    std::string failure;  // empty: it holds
  };
  // Returns a verdict for each expectation. Call it after the last cycle. `end` is that of the
  // recording; zero: the last cycle is the end.
  std::vector<Verdict> verdicts(const ros::Time& end = ros::Time()) const;

 private:
  // Counts what was seen of one expectation so far.
  struct Record {
    Expectation expectation;
    std::uint64_t cycles = 0, touching = 0, unknown = 0;
    bool is_monitored = false;
    std::string first_break;  // for always and never: when it broke first, and the state then
    std::uint32_t most_pairs = 0;
    double least_m = std::numeric_limits<double>::infinity();  // of keeps_m
    double least_at_s = 0;
    // The last cycle that knew the pair's state, or was not judged: its stamp (zero: none yet),
    // its time after the first cycle [s], and whether it was judged.
    ros::Time looked;
    double looked_s = 0;
    bool was_judged = true;
  };

  double timeOf(const ros::Time& stamp);
  // Counts a gap if the pair's state had grown too old before this cycle.
  void lookAtGap(const ContactState& state, double since_s, bool is_judged, Record* record) const;
  // Counts the time from the pair's last cycle to `until_s` as UNKNOWN, but for the first
  // max_age_s_ of it and what is not the expectation's.
  void countGap(double until_s, Record* record) const;
  // Counts a gap at the end if the recording went on for longer than max_age_s_ after the pair's
  // last cycle.
  void lookAtEnd(const ros::Time& end, Record* record) const;
  // Checks one expectation at a time after the first cycle [s].
  void look(const ContactStates& states, double since_s, bool found_all, Record* record) const;
  // Does the same for one with keeps_m. `state` is null if the pair is not monitored.
  static void lookAtDistance(const ContactState* state, double tolerance_m, double since_s,
                             Record* record);

  const double max_age_s_;
  std::vector<Record> records_;
  std::uint64_t unjudged_ = 0;
  ros::Time start_;  // where the clock began, at the start or when it last went back
  double start_s_ = 0, last_s_ = 0;
  bool started_ = false;
};

}  // namespace deformable_contact_monitor
