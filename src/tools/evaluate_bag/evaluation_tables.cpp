// Writes the tables of an evaluation, row by row.
#include "tools/evaluate_bag/evaluation_tables.h"

#include <algorithm>

#include "monitor/time_difference.h"
#include "tools/bags/bag_contents.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"

namespace deformable_contact_monitor {
namespace {

std::string milliseconds(double ms) { return formatted("%.4f", ms); }

const char* yesOrNo(bool yes) { return yes ? "yes" : "no"; }

// Returns the first few bodies that were left out, and why. links.csv has all of them.
std::string skipped(const CycleReport& cycle) {
  constexpr std::size_t kShown = 2;
  std::string text;
  std::size_t count = 0;
  for (const BodyStatus& body : cycle.bodies) {
    if (body.unknown_because.empty() || ++count > kShown) continue;
    text += (text.empty() ? "" : "; ") + body.name + ": " + body.unknown_because;
  }
  return count > kShown ? text + "; and " + std::to_string(count - kShown) + " more" : text;
}

// Returns the names of the objects that triggered the cycle.
std::string objects(const CycleReport& cycle) {
  std::string text;
  for (const BodyStatus& body : cycle.bodies) {
    if (body.kind != BodyKind::kDeformable || body.stamp != cycle.header.stamp) continue;
    text += (text.empty() ? "" : " ") + body.name;
  }
  return text;
}

// Returns a field with enough digits to restore the float32 exactly.
std::string number(float value) { return formatted("%.9g", value); }

// Returns the fields of a pair of triangles.
std::string pairRow(const CycleReport& cycle, const TrianglePair& pair) {
  return csvRow(cycle.bodies[pair.body_a].name, pair.triangle_a, cycle.bodies[pair.body_b].name,
                pair.triangle_b);
}

// Returns the fields that say which cycle it is.
std::string cycleRow(const CycleReport& cycle) {
  return csvRow(cycle.cycle, stampText(cycle.header.stamp));
}

}  // namespace

EvaluationTables::EvaluationTables(const std::string& folder, bool with_pairs, bool swept,
                                   double max_age_s)
    : max_age_s_(max_age_s),
      frames_(folder + "/frames.csv"),
      links_(folder + "/links.csv"),
      events_(folder + "/events.csv"),
      distances_(folder + "/distances.csv") {
  links_.line("run,body_a,body_b,state,from,to,cycles,least_pairs,most_pairs,from_s,to_s");
  events_.line("run,stamp,body_a,body_b,type,pairs,from,first_low,reason");
  distances_.line(
      "cycle,stamp,run,body_a,body_b,state,distance,distance_low,ax,ay,az,bx,by,bz,nx,ny,nz");
  if (!with_pairs) return;
  pairs_.emplace(folder + "/pairs.csv");
  pairs_->line("cycle,stamp,body_a,triangle_a,body_b,triangle_b");
  if (!swept) return;
  swept_pairs_.emplace(folder + "/swept_pairs.csv");
  swept_pairs_->line(
      "cycle,stamp,from,body_a,triangle_a,body_b,triangle_b,first_low,first_high,within_pad");
}

void EvaluationTables::add(const CycleReport& cycle, const Runs& runs,
                           const std::vector<bool>& differing) {
  if (!titled_) {
    start_ = cycle.header.stamp;
    writeFrameTitle(runs, cycle.motion == Motion::kSwept);
  }
  titled_ = true;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    addFrame(cycle, *runs[i], differing[i]);
    addLinks(i, *runs[i]);
    addEvents(cycle, *runs[i]);
    addDistances(cycle, *runs[i]);
  }
  if (pairs_) addPairs(cycle, *runs[0]->result);
  if (swept_pairs_) addSweptPairs(cycle, runs[0]->steps);
}

void EvaluationTables::finish() {
  // Sequences that last until the end of the bag are still open.
  for (const auto& [key, stretch] : open_) writeLink(key, stretch);
  for (TableFile* table : {&frames_, &links_, &events_, &distances_}) table->finish();
  if (pairs_) pairs_->finish();
  if (swept_pairs_) swept_pairs_->finish();
}

// Stages differ between backends, so the title has those of all runs in their first cycle.
void EvaluationTables::writeFrameTitle(const Runs& runs, bool swept) {
  std::string title =
      "cycle,stamp,objects,run,backend,triangles,rejected,pairs,undecided,complete,differs,skipped,"
      "detect_ms,round_trip_ms";
  for (const auto& run : runs) {
    for (const auto& [name, ms] : run->stages_ms) {
      if (std::find(stages_.begin(), stages_.end(), name) != stages_.end()) continue;
      stages_.push_back(name);
      title += "," + name + "_ms";
    }
  }
  frames_.line(title + ",other_ms" + (swept ? ",swept_pairs,swept_complete,swept_ms" : ""));
}

// A stage that runs twice in a cycle counts with its sum.
void EvaluationTables::addFrame(const CycleReport& cycle, const EvaluationRun& run, bool differs) {
  const DetectionResult& result = *run.result;
  std::string row =
      csvRow(cycle.cycle, stampText(cycle.header.stamp), objects(cycle), run.name(),
             run.detector->backend(), result.counters.triangles, result.counters.rejected,
             result.contacts.size() + result.left_out, result.counters.undecided,
             yesOrNo(isComplete(cycle, result)), yesOrNo(differs), skipped(cycle),
             milliseconds(result.detect_ms), milliseconds(result.round_trip_ms));
  // Time in stages that the title does not have goes to other_ms.
  double other_ms = 0;
  for (const std::string& stage : stages_) {
    double ms = 0;
    for (const auto& [name, took_ms] : result.stages_ms) ms += name == stage ? took_ms : 0;
    row += "," + milliseconds(ms);
    other_ms -= ms;
  }
  for (const auto& [name, took_ms] : result.stages_ms) other_ms += took_ms;
  row += "," + milliseconds(std::max(other_ms, 0.0));
  if (cycle.motion == Motion::kSwept) {
    row += "," + csvRow(run.steps.pairsOfCycle(), yesOrNo(run.steps.isCycleComplete(cycle)),
                        milliseconds(run.steps.msOfCycle()));
  }
  frames_.line(row);
}

// Extends the open sequence of each pair of bodies, or ends it if the state changed. Where no cycle
// checked the pair for longer than a state holds, it was UNKNOWN, which needs a row of its own
// unless the state is UNKNOWN before or after. What is ALLOWED stays so.
void EvaluationTables::addLinks(std::size_t number, const EvaluationRun& run) {
  if (runs_.size() <= number) runs_.resize(number + 1);
  runs_[number] = run.name();
  const ros::Time& stamp = run.states.header.stamp;
  for (const ContactState& state : run.states.states) {
    if (state.stamp != stamp) continue;  // the cycle did not check this pair
    const StretchKey key{number, {state.body_a, state.body_b}};
    const auto found = open_.find(key);
    if (found != open_.end() && found->second.state != ContactState::UNKNOWN &&
        found->second.state != ContactState::ALLOWED && state.state != ContactState::UNKNOWN &&
        secondsBetween(stamp, found->second.to) > max_age_s_) {
      writeLink(key, found->second);
      const ros::Time from = found->second.to + toDuration(max_age_s_);
      found->second = {ContactState::UNKNOWN, from, stamp, 0, 0, 0};
    }
    // A sequence also ends where the clock goes back.
    if (found != open_.end() && found->second.state == state.state && found->second.to <= stamp) {
      Stretch& stretch = found->second;
      stretch.to = stamp;
      ++stretch.cycles;
      stretch.least = std::min(stretch.least, state.pair_count);
      stretch.most = std::max(stretch.most, state.pair_count);
      continue;
    }
    if (found != open_.end()) writeLink(key, found->second);
    open_[key] = {state.state, stamp, stamp, 1, state.pair_count, state.pair_count};
  }
}

void EvaluationTables::writeLink(const StretchKey& key, const Stretch& stretch) {
  links_.line(csvRow(runs_[key.first], key.second.first, key.second.second,
                     kStateNames[stretch.state], stampText(stretch.from), stampText(stretch.to),
                     stretch.cycles, stretch.least, stretch.most, sinceStart(stretch.from),
                     sinceStart(stretch.to)));
}

std::string EvaluationTables::sinceStart(const ros::Time& time) const {
  return formatted("%.9f", secondsBetween(time, start_));
}

// The distance of a pair that touches is 0, whatever its depth is. An UNKNOWN pair has no numbers,
// but for a lower bound that is certain all the same. Points and normal are there where the state
// has them.
void EvaluationTables::addDistances(const CycleReport& cycle, const EvaluationRun& run) {
  for (const ContactState& state : run.states.states) {
    if (state.stamp != run.states.header.stamp || state.body_a == state.body_b) continue;
    const bool has_points =
        state.state == ContactState::NEAR || state.state == ContactState::CONTACT;
    const bool has_distance = has_points || state.state == ContactState::PASSED;
    if (!has_distance && state.state != ContactState::UNKNOWN) continue;
    std::string row = cycleRow(cycle) + "," +
                      csvRow(run.name(), state.body_a, state.body_b, kStateNames[state.state],
                             has_distance ? number(std::max(state.min_separation, 0.0F)) : "",
                             number(state.distance_low));
    for (const auto* v : {&state.point_a, &state.point_b, &state.normal}) {
      for (const float value : {v->x, v->y, v->z}) row += "," + (has_points ? number(value) : "");
    }
    distances_.line(row);
  }
}

void EvaluationTables::addPairs(const CycleReport& cycle, const DetectionResult& result) {
  const std::string start = cycleRow(cycle) + ",";
  for (const TrianglePair& pair : result.contacts) pairs_->line(start + pairRow(cycle, pair));
}

// An interval without a result, such as that of an object's first mesh, has no rows.
void EvaluationTables::addSweptPairs(const CycleReport& cycle, const RunSteps& steps) {
  for (const SweepReport& sweep : steps.sweeps()) {
    if (sweep.result == nullptr) continue;
    const DetectionResult& result = sweep.result->detection;
    const std::string start = cycleRow(cycle) + "," + stampText(sweep.from) + ",";
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      const FirstContact& first = result.first_times[i];
      const bool pad = !result.within_pad.empty() && result.within_pad[i] != 0;
      swept_pairs_->line(start + pairRow(cycle, result.contacts[i]) + "," +
                         csvRow(number(first.low), number(first.high), yesOrNo(pad)));
    }
  }
}

// Only PASSED events have a time interval, so `from` and `first_low` are empty for the others.
void EvaluationTables::addEvents(const CycleReport& cycle, const EvaluationRun& run) {
  constexpr const char* kNames[] = {"BEGIN", "END", "PASSED"};  // in the order of the constants
  for (const ContactEvent& event : run.steps.events()) {
    const bool passed = event.type == ContactEvent::PASSED;
    events_.line(csvRow(run.name(), stampText(event.header.stamp), event.body_a, event.body_b,
                        kNames[event.type], event.pair_count,
                        passed ? stampText(run.steps.beginningOf(cycle, event)) : "",
                        passed ? number(event.first_low) : "", event.reason));
  }
}

}  // namespace deformable_contact_monitor
