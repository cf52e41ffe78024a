// The monitor's parameters.
#include "monitor/rules/parameters.h"

#include <ros/names.h>

#include <set>
#include <utility>

#include "core/mesh_file.h"
#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {
namespace {

constexpr double kMaxMarginM = 10;
constexpr double kMaxToleranceM = 1;
constexpr double kMaxBudgetMs = 60000;

void warnOfUnknown(const ParameterReader& reader, std::vector<std::string>* warnings) {
  for (const std::string& name : reader.unknown()) {
    warnings->push_back(name + " is no parameter of this node and is ignored");
  }
}

std::string frame(ParameterReader* reader, const std::string& name, const std::string& fallback) {
  std::string value = reader->text(name, fallback);
  if (value.front() == '/') reader->addProblem(name, "is '" + value + "', must not begin with '/'");
  return value;
}

void readRobot(ParameterReader* reader, MonitorParameters* p) {
  p->robot_source =
      static_cast<RobotSourceKind>(reader->choice("robot_source", {"urdf", "topic"}, 0));
  p->robot_description = reader->text("robot_description", p->robot_description);
  p->srdf = reader->text("srdf", p->srdf);
  p->geometry.kind =
      static_cast<GeometryKind>(reader->choice("geometry", {"collision", "visual"}, 0));
  p->geometry.links = reader->texts("links");
  p->geometry.ignored_links = reader->texts("ignored_links");
  p->strict_geometry = reader->flag("strict_geometry", p->strict_geometry);
  p->margin_m = static_cast<float>(reader->number("margin_m", p->margin_m, 0, kMaxMarginM));
  p->link_margin_m = reader->numbers("link_margin_m", 0, kMaxMarginM);
}

// What an object's type needs beside a topic.
void readMeshType(ParameterReader* entry, ObjectParameters* object) {
  object->type = static_cast<MeshType>(
      entry->choice("type", {"deformable_mesh", "shape_mesh", "marker", "point_cloud"}, 0));
  if (object->type == MeshType::kShapeMesh) {
    object->frame_id = entry->text("frame_id", "");
    if (object->frame_id.empty())
      entry->addProblem("frame_id", "is missing: a shape_mesh has none");
  }
  if (object->type != MeshType::kPointCloud) return;
  const std::string faces = entry->text("faces", "");
  try {
    if (faces.empty()) throw std::runtime_error("is missing: a point_cloud has no triangles");
    object->faces = std::make_shared<const TriangleMesh>(readMeshFile(makeRosResolver()(faces)));
  } catch (const std::exception& error) {
    entry->addProblem("faces",
                      faces.empty() ? error.what() : "is '" + faces + "': " + error.what());
  }
}

void readObjects(ParameterReader* reader, std::vector<std::string>* warnings,
                 MonitorParameters* p) {
  std::set<std::string> names;
  for (ParameterReader& entry : reader->structs("objects")) {
    ObjectParameters object;
    object.name = entry.text("name", "");
    object.topic = entry.text("topic", "");
    const double own_margin_m = entry.number("margin_m", -1, 0, kMaxMarginM);
    object.shares_margin = own_margin_m < 0;
    object.margin_m = object.shares_margin ? p->margin_m : static_cast<float>(own_margin_m);
    object.required = entry.flag("required", object.required);
    readMeshType(&entry, &object);
    std::string error;
    if (object.name.empty()) {
      entry.addProblem("name", "is missing");
    } else if (object.name == "*") {
      entry.addProblem("name", "is '*', which means any body in allowed_contacts");
    } else if (!names.insert(object.name).second) {
      entry.addProblem("name", "is '" + object.name + "', as another object's");
    } else if (object.topic.empty() &&
               !ros::names::validate("objects/" + object.name + "/mesh", error)) {
      entry.addProblem("topic", "is missing, and '" + object.name + "' cannot be part of one");
    } else if (!ros::names::validate(object.topic, error)) {
      entry.addProblem("topic", "is no valid name: " + error);
    }
    warnOfUnknown(entry, warnings);
    p->objects.push_back(std::move(object));
  }
}

void readPairs(ParameterReader* reader, std::vector<std::string>* warnings, MonitorParameters* p) {
  PairClasses classes{false, false, false, false};
  const std::map<std::string, bool*> by_name = {
      {"robot_deformable", &classes.robot_deformable},
      {"deformable_deformable", &classes.deformable_deformable},
      {"deformable_self", &classes.deformable_self},
      {"robot_self", &classes.robot_self}};
  const std::vector<std::string> names = reader->texts("pair_classes");
  for (const std::string& name : names) {
    const auto found = by_name.find(name);
    if (found != by_name.end()) {
      *found->second = true;
    } else {
      reader->addProblem("pair_classes",
                         "has '" + name +
                             "'; there are: robot_deformable, deformable_deformable, "
                             "deformable_self, robot_self");
    }
  }
  if (!names.empty()) p->pair_classes = classes;
  // dynamic_reconfigure leaves them there.
  for (const auto& [name, is_on] : by_name) {
    const bool starts_on = names.empty() ? name == "robot_deformable" : *is_on;
    if (!reader->has(name) || reader->flag(name, starts_on) == starts_on) continue;
    warnings->push_back("~" + name + " has no effect at start, where ~pair_classes decides");
  }

  for (ParameterReader& entry : reader->structs("allowed_contacts")) {
    AllowedContact rule;
    rule.body_a = entry.text("body_a", "");
    rule.body_b = entry.text("body_b", "");
    rule.allowed = entry.flag("allowed", true);
    rule.reason = entry.text("reason", "configured");
    if (rule.body_a.empty() || rule.body_b.empty()) {
      entry.addProblem("body_a and body_b", "must both be there (a name, or '*' for any body)");
    } else {
      p->allowed_contacts.add(rule);
    }
    warnOfUnknown(entry, warnings);
  }
}

void readDetector(ParameterReader* reader, MonitorParameters* p) {
  constexpr int kAny = 1 << 30;
  Options& o = p->detector;
  p->backend = static_cast<BackendChoice>(reader->choice("backend", {"auto", "cuda", "cpu"}, 0));
  constexpr int kMostDevice = 1023;
  p->cuda.device = reader->integer("device", p->cuda.device, 0, kMostDevice);
  p->cuda.devices = reader->integers("devices", 0, kMostDevice);
  constexpr int kMebibyte = 1 << 20;
  const int limit_mib = reader->integer(
      "memory_limit_mib", static_cast<int>(p->cuda.memory_limit_bytes / kMebibyte), 1, kMebibyte);
  p->cuda.memory_limit_bytes = static_cast<std::uint64_t>(limit_mib) * kMebibyte;
  o.adjacent =
      static_cast<AdjacentPairs>(reader->choice("adjacent_pairs", {"beyond_shared", "skip"}, 0));
  o.predicates =
      static_cast<Predicates>(reader->choice("predicates", {"exact", "conservative", "fast"}, 0));
  o.overlap = static_cast<float>(reader->number("overlap", o.overlap, 0, 1));
  o.fuzzifier = static_cast<float>(reader->number("fuzzifier", o.fuzzifier, 1.05, 4));
  o.clusters = reader->integer("clusters", o.clusters, -kAny, kAny);
  o.iterations = reader->integer("iterations", o.iterations, -kAny, kAny);
  o.refresh_period = reader->integer("refresh_period", o.refresh_period, -kAny, kAny);
  o.threads = reader->integer("threads", o.threads, -kAny, kAny);
  p->motion = static_cast<Motion>(reader->choice("motion", {"instant", "swept"}, 0));
  o.tolerance_m =
      static_cast<float>(reader->number("tolerance_m", o.tolerance_m, 0, kMaxToleranceM));
  if (o.tolerance_m > 0 && p->motion == Motion::kSwept) {
    reader->addProblem("tolerance_m", "is above 0, which motion: swept does not know");
  }
  p->swept_tolerance_m = reader->number("swept_tolerance_m", p->swept_tolerance_m, 0, 1);
  o.geometry = reader->flag("contact_geometry", o.geometry);
  p->containment = reader->flag("containment", p->containment);
}

void readOutput(ParameterReader* reader, MonitorParameters* p) {
  constexpr int kMaxCount = 1000000000;
  constexpr int kMostMarkerTriangles = 5000000;  // 600 MB: roscpp takes messages below a gigabyte
  p->max_rate_hz = reader->number("max_rate_hz", p->max_rate_hz, 0, 10000);
  p->robot_rate_hz = reader->number("robot_rate_hz", p->robot_rate_hz, 0.1, 1000);
  p->max_cycle_s = reader->number("max_cycle_s", p->max_cycle_s, 0.001, 3600);
  p->budget_ms = reader->number("budget_ms", p->budget_ms, 0, kMaxBudgetMs);
  p->tf_timeout_s = reader->number("tf_timeout_s", p->tf_timeout_s, 0, 1);
  p->max_mesh_age_s = reader->number("max_mesh_age_s", p->max_mesh_age_s, 0, 60);
  p->tolerated_rejects = reader->number("tolerated_rejects", p->tolerated_rejects, 0, 1);
  p->max_contacts = reader->integer("max_contacts", 0, 0, kMaxCount);
  p->debounce_on_cycles = reader->integer("debounce_on_cycles", p->debounce_on_cycles, 1, 1000);
  p->debounce_off_cycles = reader->integer("debounce_off_cycles", p->debounce_off_cycles, 1, 1000);
  p->since_survives_s = reader->number("since_survives_s", p->since_survives_s, 0, 60);
  p->marker_rate_hz = reader->number("marker_rate_hz", p->marker_rate_hz, 0.1, 100);
  p->marker_lifetime_s = reader->number("marker_lifetime_s", p->marker_lifetime_s, 0.1, 60);
  p->max_marker_triangles = reader->integer(
      "max_marker_triangles", static_cast<int>(p->max_marker_triangles), 1, kMostMarkerTriangles);
  p->diagnostic_min_rate_hz =
      reader->number("diagnostic_min_rate_hz", p->diagnostic_min_rate_hz, 0, 10000);
}

void readInput(ParameterReader* reader, MonitorParameters* p) {
  constexpr std::size_t kMebibyte = 1U << 20U;
  p->max_mesh_bytes = kMebibyte * reader->integer("max_mesh_mib", 512, 1, 4095);
}

}  // namespace

bool tradesAccuracy(const MonitorParameters& parameters) {
  return parameters.detector.tolerance_m > 0 || parameters.budget_ms > 0;
}

double linkMarginM(const MonitorParameters& parameters, const std::string& link) {
  const auto own = parameters.link_margin_m.find(link);
  return own == parameters.link_margin_m.end() ? parameters.margin_m : own->second;
}

MonitorParameters parseParameters(const XmlRpc::XmlRpcValue& tree,
                                  std::vector<std::string>* warnings) {
  std::vector<std::string> found;
  ParameterReader reader(tree, "~", &found);
  MonitorParameters p;
  p.reference_frame = frame(&reader, "reference_frame", p.reference_frame);
  readRobot(&reader, &p);
  readObjects(&reader, warnings, &p);
  readPairs(&reader, warnings, &p);
  readDetector(&reader, &p);
  readOutput(&reader, &p);
  readInput(&reader, &p);
  for (const std::string& problem : problems(p.detector)) found.push_back("~" + problem);
  warnOfUnknown(reader, warnings);
  if (found.empty()) return p;
  std::string all =
      std::to_string(found.size()) + " bad parameter(s), see config/contact_monitor.yaml:";
  for (const std::string& problem : found) all += "\n  " + problem;
  for (const std::string& warning : *warnings) all += "\n  " + warning;
  throw ParameterError(all);
}

}  // namespace deformable_contact_monitor
