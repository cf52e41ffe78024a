// Reads expectations from yaml, and checks them cycle by cycle.
#include "tools/evaluate_bag/expectations.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "monitor/rules/parameter_reader.h"
#include "monitor/time_difference.h"
#include "reader/contact_reader.h"
#include "robot/nearest_name.h"
#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
#include "tools/common/yaml_parameters.h"

namespace deformable_contact_monitor {
namespace {

// Stands for "until the end" [s].
constexpr double kLongestS = 1e9;

std::string seconds(double s) { return formatted("%.3f s", s); }

std::string metres(double m) { return formatted("%.6g m", m); }

// Returns the expectation in words, for reports.
std::string describe(const Expectation& e) {
  const char* const kWords[] = {" touches ", " always touches ", " never touches "};
  std::string text = e.keeps_m > 0 ? e.link + " keeps " + metres(e.keeps_m) + " from " + e.object
                                   : e.link + kWords[static_cast<int>(e.touches)] + e.object;
  if (e.min_pairs > 1) text += " in " + std::to_string(e.min_pairs) + " pairs or more";
  if (e.from_s > 0) text += " from " + seconds(e.from_s);
  if (e.to_s < kLongestS) text += " to " + seconds(e.to_s);
  return text;
}

// Returns the state of the expectation's bodies, which may stand in any order; null if the pair is
// not monitored. A part that is UNKNOWN may touch although its body's own state is NONE or NEAR, so
// the part's state is the pair's then.
const ContactState* find(const ContactStates& states, const Expectation& e) {
  const ContactState* own = nullptr;
  const ContactState* unknown = nullptr;  // of a part
  for (const ContactState& state : states.states) {
    const std::string &a = state.body_a, &b = state.body_b;
    if ((a == e.link && b == e.object) || (a == e.object && b == e.link)) {
      own = &state;
    } else if (state.state == ContactState::UNKNOWN && unknown == nullptr &&
               ((ContactReader::isOf(a, e.link) && ContactReader::isOf(b, e.object)) ||
                (ContactReader::isOf(a, e.object) && ContactReader::isOf(b, e.link)))) {
      unknown = &state;
    }
  }
  const bool is_apart =
      own != nullptr && (own->state == ContactState::NONE || own->state == ContactState::NEAR);
  return is_apart && unknown != nullptr ? unknown : own;
}

// Returns a state in words, for the failure of an expectation.
std::string seen(const ContactState* state) {
  if (state == nullptr) return "not monitored";
  return std::string(kStateNames[state->state]) + ", " + std::to_string(state->pair_count) +
         " pairs" + (state->reason.empty() ? "" : " (" + state->reason + ")");
}

// Returns whether the pair is UNKNOWN because TransformLookup found no transform of a body. Reasons
// name the body, also for the state of a part.
bool lacksTransform(const ContactState& state) {
  if (state.state != ContactState::UNKNOWN) return false;
  for (const std::string& name : {state.body_a, state.body_b}) {
    const std::string body = name.substr(0, name.find(':'));
    if (state.reason.rfind(body + ": TF ", 0) == 0) return true;
  }
  return false;
}

}  // namespace

// Collects all problems of the file before it throws.
std::vector<Expectation> readExpectations(const std::string& path) {
  XmlRpc::XmlRpcValue tree;
  tree["expectations"] = readYamlParameters(path);
  std::vector<std::string> problems;
  ParameterReader root(tree, "", &problems);
  std::vector<Expectation> expectations;
  for (ParameterReader& entry : root.structs("expectations")) {
    Expectation e;
    e.link = entry.text("link", "");
    e.object = entry.text("object", "");
    e.touches = static_cast<Expectation::Touches>(
        entry.choice("touches", {"sometime", "always", "never"}, 0));
    e.from_s = entry.number("from_s", 0, 0, kLongestS);
    e.to_s = entry.number("to_s", kLongestS, 0, kLongestS);
    e.min_pairs = static_cast<std::uint32_t>(entry.integer("min_pairs", 1, 1, 1 << 30));
    if (entry.has("keeps_m")) {
      constexpr double kLeastM = 1e-9, kMostM = 1e6;
      e.keeps_m = entry.number("keeps_m", kLeastM, kLeastM, kMostM);
      for (const char* other : {"touches", "min_pairs"}) {
        if (entry.has(other)) entry.addProblem("keeps_m", std::string("excludes ") + other);
      }
    }
    if (e.link.empty() || e.object.empty()) {
      entry.addProblem("link and object", "must both be set");
    }
    if (e.to_s < e.from_s) entry.addProblem("to_s", "is before from_s");
    for (const std::string& name : entry.unknown()) {
      problems.push_back(name + " is not a key of an expectation");
    }
    expectations.push_back(std::move(e));
  }
  if (problems.empty() && expectations.empty()) problems.push_back("the file has no expectation");
  if (problems.empty()) return expectations;
  throw std::runtime_error(path + ": " + joined(problems, "; "));
}

// Suggests the body with the nearest name, because most wrong names are misspelled.
void checkBodies(const std::vector<std::string>& bodies, const std::set<std::string>& links,
                 std::vector<Expectation>* expectations) {
  for (Expectation& expectation : *expectations) {
    for (const std::string& name : {expectation.link, expectation.object}) {
      if (std::find(bodies.begin(), bodies.end(), name) != bodies.end()) continue;
      std::string& problem = expectation.problem;
      if (!problem.empty()) problem += "; ";
      problem += links.count(name) > 0
                     ? "link '" + name + "' has no geometry, or is left out"
                     : "no such body '" + name + "'" + nearestNameHint(name, bodies);
      // A body with itself needs only one message.
      if (expectation.link == expectation.object) break;
    }
  }
}

void checkMargins(const std::function<BodyMargin(const std::string&)>& marginOf, bool near_pairs,
                  std::vector<Expectation>* expectations) {
  for (Expectation& e : *expectations) {
    if (!e.problem.empty()) continue;
    // The monitor keeps margins as float32, and the larger one counts.
    const BodyMargin one = marginOf(e.link), other = marginOf(e.object);
    const double margin_m = std::max(one.margin_m, other.margin_m);
    if (e.keeps_m == 0) {
      if (e.min_pairs > 1 && near_pairs) {
        e.problem =
            "min_pairs: with near_pairs, pairs within the margin count, too; set near_pairs "
            "to false";
      }
    } else if (one.body == other.body) {
      e.problem = "keeps_m: a body has no distance from itself";
    } else if (static_cast<float>(e.keeps_m) > static_cast<float>(margin_m)) {
      e.problem = "keeps_m " + metres(e.keeps_m) + " is above the margin of the two, " +
                  metres(margin_m) + ", beyond which nothing is known; set margin_m";
    }
  }
}

ExpectationJudge::ExpectationJudge(std::vector<Expectation> expectations, double max_age_s)
    : max_age_s_(max_age_s) {
  for (Expectation& expectation : expectations) {
    Record record;
    record.expectation = std::move(expectation);
    records_.push_back(std::move(record));
  }
}

// Returns the time since the first cycle [s]. It never falls: where the clock goes back, it goes on
// from there.
double ExpectationJudge::timeOf(const ros::Time& stamp) {
  constexpr double kJumpS = 1;  // less is cycles that have come out of their order
  if (!started_) start_ = stamp;
  started_ = true;
  if (start_s_ + secondsBetween(stamp, start_) < last_s_ - kJumpS) {
    start_ = stamp;
    start_s_ = last_s_;
  }
  last_s_ = std::max(last_s_, start_s_ + secondsBetween(stamp, start_));
  return last_s_;
}

void ExpectationJudge::look(const ContactStates& states, bool at_edge, bool found_all) {
  const double since_s = timeOf(states.header.stamp);
  bool are_judged = true;
  for (Record& record : records_) {
    const Expectation& e = record.expectation;
    const ContactState* const state = find(states, e);
    const bool is_judged = !at_edge || state == nullptr || !lacksTransform(*state);
    if (state != nullptr && state->stamp == states.header.stamp) {
      lookAtGap(*state, since_s, is_judged, &record);
    }
    if (since_s < e.from_s || since_s > e.to_s) continue;
    are_judged &= is_judged;
    if (is_judged) look(states, since_s, found_all, &record);
  }
  unjudged_ += !are_judged;
}

// A gap counts as one cycle, unless the cycle at its end says UNKNOWN too. Where the clock went
// back, the stamp is not later. Between two cycles that are not judged, the recording has not begun
// or is over. A cycle that says UNKNOWN ends no gap, because it may be another object's.
void ExpectationJudge::lookAtGap(const ContactState& state, double since_s, bool is_judged,
                                 Record* record) const {
  const bool is_gap =
      !record->looked.isZero() && secondsBetween(state.stamp, record->looked) > max_age_s_;
  const bool is_known = state.state != ContactState::UNKNOWN;
  const bool says_so = !is_known && is_judged && since_s <= record->expectation.to_s;
  if (is_gap && !says_so && (is_judged || record->was_judged)) countGap(since_s, record);
  if (!is_known && is_judged) return;
  record->looked = state.stamp;
  record->looked_s = since_s;
  record->was_judged = is_judged;
}

void ExpectationJudge::countGap(double until_s, Record* record) const {
  const Expectation& e = record->expectation;
  const double from_s = std::max(record->looked_s + max_age_s_, e.from_s);
  if (from_s >= std::min(until_s, e.to_s)) return;
  record->is_monitored = true;
  ++record->cycles;
  ++record->unknown;
  if (record->first_break.empty() &&
      (e.keeps_m > 0 || e.touches != Expectation::Touches::kSometime)) {
    record->first_break = "at " + seconds(from_s) + ": UNKNOWN until " + seconds(until_s) +
                          " (no new mesh within max_mesh_age_s)";
  }
}

// Recorders end one topic after the other.
void ExpectationJudge::lookAtEnd(const ros::Time& end, Record* record) const {
  constexpr double kEdgeS = 1;
  if (record->looked.isZero() || !record->was_judged) return;
  if (secondsBetween(end, record->looked) <= max_age_s_ + kEdgeS) return;
  countGap(start_s_ + secondsBetween(end, start_), record);
}

// Counts a cycle for one expectation. `known` says whether the state proves anything.
void ExpectationJudge::look(const ContactStates& states, double since_s, bool found_all,
                            Record* record) const {
  const Expectation& e = record->expectation;
  const ContactState* const state = find(states, e);
  record->is_monitored |= state != nullptr;
  // This cycle did not check the pair.
  if (state != nullptr && state->stamp != states.header.stamp) return;
  if (e.keeps_m > 0) return lookAtDistance(state, states.tolerance, since_s, record);
  // These states prove whether the two touch; the others prove nothing.
  bool known = state != nullptr &&
               (state->state == ContactState::NONE || state->state == ContactState::NEAR ||
                state->state == ContactState::CONTACT || state->state == ContactState::PASSED);
  const bool always = e.touches == Expectation::Touches::kAlways;
  // A pair that has PASSED touched after its previous cycle, but not at this cycle's stamp.
  const bool touched = known && (state->state == ContactState::CONTACT ||
                                 (state->state == ContactState::PASSED && !always));
  // A contact may have no pairs: one body lies within the other, or none of them was listed.
  const bool touching =
      touched && (state->inside != 0 || e.min_pairs == 1 || state->pair_count >= e.min_pairs);
  if (touched && !touching && (states.tolerance > 0 || !found_all)) known = false;
  ++record->cycles;
  record->touching += touching;
  record->unknown += !known;
  if (touched) {
    record->most_pairs = std::max(record->most_pairs, state->pair_count);
  }
  if (record->first_break.empty() && e.touches != Expectation::Touches::kSometime &&
      (!known || touching != always)) {
    record->first_break = "at " + seconds(since_s) + ": " + seen(state);
  }
}

// The margin of the two is at least keeps_m (see checkMargins()), so NONE is far enough. Compares
// in float32, as distances are published.
void ExpectationJudge::lookAtDistance(const ContactState* state, double tolerance_m, double since_s,
                                      Record* record) {
  ++record->cycles;
  const bool is_apart = state != nullptr &&
                        (state->state == ContactState::NONE || state->state == ContactState::NEAR);
  const bool touches = state != nullptr && (state->state == ContactState::CONTACT ||
                                            state->state == ContactState::PASSED);
  record->unknown += !is_apart && !touches;
  double distance_m = touches ? 0 : std::numeric_limits<double>::infinity();
  bool keeps = is_apart;
  if (is_apart && state->state == ContactState::NEAR) {
    distance_m = tolerance_m > 0 ? certainDistance(*state, tolerance_m) : state->min_separation;
    keeps = static_cast<float>(distance_m) >= static_cast<float>(record->expectation.keeps_m);
  }
  if (distance_m < record->least_m) {
    record->least_m = distance_m;
    record->least_at_s = since_s;
  }
  if (keeps || !record->first_break.empty()) return;
  record->first_break = "at " + seconds(since_s) + ": ";
  if (is_apart) {
    record->first_break += "NEAR, " + metres(distance_m);
    if (tolerance_m > 0) record->first_break += " or more";
  } else {
    record->first_break += seen(state);
  }
}

// An expectation that can never hold fails first, then one without any cycle, then by its counts.
std::vector<ExpectationJudge::Verdict> ExpectationJudge::verdicts(const ros::Time& end) const {
  std::vector<Verdict> verdicts;
  for (Record record : records_) {
    lookAtEnd(end, &record);
    Verdict verdict{describe(record.expectation), ""};
    if (!record.expectation.problem.empty()) {
      verdict.failure = record.expectation.problem;
    } else if (record.cycles > 0 && !record.is_monitored) {
      verdict.failure = "not monitored: no pair class that is on has these two";
    } else if (record.cycles == 0) {
      verdict.failure = "no cycle in that time";
    } else if (record.expectation.keeps_m > 0) {
      verdict.failure = record.first_break;
      if (!record.first_break.empty() && std::isfinite(record.least_m)) {
        verdict.failure +=
            "; least " + metres(record.least_m) + " at " + seconds(record.least_at_s);
      }
    } else if (record.expectation.touches != Expectation::Touches::kSometime) {
      verdict.failure = record.first_break;
    } else if (record.touching == 0) {
      verdict.failure = "not once in " + std::to_string(record.cycles) + " cycles, " +
                        std::to_string(record.unknown) + " of them unknown, most pairs " +
                        std::to_string(record.most_pairs);
    }
    verdicts.push_back(std::move(verdict));
  }
  return verdicts;
}

}  // namespace deformable_contact_monitor
