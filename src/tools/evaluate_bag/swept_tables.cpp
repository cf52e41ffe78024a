// The tables of events, and of what touches between the cycles, that an evaluation writes while it
// goes.
#include "tools/evaluate_bag/swept_tables.h"

#include <cstdio>

#include "tools/bags/stamp_text.h"
#include "tools/common/csv_field.h"

namespace deformable_contact_monitor {
namespace {

// With the digits that give back the float32.
std::string numberField(float value) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.9g", value);
  return text;
}

const char* nameOf(std::uint8_t type) {
  constexpr const char* kNames[] = {"BEGIN", "END", "PASSED"};
  return kNames[type];
}

}  // namespace

SweptPairsTable::SweptPairsTable(const std::string& folder) : file_(folder + "/swept_pairs.csv") {
  file_.line(
      "cycle,stamp,from,body_a,triangle_a,body_b,triangle_b,first_low,first_high,within_pad");
}

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

void EventsTable::add(const CycleReport& cycle, const EvaluationRun& run) {
  for (const ContactEvent& event : run.steps.events()) {
    const bool passed = event.type == ContactEvent::PASSED;
    file_.line(csvField(run.name()) + "," + stampText(event.header.stamp) + "," +
               csvField(event.body_a) + "," + csvField(event.body_b) + "," + nameOf(event.type) +
               "," + std::to_string(event.pair_count) + "," +
               (passed ? stampText(run.steps.beginningOf(cycle, event)) : "") +
               (passed ? numberField(event.first_low) : ",") + "," + csvField(event.reason));
  }
}

}  // namespace deformable_contact_monitor
