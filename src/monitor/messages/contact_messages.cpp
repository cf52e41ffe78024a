// Conversions between what the monitor computes and its messages.
#include "monitor/messages/contact_messages.h"

#include <ros/serialization.h>

#include <algorithm>
#include <exception>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "core/triangle_mesh.h"
#include "monitor/point32.h"
#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

void addBodies(const CycleReport& report, ContactArray* message) {
  for (const BodyStatus& body : report.bodies) {
    message->bodies.push_back(body.name);
    message->body_kind.push_back(body.kind == BodyKind::kLink ? ContactArray::LINK
                                                              : ContactArray::DEFORMABLE);
    message->triggered.push_back(body.triggered);
    message->body_stamps.push_back(body.stamp);
    message->topology_ids.push_back(body.topology_id);
    if (!body.unknown_because.empty()) {
      message->skipped.push_back(body.name + ": " + body.unknown_because);
    }
  }
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

// Of as many pairs as there are.
void addGeometry(const DetectionResult& result, ContactArray* message) {
  message->geometry.reserve(message->pairs.size());
  for (std::size_t i = 0; i < message->pairs.size(); ++i) {
    message->geometry.push_back(toContactGeometry(result.geometry[i]));
  }
}

void addPairs(const DetectionResult& result, std::size_t most, ContactArray* message) {
  const std::size_t total = result.contacts.size();
  const std::size_t kept = std::min(total, most);
  message->pairs.resize(kept);
  for (std::size_t i = 0; i < kept; ++i) {
    message->pairs[i] = toContactPair(result.contacts[i]);
  }
  message->pair_count = total + result.left_out;
  message->truncated = kept < message->pair_count;
}

// Why a received link mesh cannot be used; empty if it can.
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

ContactPair toContactPair(const TrianglePair& pair) {
  ContactPair message;
  message.body_a = pair.body_a;
  message.triangle_a = pair.triangle_a;
  message.body_b = pair.body_b;
  message.triangle_b = pair.triangle_b;
  return message;
}

std::size_t mostPairs(std::uint64_t most_bytes, std::uint64_t other_bytes,
                      std::uint64_t pair_bytes) {
  return other_bytes < most_bytes ? (most_bytes - other_bytes) / pair_bytes : 0;
}

ContactArray toContactArray(const CycleReport& report, std::size_t max_contacts,
                            std::uint64_t most_bytes) {
  ContactArray message;
  message.header = report.header;
  message.cycle = report.cycle;
  addBodies(report, &message);
  message.backend = report.backend;
  message.predicates = toString(report.options.predicates);
  message.overlap = report.options.overlap;
  message.tolerance = report.options.tolerance_m;
  message.age = toDuration(secondsBetween(report.now, report.header.stamp));
  if (report.result != nullptr) {
    const DetectionResult& result = *report.result;
    // Behind all else that takes room.
    using ros::serialization::serializationLength;
    const bool geometry = hasGeometry(report);
    const std::size_t pair_bytes = serializationLength(ContactPair()) +
                                   (geometry ? serializationLength(ContactGeometry()) : 0);
    const std::size_t room = mostPairs(most_bytes, serializationLength(message), pair_bytes);
    addPairs(result, max_contacts == 0 ? room : std::min(max_contacts, room), &message);
    if (geometry) addGeometry(result, &message);
    message.guaranteed = result.guaranteed;
    message.timed_out = result.isOutOfTime();
    message.undecided = saturated(result.counters.undecided);
    message.rejected_triangles = saturated(result.counters.rejected);
    message.compute_time = ros::Duration(result.round_trip_ms / 1e3);
    message.complete = result.guaranteed && message.skipped.empty() &&
                       result.counters.rejected == 0 && !message.truncated && !result.cut_off;
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
