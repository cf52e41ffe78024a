// The steps of a cycle as messages.
#include "monitor/messages/swept_messages.h"

#include <ros/serialization.h>

#include <algorithm>
#include <string>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Why the body is not in the step; empty: it is, or need not be.
std::string whyNot(const CycleReport& report, const SweepReport& sweep, BodyId id) {
  const std::string& unknown = report.bodies[id].unknown_because;
  if (!unknown.empty()) return unknown;
  if (!sweep.bodies[id].skipped.empty()) return sweep.bodies[id].skipped;
  const bool has_result = sweep.from.isZero() || sweep.result != nullptr;
  if (has_result || !sweep.bodies[id].takes_part) return "";
  return sweep.problem.empty() ? "no detection ran" : "the detection failed: " + sweep.problem;
}

void addBodies(const CycleReport& report, const SweepReport& sweep, SweptContacts* message) {
  for (BodyId id = 0; id < report.bodies.size(); ++id) {
    const StepBody& body = sweep.bodies[id];
    const bool takes_part = body.takes_part && body.skipped.empty();
    message->bodies.push_back(report.bodies[id].name);
    message->topology_ids.push_back(takes_part ? report.bodies[id].topology_id : 0);
    const std::string why_not = whyNot(report, sweep, id);
    if (!why_not.empty()) message->skipped.push_back(report.bodies[id].name + ": " + why_not);
  }
}

void addPairs(const StepResult& step, std::size_t most, SweptContacts* message) {
  const DetectionResult& result = step.detection;
  const std::size_t total = result.contacts.size();
  const std::size_t kept = std::min(total, most);
  message->pairs.reserve(kept);
  for (std::size_t i = 0; i < kept; ++i) {
    message->pairs.push_back(toContactPair(result.contacts[i]));
    message->first_low.push_back(result.first_times[i].low);
    message->first_high.push_back(result.first_times[i].high);
  }
  if (step.pad_m > 0) {
    message->within_pad.assign(result.within_pad.begin(),
                               result.within_pad.begin() + static_cast<std::ptrdiff_t>(kept));
  }
  message->pair_count = total + result.left_out;
  message->truncated = kept < message->pair_count;
}

}  // namespace

SweptContacts toSweptContacts(const CycleReport& report, const SweepReport& sweep,
                              std::size_t max_contacts, std::uint64_t most_bytes) {
  SweptContacts message;
  message.header = report.header;
  message.cycle = report.cycle;
  message.from_stamp = sweep.from;
  addBodies(report, sweep, &message);
  message.backend = report.backend;
  message.predicates = toString(report.options.predicates);
  message.age = toDuration(secondsBetween(report.now, report.header.stamp));
  if (sweep.result == nullptr) return message;
  const DetectionResult& result = sweep.result->detection;
  using ros::serialization::serializationLength;
  const std::size_t pair_bytes = serializationLength(ContactPair()) + 2 * sizeof(float) + 1;
  const std::size_t room = mostPairs(most_bytes, serializationLength(message), pair_bytes);
  addPairs(*sweep.result, max_contacts == 0 ? room : std::min(max_contacts, room), &message);
  message.pad = sweep.result->pad_m;
  message.timed_out = result.isOutOfTime();
  message.undecided = saturated(result.counters.undecided);
  message.rejected_triangles = saturated(result.counters.rejected);
  message.compute_time = ros::Duration(result.round_trip_ms / 1e3);
  message.complete = result.guaranteed && message.skipped.empty() &&
                     result.counters.rejected == 0 && !message.truncated && !result.cut_off;
  return message;
}

}  // namespace deformable_contact_monitor
