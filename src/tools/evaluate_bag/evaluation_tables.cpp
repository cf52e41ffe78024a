// Writes the tables of an evaluation, row by row.
#include "tools/evaluate_bag/evaluation_tables.h"

#include <algorithm>
#include <cstdio>

#include "tools/bags/bag_contents.h"
#include "tools/common/reports.h"

namespace deformable_contact_monitor {
namespace {

// Returns a field with a time.
std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.4f", ms);
  return text;
}

// The names are in the order of ContactState's constants.
const char* stateName(std::uint8_t state) {
  constexpr const char* kNames[] = {"NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED"};
  return kNames[state];
}

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
std::string numberField(float value) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.9g", value);
  return text;
}

// The names are in the order of ContactEvent's constants.
const char* eventName(std::uint8_t type) {
  constexpr const char* kNames[] = {"BEGIN", "END", "PASSED"};
  return kNames[type];
}

}  // namespace

// Stages differ between backends, so the title has those of all runs in their first cycle.
void FramesTable::writeTitle(const std::vector<std::unique_ptr<EvaluationRun>>& runs, bool swept) {
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
  file_.line(title + ",other_ms" + (swept ? ",swept_pairs,swept_complete,swept_ms" : ""));
}

// Writes one row for each run. A stage that runs twice in a cycle counts with its sum.
void FramesTable::add(const CycleReport& cycle,
                      const std::vector<std::unique_ptr<EvaluationRun>>& runs,
                      const std::vector<bool>& differing) {
  const bool swept = cycle.motion == Motion::kSwept;
  if (!titled_) writeTitle(runs, swept);
  titled_ = true;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const EvaluationRun& run = *runs[i];
    const DetectionResult& result = *run.result;
    std::string row = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) + "," +
                      csvField(objects(cycle)) + "," + csvField(run.name()) + "," +
                      run.source->backend() + "," + std::to_string(result.counters.triangles) +
                      "," + std::to_string(result.counters.rejected) + "," +
                      std::to_string(result.contacts.size() + result.left_out) + "," +
                      std::to_string(result.counters.undecided) + "," +
                      (isComplete(cycle, result) ? "yes" : "no") + "," +
                      (differing[i] ? "yes" : "no") + "," + csvField(skipped(cycle)) +
                      milliseconds(result.detect_ms) + milliseconds(result.round_trip_ms);
    // Time in stages that the title does not have goes to other_ms.
    double other_ms = 0;
    for (const std::string& stage : stages_) {
      double ms = 0;
      for (const auto& [name, took_ms] : result.stages_ms) ms += name == stage ? took_ms : 0;
      row += milliseconds(ms);
      other_ms -= ms;
    }
    for (const auto& [name, took_ms] : result.stages_ms) other_ms += took_ms;
    row += milliseconds(std::max(other_ms, 0.0));
    if (swept) {
      row += "," + std::to_string(run.steps.pairsOfCycle()) +
             (run.steps.isCycleComplete(cycle) ? ",yes" : ",no") +
             milliseconds(run.steps.msOfCycle());
    }
    file_.line(row);
  }
}

LinksTable::LinksTable(const std::string& folder) : file_(folder + "/links.csv") {
  file_.line("run,body_a,body_b,state,from,to,cycles,least_pairs,most_pairs");
}

// Extends the open sequence of each pair of bodies, or ends it if the state changed.
void LinksTable::add(std::size_t run, const EvaluationRun& of) {
  if (runs_.size() <= run) runs_.resize(run + 1);
  runs_[run] = of.name();
  const ros::Time& stamp = of.states.header.stamp;
  for (const ContactState& state : of.states.states) {
    if (state.stamp != stamp) continue;  // the cycle did not check this pair
    const Key key{run, {state.body_a, state.body_b}};
    const auto found = open_.find(key);
    // A sequence also ends where the clock goes back.
    if (found != open_.end() && found->second.state == state.state && found->second.to <= stamp) {
      Stretch& stretch = found->second;
      stretch.to = stamp;
      ++stretch.cycles;
      stretch.least = std::min(stretch.least, state.pair_count);
      stretch.most = std::max(stretch.most, state.pair_count);
      continue;
    }
    if (found != open_.end()) write(key, found->second);
    open_[key] = {state.state, stamp, stamp, 1, state.pair_count, state.pair_count};
  }
}

void LinksTable::write(const Key& key, const Stretch& stretch) {
  file_.line(csvField(runs_[key.first]) + "," + csvField(key.second.first) + "," +
             csvField(key.second.second) + "," + stateName(stretch.state) + "," +
             stampText(stretch.from) + "," + stampText(stretch.to) + "," +
             std::to_string(stretch.cycles) + "," + std::to_string(stretch.least) + "," +
             std::to_string(stretch.most));
}

void LinksTable::finish() {
  // Sequences that last until the end of the bag are still open.
  for (const auto& [key, stretch] : open_) write(key, stretch);
  open_.clear();
  file_.finish();
}

DistancesTable::DistancesTable(const std::string& folder) : file_(folder + "/distances.csv") {
  file_.line(
      "cycle,stamp,run,body_a,body_b,state,distance,distance_low,ax,ay,az,bx,by,bz,nx,ny,nz");
}

// The distance of a pair that touches is 0, whatever its depth is. An UNKNOWN pair has no numbers,
// but for a lower bound that is certain all the same. Points and normal are there where the state
// has them.
void DistancesTable::add(const CycleReport& cycle, const EvaluationRun& run) {
  const std::string start = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) +
                            "," + csvField(run.name()) + ",";
  for (const ContactState& state : run.states.states) {
    if (state.stamp != run.states.header.stamp || state.body_a == state.body_b) continue;
    const bool has_points =
        state.state == ContactState::NEAR || state.state == ContactState::CONTACT;
    const bool has_distance = has_points || state.state == ContactState::PASSED;
    if (!has_distance && state.state != ContactState::UNKNOWN) continue;
    std::string row = start + csvField(state.body_a) + "," + csvField(state.body_b) + "," +
                      stateName(state.state);
    row += has_distance ? numberField(std::max(state.min_separation, 0.0F)) : ",";
    row += numberField(state.distance_low);
    for (const auto* v : {&state.point_a, &state.point_b, &state.normal}) {
      for (const float number : {v->x, v->y, v->z}) row += has_points ? numberField(number) : ",";
    }
    file_.line(row);
  }
}

PairsTable::PairsTable(const std::string& folder) : file_(folder + "/pairs.csv") {
  file_.line("cycle,stamp,body_a,triangle_a,body_b,triangle_b");
}

void PairsTable::add(const CycleReport& cycle, const DetectionResult& result) {
  const std::string start = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) + ",";
  for (const TrianglePair& pair : result.contacts) {
    file_.line(start + csvField(cycle.bodies[pair.body_a].name) + "," +
               std::to_string(pair.triangle_a) + "," + csvField(cycle.bodies[pair.body_b].name) +
               "," + std::to_string(pair.triangle_b));
  }
}

SweptPairsTable::SweptPairsTable(const std::string& folder) : file_(folder + "/swept_pairs.csv") {
  file_.line(
      "cycle,stamp,from,body_a,triangle_a,body_b,triangle_b,first_low,first_high,within_pad");
}

// An interval without a result, such as that of an object's first mesh, has no rows.
void SweptPairsTable::add(const CycleReport& cycle, const RunSteps& steps) {
  for (const SweepReport& sweep : steps.sweeps()) {
    if (sweep.result == nullptr) continue;
    const DetectionResult& result = sweep.result->detection;
    const std::string start = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) +
                              "," + stampText(sweep.from) + ",";
    for (std::size_t i = 0; i < result.contacts.size(); ++i) {
      const TrianglePair& pair = result.contacts[i];
      const FirstContact& first = result.first_times[i];
      const bool pad = !result.within_pad.empty() && result.within_pad[i] != 0;
      file_.line(start + csvField(cycle.bodies[pair.body_a].name) + "," +
                 std::to_string(pair.triangle_a) + "," + csvField(cycle.bodies[pair.body_b].name) +
                 "," + std::to_string(pair.triangle_b) + numberField(first.low) +
                 numberField(first.high) + (pad ? ",yes" : ",no"));
    }
  }
}

EventsTable::EventsTable(const std::string& folder) : file_(folder + "/events.csv") {
  file_.line("run,stamp,body_a,body_b,type,pairs,from,first_low,reason");
}

// Only PASSED events have a time interval, so `from` and `first_low` are empty for the others.
void EventsTable::add(const CycleReport& cycle, const EvaluationRun& run) {
  for (const ContactEvent& event : run.steps.events()) {
    const bool passed = event.type == ContactEvent::PASSED;
    file_.line(csvField(run.name()) + "," + stampText(event.header.stamp) + "," +
               csvField(event.body_a) + "," + csvField(event.body_b) + "," + eventName(event.type) +
               "," + std::to_string(event.pair_count) + "," +
               (passed ? stampText(run.steps.beginningOf(cycle, event)) : "") +
               (passed ? numberField(event.first_low) : ",") + "," + csvField(event.reason));
  }
}

}  // namespace deformable_contact_monitor
