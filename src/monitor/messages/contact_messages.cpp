// Converts what the monitor computes to messages, and link meshes back.
//
// ContactArray and SweptContacts share many fields of the same names. The templates below fill
// those, so that both messages mean the same by them.
#include "monitor/messages/contact_messages.h"

#include <ros/serialization.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "core/triangle_mesh.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

using ros::serialization::serializationLength;

ContactPair toContactPair(const TrianglePair& pair) {
  ContactPair message;
  message.body_a = pair.body_a;
  message.triangle_a = pair.triangle_a;
  message.body_b = pair.body_b;
  message.triangle_b = pair.triangle_b;
  return message;
}

NearestTriangles toNearestTriangles(const NearestPair& nearest) {
  NearestTriangles message;
  message.body_a = nearest.pair.body_a;
  message.triangle_a = nearest.pair.triangle_a;
  message.body_b = nearest.pair.body_b;
  message.triangle_b = nearest.pair.triangle_b;
  message.distance = nearest.distance_m;
  message.point_a = toPoint32(nearest.point_a);
  message.point_b = toPoint32(nearest.point_b);
  return message;
}

ContactGeometry toContactGeometry(const PairGeometry& geometry) {
  ContactGeometry message;
  message.point_a = toPoint32(geometry.point_a);
  message.point_b = toPoint32(geometry.point_b);
  message.normal = toPoint32(geometry.normal);
  message.separation = geometry.separation_m;
  message.flags = geometry.flags;
  return message;
}

// Fills what is known before a detection.
template <class Message>
void fillCycle(const CycleReport& report, Message* message) {
  message->header = report.header;
  message->cycle = report.cycle;
  message->backend = report.backend;
  message->predicates = toString(report.options.predicates);
  message->age = toDuration(secondsBetween(report.now, report.header.stamp));
}

// Fills `pairs` and says how many are left out. All other fields of variable length except those
// with an entry per pair must be filled already, because their size counts.
template <class Message>
void fillPairs(const DetectionResult& result, std::size_t pair_bytes, std::size_t max_contacts,
               std::uint64_t most_bytes, Message* message) {
  const std::size_t total = result.contacts.size();
  const std::size_t room = mostPairs(most_bytes, serializationLength(*message), pair_bytes);
  const std::size_t kept = std::min({total, room, max_contacts == 0 ? room : max_contacts});
  message->pairs.resize(kept);
  for (std::size_t i = 0; i < kept; ++i) message->pairs[i] = toContactPair(result.contacts[i]);
  message->pair_count = total + result.left_out;
  message->truncated = kept < message->pair_count;
}

// Fills how the detection went. Must come after fillPairs(), on which `complete` depends.
template <class Message>
void fillOutcome(const DetectionResult& result, Message* message) {
  message->timed_out = result.isOutOfTime();
  message->undecided = saturated(result.counters.undecided);
  message->rejected_triangles = saturated(result.counters.rejected);
  message->compute_time = ros::Duration(result.round_trip_ms / 1e3);
  message->complete = result.guaranteed && message->skipped.empty() &&
                      result.counters.rejected == 0 && !message->truncated && !result.cut_off;
}

std::uint8_t kindOf(const BodyStatus& body) {
  if (body.kind == BodyKind::kLink) return ContactArray::LINK;
  return body.kind == BodyKind::kRigid ? ContactArray::RIGID : ContactArray::DEFORMABLE;
}

// Fills the fields with one entry per body, and `skipped`.
void addBodies(const CycleReport& report, ContactArray* message) {
  for (const BodyStatus& body : report.bodies) {
    message->bodies.push_back(body.name);
    message->body_kind.push_back(kindOf(body));
    message->triggered.push_back(body.triggered);
    message->body_stamps.push_back(body.stamp);
    message->topology_ids.push_back(body.topology_id);
    if (!body.unknown_because.empty()) {
      message->skipped.push_back(body.name + ": " + body.unknown_because);
    }
  }
}

// Returns why the body takes no part in the time interval; empty if it does or need not.
std::string whyNot(const CycleReport& report, const SweepReport& sweep, BodyId id) {
  const std::string& unknown = report.bodies[id].unknown_because;
  if (!unknown.empty()) return unknown;
  if (!sweep.bodies[id].skipped.empty()) return sweep.bodies[id].skipped;
  const bool has_result = sweep.from.isZero() || sweep.result != nullptr;
  if (has_result || !sweep.bodies[id].takes_part) return "";
  return sweep.problem.empty() ? "no detection ran" : "the detection failed: " + sweep.problem;
}

// Fills the fields with one entry per body, and `skipped`. A body that takes no part has topology
// 0.
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

// Returns why a received link mesh cannot be used; empty if it can.
std::string problemOf(const LinkMesh& link, const TriangleMesh& mesh, bool seen_before) {
  if (seen_before) return "link '" + link.link + "' was sent twice in one message";
  try {
    validate(mesh, "link '" + link.link + "'");
  } catch (const std::exception& error) {
    return error.what();
  }
  if (mesh.triangleCount() > 0) return "";
  return "link '" + link.link + "' was sent without triangles" +
         (link.source.empty() ? "" : " (" + link.source + ")");
}

}  // namespace

std::uint32_t saturated(std::uint64_t count) {
  constexpr std::uint32_t kMost = std::numeric_limits<std::uint32_t>::max();
  return count < kMost ? static_cast<std::uint32_t>(count) : kMost;
}

std::size_t mostPairs(std::uint64_t most_bytes, std::uint64_t other_bytes,
                      std::uint64_t pair_bytes) {
  return other_bytes < most_bytes ? (most_bytes - other_bytes) / pair_bytes : 0;
}

ContactArray toContactArray(const CycleReport& report, std::size_t max_contacts,
                            std::uint64_t most_bytes) {
  ContactArray message;
  fillCycle(report, &message);
  addBodies(report, &message);
  message.overlap = report.options.overlap;
  message.tolerance = report.options.tolerance_m;
  if (report.result == nullptr) return message;
  const DetectionResult& result = *report.result;
  message.nearest.reserve(result.nearest.size());
  for (const NearestPair& nearest : result.nearest) {
    message.nearest.push_back(toNearestTriangles(nearest));
  }
  const bool geometry = hasGeometry(report);
  const std::size_t pair_bytes =
      serializationLength(ContactPair()) + (geometry ? serializationLength(ContactGeometry()) : 0);
  fillPairs(result, pair_bytes, max_contacts, most_bytes, &message);
  if (geometry) {
    message.geometry.reserve(message.pairs.size());
    for (std::size_t i = 0; i < message.pairs.size(); ++i) {
      message.geometry.push_back(toContactGeometry(result.geometry[i]));
    }
  }
  message.guaranteed = result.guaranteed;
  fillOutcome(result, &message);
  return message;
}

SweptContacts toSweptContacts(const CycleReport& report, const SweepReport& sweep,
                              std::size_t max_contacts, std::uint64_t most_bytes) {
  SweptContacts message;
  fillCycle(report, &message);
  message.from_stamp = sweep.from;
  addBodies(report, sweep, &message);
  if (sweep.result == nullptr) return message;
  const DetectionResult& result = sweep.result->detection;
  // Each pair takes two times (first_low, first_high) and a flag (within_pad).
  const std::size_t pair_bytes = serializationLength(ContactPair()) + 2 * sizeof(float) + 1;
  fillPairs(result, pair_bytes, max_contacts, most_bytes, &message);
  const auto kept = static_cast<std::ptrdiff_t>(message.pairs.size());
  for (std::ptrdiff_t i = 0; i < kept; ++i) {
    message.first_low.push_back(result.first_times[i].low);
    message.first_high.push_back(result.first_times[i].high);
  }
  message.pad = sweep.result->pad_m;
  if (message.pad > 0) {
    message.within_pad.assign(result.within_pad.begin(), result.within_pad.begin() + kept);
  }
  fillOutcome(result, &message);
  return message;
}

ContactPatches toContactPatches(const CycleReport& report, const std::vector<Patch>& patches) {
  ContactPatches message;
  message.header = report.header;
  message.cycle = report.cycle;
  message.patches.reserve(patches.size());
  for (const Patch& patch : patches) {
    ContactPatch out;
    out.stamp = report.header.stamp;
    out.body_a = report.bodies.at(patch.body_a).name;
    out.body_b = report.bodies.at(patch.body_b).name;
    out.id = patch.id;
    out.pair_count = saturated(patch.pair_count);
    out.triangles_a = patch.triangles_a;
    out.triangles_b = patch.triangles_b;
    out.centroid = toPoint32(patch.centroid);
    out.normal = toPoint32(patch.normal);
    out.normal_spread = static_cast<float>(patch.normal_spread_rad);
    out.curve_length = static_cast<float>(patch.curve_length_m);
    out.area_a = static_cast<float>(patch.area_a_m2);
    out.area_b = static_cast<float>(patch.area_b_m2);
    out.min_separation = static_cast<float>(patch.min_separation_m);
    message.patches.push_back(std::move(out));
  }
  return message;
}

LinkMeshes toLinkMeshes(const RobotGeometry& geometry, const ros::Time& stamp) {
  LinkMeshes message;
  message.header.stamp = stamp;
  message.meshes.reserve(geometry.links.size());
  for (const LinkGeometry& link : geometry.links) {
    LinkMesh mesh;
    mesh.link = link.link;
    mesh.source = link.problem.empty() ? link.source : link.problem;
    if (link.problem.empty()) {
      mesh.vertices = link.mesh.vertices;
      mesh.triangles = link.mesh.triangles;
    }
    message.meshes.push_back(std::move(mesh));
  }
  return message;
}

// Keeps bad links, so that their pairs are UNKNOWN rather than missing.
RobotGeometry fromLinkMeshes(const LinkMeshes& message) {
  RobotGeometry geometry;
  geometry.links.reserve(message.meshes.size());
  std::set<std::string> seen;
  for (const LinkMesh& sent : message.meshes) {
    LinkGeometry link;
    link.link = sent.link;
    link.source = sent.source;
    TriangleMesh mesh{sent.vertices, sent.triangles};
    link.problem = problemOf(sent, mesh, !seen.insert(sent.link).second);
    if (link.problem.empty()) link.mesh = std::move(mesh);
    geometry.links.push_back(std::move(link));
  }
  return geometry;
}

}  // namespace deformable_contact_monitor
