// How each monitored pair of bodies stands, and since when; begin and end of contact, debounced.
#include "node/contact_state_tracker.h"

#include <geometry_msgs/Point32.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "core/posed_body.h"
#include "core/predicates/triangle.h"
#include "core/predicates/vector3.h"
#include "node/time_difference.h"
#include "node/triangle_normal.h"

namespace deformable_contact_monitor {
namespace {

// What the triangle pairs of one pair of bodies sum up to.
struct Summary {
  std::uint32_t count = 0;
  double min_separation_m = std::numeric_limits<double>::infinity();
  Vec3d corner_sum;     // over six corners a triangle pair [m]
  Vec3d normal_sum;     // of body_a's distinct triangles, doubled areas [m^2]
  double area_sum = 0;  // of the same, to tell "cancels out" from "small"
};

std::uint64_t key(BodyId a, BodyId b) { return (std::uint64_t{a} << 32U) | b; }

Vec3d cornerSum(const Triangle& t) {
  return toDouble(t.v[0]) + toDouble(t.v[1]) + toDouble(t.v[2]);
}

using Summaries = std::unordered_map<std::uint64_t, Summary>;

bool sameTriangleA(const TrianglePair& a, const TrianglePair& b) {
  return a.body_a == b.body_a && a.triangle_a == b.triangle_a;
}

// Only links, which are body_a of their pairs, have a side that faces the other body.
bool hasNormal(const CycleReport& report, BodyId body_a) {
  return report.bodies.at(body_a).kind == BodyKind::kLink;
}

void add(const Summary& part, Summary* sum) {
  sum->count += part.count;
  sum->min_separation_m = std::min(sum->min_separation_m, part.min_separation_m);
  sum->corner_sum = sum->corner_sum + part.corner_sum;
  sum->normal_sum = sum->normal_sum + part.normal_sum;
  sum->area_sum += part.area_sum;
}

// Contacts are sorted, so those of one triangle of body_a with one body_b stand together, and so do
// many of one pair of bodies: they are summed up apart from the map.
Summaries summarize(const CycleReport& report, const std::vector<PosedBody>& bodies,
                    std::size_t begin, std::size_t end) {
  Summaries summaries;
  const std::vector<float>& separations = report.result->separations_m;
  const std::vector<TrianglePair>& contacts = report.result->contacts;
  for (std::size_t i = begin; i < end;) {
    const BodyId body_a = contacts[i].body_a, body_b = contacts[i].body_b;
    const auto isOfPair = [&](std::size_t k) {
      return k < end && contacts[k].body_a == body_a && contacts[k].body_b == body_b;
    };
    const bool has_normal = hasNormal(report, body_a);
    Summary sum;
    const std::size_t first = i;
    const PosedBody &of_a = bodies[body_a], &of_b = bodies[body_b];
    Vec3d corners_of_a;
    for (; isOfPair(i); ++i) {
      if (i == first || contacts[i].triangle_a != contacts[i - 1].triangle_a) {
        const Triangle a = of_a.triangle(contacts[i].triangle_a);
        corners_of_a = cornerSum(a);
        if (has_normal) {
          const Vec3d normal = doubleAreaNormal(a);
          sum.normal_sum = sum.normal_sum + normal;
          sum.area_sum += std::sqrt(dot(normal, normal));
        }
      }
      sum.corner_sum =
          sum.corner_sum + (corners_of_a + cornerSum(of_b.triangle(contacts[i].triangle_b)));
    }
    sum.count = static_cast<std::uint32_t>(i - first);
    sum.min_separation_m =
        separations.empty()
            ? 0.0
            : double{*std::min_element(separations.begin() + static_cast<std::ptrdiff_t>(first),
                                       separations.begin() + static_cast<std::ptrdiff_t>(i))};
    add(sum, &summaries[key(body_a, body_b)]);
  }
  return summaries;
}

// On threads, in blocks that leave the contacts of one triangle of body_a together.
Summaries summarize(const CycleReport& report) {
  constexpr std::size_t kBlock = 8192;
  if (report.scene == nullptr || report.result == nullptr) return {};
  std::vector<PosedBody> bodies;
  for (const Body& body : report.scene->bodies()) bodies.emplace_back(body);
  const std::vector<TrianglePair>& contacts = report.result->contacts;
  const auto start = [&contacts](std::size_t i) {
    while (i > 0 && i < contacts.size() && sameTriangleA(contacts[i - 1], contacts[i])) ++i;
    return i;
  };
  std::vector<Summaries> parts(blockCount(contacts.size(), kBlock));
  parallelBlocks(contacts.size(), kBlock,
                 [&](std::size_t block, std::size_t begin, std::size_t end) {
                   parts[block] = summarize(report, bodies, start(begin), start(end));
                 });
  if (parts.size() == 1) return std::move(parts.front());
  Summaries summaries;
  for (const Summaries& part : parts) {
    for (const auto& [bodies_key, summary] : part) add(summary, &summaries[bodies_key]);
  }
  return summaries;
}

geometry_msgs::Point32 toPoint32(const Vec3d& v) {
  geometry_msgs::Point32 point;
  point.x = static_cast<float>(v.x);
  point.y = static_cast<float>(v.y);
  point.z = static_cast<float>(v.z);
  return point;
}

// Of a link (body_a, since links come first) towards the other body.
geometry_msgs::Point32 meanNormal(const Summary& summary) {
  constexpr double kCancelled = 1e-6;
  const double length = std::sqrt(dot(summary.normal_sum, summary.normal_sum));
  if (!(length > kCancelled * summary.area_sum)) return {};
  return toPoint32(summary.normal_sum * (1 / length));
}

// Why the pair's state is UNKNOWN; empty if it is known.
std::string unknownBecause(const CycleReport& report, const MonitoredPair& pair,
                           const Summary& summary) {
  for (const BodyId id : {pair.a, pair.b}) {
    const BodyStatus& body = report.bodies.at(id);
    if (!body.unknown_because.empty()) return body.name + ": " + body.unknown_because;
  }
  if (report.result == nullptr) return "no detection ran";
  // The pair's contacts may be among those that are not listed, or that were not looked at.
  const bool touching = summary.count > 0 && summary.min_separation_m == 0;
  if (touching) return "";
  if (report.result->cut_off) return report.result->cut_off_because;
  return report.result->left_out > 0 ? "contacts were left out: memory_limit_mib" : "";
}

void describe(const Summary& summary, bool has_normal, ContactState* state) {
  state->pair_count = summary.count;
  state->min_separation = static_cast<float>(summary.min_separation_m);
  if (summary.count == 0) return;
  state->state = summary.min_separation_m > 0 ? ContactState::NEAR : ContactState::CONTACT;
  state->centroid = toPoint32(summary.corner_sum * (1.0 / (6.0 * summary.count)));
  if (has_normal) state->mean_normal = meanNormal(summary);
}

}  // namespace

ContactStateTracker::ContactStateTracker(int debounce_on_cycles, int debounce_off_cycles)
    : debounce_on_cycles_(debounce_on_cycles), debounce_off_cycles_(debounce_off_cycles) {
  if (debounce_on_cycles < 1 || debounce_off_cycles < 1) {
    throw std::invalid_argument("debounce cycles must be at least 1");
  }
}

ContactStates ContactStateTracker::update(const CycleReport& report) {
  header_ = report.header;
  ++updates_;
  const auto summaries = summarize(report);
  ContactStates message;
  message.header = report.header;
  message.states.reserve(report.pairs.size());
  for (const MonitoredPair& pair : report.pairs) {
    const BodyStatus& a = report.bodies.at(pair.a);
    const Names names{a.name, report.bodies.at(pair.b).name};
    ContactState state;
    state.body_a = names.first;
    state.body_b = names.second;
    state.min_separation = std::numeric_limits<float>::quiet_NaN();
    const auto found = summaries.find(key(pair.a, pair.b));
    const Summary summary = found == summaries.end() ? Summary() : found->second;
    std::string interruption;
    if (pair.allowed) {
      state.state = ContactState::ALLOWED;
      interruption = "allowed";
    } else if (interruption = unknownBecause(report, pair, summary); !interruption.empty()) {
      state.state = ContactState::UNKNOWN;
    } else {
      describe(summary, hasNormal(report, pair.a), &state);
    }
    const auto [entry, is_new] = tracks_.try_emplace(names);
    Track& track = entry->second;
    if (is_new || track.state != state.state) {
      track.state = state.state;
      track.entered = report.header.stamp;
    }
    track.seen = updates_;
    advance(names, state, interruption, &track);
    state.since = toDuration(std::max(0.0, secondsBetween(report.header.stamp, track.entered)));
    message.states.push_back(std::move(state));
  }
  dropUnseen();
  return message;
}

void ContactStateTracker::advance(const Names& names, const ContactState& state,
                                  const std::string& interruption, Track* track) {
  if (!interruption.empty()) {
    if (track->open) addEvent(names, ContactEvent::END, 0, interruption);
    track->open = false;
    track->cycles = 0;
    return;
  }
  const bool touching = state.state == ContactState::CONTACT;
  track->cycles = touching == track->open ? 0 : track->cycles + 1;
  if (track->cycles < (track->open ? debounce_off_cycles_ : debounce_on_cycles_)) return;
  track->open = touching;
  track->cycles = 0;
  addEvent(names, touching ? ContactEvent::BEGIN : ContactEvent::END, state.pair_count, "");
}

std::vector<ContactEvent> ContactStateTracker::takeEvents() {
  std::vector<ContactEvent> events;
  events.swap(events_);
  return events;
}

void ContactStateTracker::reset(const std::string& reason) {
  for (const auto& [names, track] : tracks_) {
    if (track.open) addEvent(names, ContactEvent::END, 0, reason);
  }
  tracks_.clear();
}

void ContactStateTracker::addEvent(const Names& names, std::uint8_t type, std::uint32_t pair_count,
                                   const std::string& reason) {
  ContactEvent event;
  event.header = header_;
  event.body_a = names.first;
  event.body_b = names.second;
  event.type = type;
  event.pair_count = pair_count;
  event.reason = reason;
  events_.push_back(std::move(event));
}

void ContactStateTracker::dropUnseen() {
  for (auto entry = tracks_.begin(); entry != tracks_.end();) {
    const Track& track = entry->second;
    if (track.seen == updates_) {
      ++entry;
      continue;
    }
    if (track.open) addEvent(entry->first, ContactEvent::END, 0, "no longer monitored");
    entry = tracks_.erase(entry);
  }
}

}  // namespace deformable_contact_monitor
