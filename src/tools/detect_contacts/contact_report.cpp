// Writes the outputs of detect_contacts: lists of pairs, a JSON report, and a summary for people.
// All functions return text and open no files. A list may have millions of lines, so memory for it
// is reserved in one piece.
#include "tools/detect_contacts/contact_report.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/body_distance.h"
#include "core/common/rejected_bodies.h"
#include "tools/common/command_line.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"
#include "tools/detect_contacts/nearest_report.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// The bounds of a pair's distance, in the meshes' unit, and the state that follows from them.
struct BodyState {
  BodyDistance distance;
  PairDecision decision = PairDecision::kOpen;
};

// Returns the bounds of a pair's distance that follow from the list of contacts: the nearest
// contact gives the upper bound and the witness. If the result has no separations, all contacts
// intersect, at distance 0. The lower bound stays 0.
BodyDistance listedDistance(const DetectionResult& result, BodyId a, BodyId b) {
  BodyDistance distance;
  distance.body_a = a;
  distance.body_b = b;
  distance.is_listed = !result.cut_off && result.left_out == 0;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& contact = result.contacts[i];
    if (contact.body_a != a || contact.body_b != b) continue;
    ++distance.contact_count;
    const float high_m = result.separationM(i);
    if (high_m >= distance.high_m) continue;
    distance.high_m = high_m;
    distance.witness = contact;
  }
  return distance;
}

// Returns the bounds of a pair's distance that follow from the exact search. A pair that it did not
// list is farther apart than its margin, unless the cycle was cut off.
BodyDistance searchedDistance(const Scene& scene, const DetectionResult& result, BodyId a,
                              BodyId b) {
  BodyDistance distance;
  distance.body_a = a;
  distance.body_b = b;
  for (const NearestPair& nearest : result.nearest) {
    if (nearest.pair.body_a != a || nearest.pair.body_b != b) continue;
    distance.low_m = distance.high_m = nearest.distance_m;
    distance.witness = nearest.pair;
    distance.point_a = nearest.point_a;
    distance.point_b = nearest.point_b;
    return distance;
  }
  if (result.cut_off) return distance;
  const float margin_m = std::max(scene.body(a).margin_m, scene.body(b).margin_m);
  distance.low_m = std::nextafter(margin_m, std::numeric_limits<float>::infinity());
  return distance;
}

Json point(const Vec3f& p) { return {p.x, p.y, p.z}; }

// Returns the state of each enabled pair of two bodies, ascending. If the result has no bounds
// (DetectionResult::distances), the listed contacts decide, and the points of a witness are zero.
// Bodies with rejected triangles are in contact, or nothing is certain.
std::vector<BodyState> bodyStates(const Scene& scene, const DetectionResult& result,
                                  const Options& options) {
  const bool is_searched = options.nearest && !options.near_pairs;
  // Exact detection has no bounds, so they are made from its list.
  std::vector<BodyDistance> distances = result.distances;
  if (distances.empty()) {
    for (const auto& [a, b] : scene.enabledPairs()) {
      if (a == b) continue;
      distances.push_back(is_searched ? searchedDistance(scene, result, a, b)
                                      : listedDistance(result, a, b));
    }
  }
  // The core decides, so the tool and the node report the same states.
  const RejectedBodies rejected(scene, options.motion, result.counters.rejected);
  std::vector<BodyState> states;
  states.reserve(distances.size());
  for (const BodyDistance& found : distances) {
    const BodyDistance distance = rejected.certain(found);
    states.push_back({distance, decide(distance, scene, options.tolerance_m)});
  }
  return states;
}

// Returns the bounds of a distance in words, with the witness.
std::string boundsText(const BodyDistance& d) {
  if (!std::isinf(d.high_m)) {
    return formatted("%.6g to %.6g apart, by triangles %u and %u", d.low_m, d.high_m,
                     d.witness.triangle_a, d.witness.triangle_b);
  }
  return d.low_m > 0 ? formatted("at least %.6g apart", d.low_m)
                     : "nothing is known of the distance";
}

// Returns lines of pairs: the names of the bodies, the state, and the bounds of the distance with
// the witness.
std::string bodyStateLines(const Scene& scene, const std::vector<BodyState>& states) {
  return firstPairs(states.size(), [&](std::size_t i) {
    const BodyDistance& d = states[i].distance;
    return scene.body(d.body_a).name + " with " + scene.body(d.body_b).name + ": " +
           toString(states[i].decision) + ", " + boundsText(d);
  });
}

// Returns [{bodies, state, distance_low, distance_high, witness, points, listed, contacts}].
// Unknown values are null: an infinite upper bound means that no witness is known, and
// JSON has no infinity.
Json bodyStatesJson(const std::vector<BodyState>& states) {
  Json json = Json::array();
  for (const BodyState& state : states) {
    const BodyDistance& d = state.distance;
    const bool has_witness = !std::isinf(d.high_m);
    json.push_back(
        {{"bodies", {d.body_a, d.body_b}},
         {"state", toString(state.decision)},
         {"distance_low", d.low_m},
         {"distance_high", has_witness ? Json(d.high_m) : Json()},
         {"witness", has_witness ? Json{d.witness.triangle_a, d.witness.triangle_b} : Json()},
         {"points", has_witness ? Json{point(d.point_a), point(d.point_b)} : Json()},
         {"listed", d.is_listed},
         {"contacts", d.contact_count}});
  }
  return json;
}

// Returns first, median and 95th percentile [ms]. The first detection is a cold start and stands
// apart.
Json timesJson(const std::vector<double>& ms) {
  return {{"first", ms.front()}, {"median", median(ms)}, {"p95", percentile(ms, 0.95)}};
}

// Returns the median time of each stage. A stage that a cycle skipped counts as 0 in it.
Json stagesJson(const DetectionTimes& times) {
  std::map<std::string, std::vector<double>> samples;
  for (std::size_t cycle = 0; cycle < times.stages.size(); ++cycle) {
    for (const auto& [name, ms] : times.stages[cycle]) {
      std::vector<double>& of_stage = samples[name];
      of_stage.resize(times.stages.size());
      of_stage[cycle] += ms;
    }
  }
  Json json = Json::object();
  for (const auto& [name, ms] : samples) json[name] = median(ms);
  return json;
}

// Returns path and size of each body's mesh; with --swept, also the file of its earlier state.
Json filesJson(const DetectArguments& arguments, const Scene& scene) {
  Json json = Json::array();
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    const Body& body = scene.body(id);
    json.push_back({{"path", body.name},
                    {"vertices", body.mesh.vertexCount()},
                    {"triangles", body.mesh.triangleCount()}});
    if (arguments.swept()) json.back()["earlier"] = arguments.meshes[2 * std::size_t{id}];
  }
  return json;
}

// Returns the options in force, defaults included, so that a run can be repeated from its report.
Json optionsJson(const DetectArguments& arguments) {
  const Options& options = arguments.options;
  Json json;
  json["backend"] = arguments.backend;
  json["self"] = arguments.self;
  json["adjacent"] = toString(options.adjacent);
  json["predicates"] = toString(options.predicates);
  json["overlap"] = options.overlap;
  json["margin"] = arguments.margin_m;
  json["nearest"] = options.nearest;
  json["near_pairs"] = options.near_pairs;
  json["tolerance_m"] = options.tolerance_m;
  json["budget_ms"] = arguments.budget_ms ? Json(*arguments.budget_ms) : Json();
  json["clusters"] = options.clusters == 0 ? Json("auto") : Json(options.clusters);
  json["fuzzifier"] = options.fuzzifier;
  json["iterations"] = options.iterations;
  json["refresh_period"] = options.refresh_period;
  json["threads"] = options.threads;
  return json;
}

// Returns the greatest depth [the meshes' unit], and how many pairs have each flag. Pairs that are
// apart have no depth.
Json geometryJson(const HostList<PairGeometry>& geometry) {
  const std::pair<const char*, GeometryFlag> flags[] = {
      {"coplanar", kCoplanar},
      {"normal_undefined", kNormalUndefined},
      {"separation_undefined", kSeparationUndefined},
      {"degenerate", kDegenerate},
      {"normal_not_unique", kNormalNotUnique}};
  double deepest = 0;
  for (const PairGeometry& g : geometry) deepest = std::max(deepest, -double{g.separation_m});
  Json json{{"deepest", deepest}};
  for (const auto& [name, flag] : flags) {
    const GeometryFlag of_pair = flag;
    json[name] = std::count_if(geometry.begin(), geometry.end(), [of_pair](const PairGeometry& g) {
      return (g.flags & of_pair) != 0;
    });
  }
  return json;
}

// Counts the contacts that exist when the time interval begins: their first time is certainly 0.
std::size_t countAtStart(const std::vector<FirstContact>& times) {
  return static_cast<std::size_t>(std::count_if(
      times.begin(), times.end(), [](const FirstContact& first) { return first.high == 0; }));
}

// Returns a line with the times; statistics only if there is more than one.
std::string milliseconds(const char* name, const std::vector<double>& ms) {
  if (ms.size() == 1) return formatted("%s: %.3f ms\n", name, ms.front());
  return formatted("%s: first %.3f ms, median %.3f ms, p95 %.3f ms of %zu\n", name, ms.front(),
                   median(ms), percentile(ms, 0.95), ms.size());
}

// Returns lines with the number of contacts of pairs of bodies that touch.
std::string bodyPairs(const Scene& scene, const TrianglePairs& contacts) {
  std::map<std::pair<BodyId, BodyId>, std::uint64_t> counts;
  for (const TrianglePair& pair : contacts) ++counts[{pair.body_a, pair.body_b}];
  auto next = counts.begin();
  return firstPairs(counts.size(), [&](std::size_t /*i*/) {
    const auto& [bodies, count] = *next++;
    return scene.body(bodies.first).name +
           (bodies.first == bodies.second ? " with itself"
                                          : " with " + scene.body(bodies.second).name) +
           ": " + std::to_string(count);
  });
}

// Returns one line: whether the list has every contact, and each reason why it may not.
std::string completeness(const DetectArguments& arguments, const DetectionResult& result) {
  std::string text = result.isComplete() ? "complete: yes" : "complete: no";
  if (!result.guaranteed) {
    text += result.distances.empty()        ? "; these settings or this backend may err"
            : result.counters.rejected == 0 ? "; of pairs of bodies it is certain, of triangles not"
                                            : "; of triangles it is not certain";
  }
  if (result.cut_off) text += "; cut off: " + result.cut_off_because;
  if (result.counters.rejected > 0) {
    text += "; " + std::to_string(result.counters.rejected) +
            " triangles have a NaN or infinite vertex and took no part";
    if (arguments.bounded()) text += ", so their bodies are unknown unless they touch";
  }
  if (result.counters.undecided > 0) {
    text += "; " + std::to_string(result.counters.undecided) + " undecided pairs count as contacts";
  }
  return text + "\n";
}

}  // namespace

// Copies the times, because the detector overwrites its result in the next detection.
void DetectionTimes::add(const DetectionResult& result) {
  detect.push_back(result.detect_ms);
  round_trip.push_back(result.round_trip_ms);
  stages.push_back(result.stages_ms);
}

// Writes the digits directly, because a list may have millions of lines and snprintf() is slower.
std::string pairLines(const TrianglePairs& contacts) {
  // Reserves the longest line for each contact, and cuts the text at its end.
  constexpr std::size_t kLongestLine = 44;  // four numbers of ten digits, three blanks, LF
  std::string text(contacts.size() * kLongestLine, '\0');
  char* at = text.data();
  char* const end = at + text.size();
  const auto put = [&at, end](std::uint32_t number, char after) {
    at = std::to_chars(at, end, number).ptr;
    *at++ = after;
  };
  for (const TrianglePair& pair : contacts) {
    put(pair.body_a, ' ');
    put(pair.triangle_a, ' ');
    put(pair.body_b, ' ');
    put(pair.triangle_b, '\n');
  }
  text.resize(static_cast<std::size_t>(at - text.data()));
  return text;
}

// first_times has the order of contacts, so one index serves both.
std::string timeLines(const DetectionResult& result) {
  std::string text;
  text.reserve(result.first_times.size() * 48);
  char line[100];
  for (std::size_t i = 0; i < result.first_times.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    const FirstContact& first = result.first_times[i];
    const int length =
        std::snprintf(line, sizeof line, "%u %u %u %u %.9g %.9g\n", pair.body_a, pair.triangle_a,
                      pair.body_b, pair.triangle_b, first.low, first.high);
    text.append(line, static_cast<std::size_t>(length));
  }
  return text;
}

std::string geometryLines(const DetectionResult& result) {
  std::string text;
  text.reserve(result.geometry.size() * 160);
  char line[300];
  for (std::size_t i = 0; i < result.geometry.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    const PairGeometry& g = result.geometry[i];
    const int length = std::snprintf(
        line, sizeof line, "%u %u %u %u %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %.9g %d\n",
        pair.body_a, pair.triangle_a, pair.body_b, pair.triangle_b, g.point_a.x, g.point_a.y,
        g.point_a.z, g.point_b.x, g.point_b.y, g.point_b.z, g.normal.x, g.normal.y, g.normal.z,
        g.separation_m, g.flags);
    text.append(line, static_cast<std::size_t>(length));
  }
  return text;
}

// `contacts` counts all contacts that were found, also those that --memory-limit left out.
std::string jsonReport(const DetectArguments& arguments, const Scene& scene,
                       const std::string& backend, const DetectionResult& last,
                       const DetectionTimes& times) {
  const Counters& counters = last.counters;
  Json json;
  json["files"] = filesJson(arguments, scene);
  json["motion"] = toString(arguments.options.motion);
  json["backend"] = backend;
  json["options"] = optionsJson(arguments);
  json["contacts"] = last.contacts.size() + last.left_out;
  json["contacts_left_out"] = last.left_out;
  json["cut_off_because"] = last.cut_off_because;
  json["complete"] = last.isComplete();
  json["guaranteed"] = last.guaranteed;
  json["triangles"] = counters.triangles;
  json["rejected_triangles"] = counters.rejected;
  json["posed"] = counters.posed;
  json["culled"] = counters.culled;
  json["clustered"] = counters.clustered;
  json["large"] = counters.large;
  json["clusters"] = counters.clusters;
  json["cluster_entries"] = counters.cluster_entries;
  json["largest_cluster"] = counters.largest_cluster;
  json["interval_overlaps"] = counters.interval_overlaps;
  json["candidates"] = counters.candidates;
  json["exact"] = counters.exact;
  json["undecided"] = counters.undecided;
  // The parts below exist only if their options asked for them.
  if (arguments.options.first_times) json["at_start"] = countAtStart(last.first_times);
  if (arguments.options.geometry) json["geometry"] = geometryJson(last.geometry);
  if (arguments.bounded()) {
    json["body_states"] = bodyStatesJson(bodyStates(scene, last, arguments.options));
  }
  if (arguments.options.nearest) {
    json["nearest"] = nearestJson(nearestBodies(scene, last, arguments.options.tolerance_m));
  }
  json["memory_bytes"] = last.memory_bytes;
  json["memory_is_whole"] = last.memory_is_whole;
  json["repeat"] = arguments.repeat;
  json["detect_ms"] = timesJson(times.detect);
  json["round_trip_ms"] = timesJson(times.round_trip);
  json["stages_ms"] = stagesJson(times);
  return jsonText(json);
}

// Starts with what most users look for, the number of contacts, and ends with the times.
std::string summary(const DetectArguments& arguments, const Scene& scene,
                    const std::string& backend, const DetectionResult& last,
                    const DetectionTimes& times) {
  std::string states;
  if (arguments.bounded()) {
    states = "pairs of bodies, within " + toText(arguments.options.tolerance_m) + ":\n" +
             bodyStateLines(scene, bodyStates(scene, last, arguments.options));
  }
  if (arguments.options.nearest) {
    states += nearestSummary(scene, nearestBodies(scene, last, arguments.options.tolerance_m));
  }
  return std::to_string(last.contacts.size()) + " contacts\n" + bodyPairs(scene, last.contacts) +
         states + completeness(arguments, last) + std::to_string(scene.bodyCount()) + " bodies, " +
         std::to_string(last.counters.triangles) + " triangles, " +
         std::to_string(last.counters.clusters) + " clusters, " +
         std::to_string(last.counters.candidates) + " candidate pairs, backend " + backend + "\n" +
         milliseconds("detect", times.detect) + milliseconds("round trip", times.round_trip);
}

}  // namespace deformable_contact_monitor
