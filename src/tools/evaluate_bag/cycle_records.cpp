// What a detection found in a cycle, as JSON, so that an evaluation can go on from there elsewhere.
#include "tools/evaluate_bag/cycle_records.h"

#include <boost/crc.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// No number, which JSON has not: there is no witness.
Json toJson(const BodyDistance& d) {
  const TrianglePair& w = d.witness;
  const Vec3f &a = d.point_a, &b = d.point_b;
  return {{"bodies", {d.body_a, d.body_b}},
          {"low_m", d.low_m},
          {"high_m", std::isfinite(d.high_m) ? Json(d.high_m) : Json()},
          {"triangles", {w.triangle_a, w.triangle_b}},
          {"points", {a.x, a.y, a.z, b.x, b.y, b.z}},
          {"is_listed", d.is_listed},
          {"contacts", d.contact_count}};
}

Json toJson(const DetectionResult& result) {
  Json json;
  Json& contacts = json["contacts"] = Json::array();
  for (const TrianglePair& pair : result.contacts) {
    for (const std::uint32_t part : {pair.body_a, pair.triangle_a, pair.body_b, pair.triangle_b}) {
      contacts.push_back(part);
    }
  }
  Json& times = json["first_times"] = Json::array();
  for (const FirstContact& first : result.first_times) {
    times.push_back(first.low);
    times.push_back(first.high);
  }
  json["separations_m"] = result.separations_m;
  json["within_pad"] = result.within_pad;
  Json& distances = json["distances"] = Json::array();
  for (const BodyDistance& distance : result.distances) distances.push_back(toJson(distance));
  json["left_out"] = result.left_out;
  json["cut_off"] = result.cut_off;
  json["cut_off_because"] = result.cut_off_because;
  json["guaranteed"] = result.guaranteed;
  json["triangles"] = result.counters.triangles;
  json["rejected"] = result.counters.rejected;
  json["undecided"] = result.counters.undecided;
  json["stages_ms"] = result.stages_ms;
  json["detect_ms"] = result.detect_ms;
  json["round_trip_ms"] = result.round_trip_ms;
  return json;
}

std::vector<TrianglePair> toContacts(const std::vector<std::uint32_t>& parts,
                                     const CycleReport& cycle) {
  if (parts.size() % 4 != 0) throw std::runtime_error("half a pair of triangles");
  const auto require = [&cycle](std::uint32_t body, std::uint32_t triangle) {
    if (body >= cycle.scene->bodyCount() ||
        triangle >= cycle.scene->body(body).mesh.triangleCount()) {
      throw std::runtime_error("a triangle that is not there");
    }
  };
  std::vector<TrianglePair> contacts;
  for (std::size_t i = 0; i < parts.size(); i += 4) {
    require(parts[i], parts[i + 1]);
    require(parts[i + 2], parts[i + 3]);
    contacts.emplace_back(parts[i], parts[i + 1], parts[i + 2], parts[i + 3]);
  }
  return contacts;
}

// A list that goes with the contacts is empty or has one of each.
template <class T>
void requireAsMany(const std::vector<T>& list, const DetectionResult& result) {
  if (list.empty() || list.size() == result.contacts.size()) return;
  throw std::runtime_error("not as many numbers as contacts");
}

BodyDistance toDistance(const Json& json, const CycleReport& cycle) {
  BodyDistance d;
  d.body_a = json.at("bodies").at(0);
  d.body_b = json.at("bodies").at(1);
  if (d.body_a >= d.body_b || d.body_b >= cycle.scene->bodyCount()) {
    throw std::runtime_error("a distance of bodies that are not there");
  }
  json.at("low_m").get_to(d.low_m);
  if (!json.at("high_m").is_null()) json.at("high_m").get_to(d.high_m);
  const Json& triangles = json.at("triangles");
  d.witness = {d.body_a, triangles.at(0), d.body_b, triangles.at(1)};
  const std::vector<float> points = json.at("points");
  d.point_a = {points.at(0), points.at(1), points.at(2)};
  d.point_b = {points.at(3), points.at(4), points.at(5)};
  json.at("is_listed").get_to(d.is_listed);
  json.at("contacts").get_to(d.contact_count);
  return d;
}

DetectionResult toResult(const Json& json, const CycleReport& cycle) {
  DetectionResult result;
  result.contacts = toContacts(json.at("contacts"), cycle);
  const std::vector<float> times = json.at("first_times");
  for (std::size_t i = 0; i + 1 < times.size(); i += 2) {
    result.first_times.push_back({times[i], times[i + 1]});
  }
  json.at("separations_m").get_to(result.separations_m);
  json.at("within_pad").get_to(result.within_pad);
  requireAsMany(result.first_times, result);
  requireAsMany(result.separations_m, result);
  requireAsMany(result.within_pad, result);
  for (const Json& distance : json.at("distances")) {
    result.distances.push_back(toDistance(distance, cycle));
  }
  json.at("left_out").get_to(result.left_out);
  json.at("cut_off").get_to(result.cut_off);
  json.at("cut_off_because").get_to(result.cut_off_because);
  json.at("guaranteed").get_to(result.guaranteed);
  json.at("triangles").get_to(result.counters.triangles);
  json.at("rejected").get_to(result.counters.rejected);
  json.at("undecided").get_to(result.counters.undecided);
  json.at("stages_ms").get_to(result.stages_ms);
  json.at("detect_ms").get_to(result.detect_ms);
  json.at("round_trip_ms").get_to(result.round_trip_ms);
  return result;
}

Json toJson(const SweepReport& sweep) {
  Json json{
      {"from_ns", sweep.from.toNSec()}, {"problem", sweep.problem}, {"compute_s", sweep.compute_s}};
  json["rejected"] = Json::array();
  for (const StepBody& body : sweep.bodies) json["rejected"].push_back(body.rejected);
  if (sweep.result == nullptr) return json;
  json["result"] = toJson(sweep.result->detection);
  json["sub_steps"] = sweep.result->sub_steps;
  json["pad_m"] = sweep.result->pad_m;
  json["outlying"] = sweep.result->outlying;
  return json;
}

void readStep(const Json& json, const CycleReport& cycle, StepResult* result, SweepReport* sweep) {
  if (json.at("from_ns") != sweep->from.toNSec()) throw std::runtime_error("a step from elsewhere");
  json.at("problem").get_to(sweep->problem);
  json.at("compute_s").get_to(sweep->compute_s);
  for (std::size_t i = 0; i < sweep->bodies.size(); ++i) {
    json.at("rejected").at(i).get_to(sweep->bodies[i].rejected);
  }
  if (json.count("result") == 0) return;
  result->detection = toResult(json.at("result"), cycle);
  if (result->detection.first_times.size() != result->detection.contacts.size()) {
    throw std::runtime_error("a step without times");
  }
  json.at("sub_steps").get_to(result->sub_steps);
  json.at("pad_m").get_to(result->pad_m);
  json.at("outlying").get_to(result->outlying);
  sweep->result = result;
}

// Their middles are nothing that an evaluation says.
Json toJson(const Containment& containment) {
  Json parts = Json::array();
  for (const InsidePart& part : containment.parts) {
    parts.push_back({part.inner, part.outer, part.triangle});
  }
  return {{"parts", parts}, {"cut_off_because", containment.cut_off_because}};
}

Containment toContainment(const Json& json) {
  Containment containment;
  for (const Json& part : json.at("parts")) {
    const std::vector<std::uint32_t> of_part = part;
    containment.parts.push_back({of_part.at(0), of_part.at(1), of_part.at(2), Vec3d()});
  }
  json.at("cut_off_because").get_to(containment.cut_off_because);
  return containment;
}

template <class T>
void add(const T* data, std::size_t count, boost::crc_32_type* sum) {
  sum->process_bytes(data, count * sizeof(T));
}

}  // namespace

Json toRecord(const CycleReport& cycle) {
  Json record{{"result", toJson(*cycle.result)}};
  if (cycle.containment != nullptr) record["containment"] = toJson(*cycle.containment);
  record["steps"] = Json::array();
  for (const SweepReport& sweep : cycle.sweeps) record["steps"].push_back(toJson(sweep));
  return record;
}

void RecordedCycle::read(const Json& record, CycleReport* cycle) {
  const Json& steps = record.at("steps");
  if (steps.size() != cycle->sweeps.size()) throw std::runtime_error("other steps");
  result_ = toResult(record.at("result"), *cycle);
  cycle->result = &result_;
  containment_.reset();
  if (record.count("containment") > 0) {
    containment_ = toContainment(record.at("containment"));
    cycle->containment = &*containment_;
  }
  steps_ = std::vector<StepResult>(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    readStep(steps[i], *cycle, &steps_[i], &cycle->sweeps[i]);
  }
}

std::uint32_t sceneChecksum(const CycleReport& cycle) {
  boost::crc_32_type sum;
  const Scene& scene = *cycle.scene;
  std::vector<std::uint64_t> numbers;
  for (const auto& [a, b] : scene.enabledPairs()) numbers.insert(numbers.end(), {a, b});
  for (BodyId id = 0; id < scene.bodyCount(); ++id) {
    if (!scene.takesPart(id)) continue;
    const Body& body = scene.body(id);
    add(body.pose.rotation, 9, &sum);
    add(body.pose.translation, 3, &sum);
    add(&body.margin_m, 1, &sum);
    if (cycle.bodies[id].kind == BodyKind::kLink) continue;
    add(body.mesh.vertices.data(), body.mesh.vertices.size(), &sum);
    numbers.push_back(body.mesh.triangleCount());
  }
  add(numbers.data(), numbers.size(), &sum);
  return sum.checksum();
}

}  // namespace deformable_contact_monitor
