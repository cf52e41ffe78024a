// Reads the monitor's parameters.
//
// Each read*() function covers a part of config/contact_monitor.yaml. It passes names, defaults and
// ranges to a ParameterReader, which collects all problems. test/parameter_table_test.py reads
// these calls and checks that the YAML file says the same, so keep names and ranges in the calls.
#include "monitor/rules/parameters.h"

#include <ros/names.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <utility>

#include "monitor/rules/object_types.h"
#include "monitor/rules/parameter_reader.h"

namespace deformable_contact_monitor {
namespace {

// Upper ends of ranges that several parameters share, or that are part of a contract.
constexpr double kMaxRadiusM = 1;
constexpr double kMaxToleranceM = 1;
constexpr double kMaxBudgetMs = 60000;
constexpr double kMaxStampOffsetS = 5;  // tf2 keeps 10 s

// Reads a TF frame.
std::string frame(ParameterReader* reader, const std::string& name, const std::string& fallback) {
  std::string value = reader->text(name, fallback);
  reader->refuseSlash(name, value);
  return value;
}

// Reads what precedes links' names in TF frames.
std::string prefix(ParameterReader* reader) {
  std::string value = reader->optionalText("frame_prefix", "");
  reader->refuseSlash("frame_prefix", value);
  return value;
}

// Reads the list of robots. What describes a single robot must be left alone then.
void readRobots(ParameterReader* reader, std::vector<std::string>* warnings, MonitorParameters* p) {
  for (ParameterReader& entry : reader->structs("robots")) {
    RobotParameters robot;
    robot.description = entry.text("description", "");
    if (robot.description.empty()) entry.addProblem("description", "is missing");
    robot.link_prefix = prefix(&entry);
    robot.srdf = entry.text("srdf", robot.srdf);
    entry.warnOfUnknown(warnings);
    p->robots.push_back(std::move(robot));
  }
  if (p->robots.empty()) return;
  const MonitorParameters defaults;
  const auto refuse = [reader](const char* name, const std::string& value,
                               const std::string& fallback) {
    if (value == fallback) return;
    reader->addProblem(name, "is '" + value + "', which has no place beside robots; set it there");
  };
  refuse("robot_description", p->robot_description, defaults.robot_description);
  refuse("frame_prefix", p->frame_prefix, defaults.frame_prefix);
  refuse("srdf", p->srdf, defaults.srdf);
}

// Choices are listed in the order of their enum, so an index converts to its value.
void readRobot(ParameterReader* reader, std::vector<std::string>* warnings, MonitorParameters* p) {
  p->robot_source =
      static_cast<RobotSourceKind>(reader->choice("robot_source", {"urdf", "topic"}, 0));
  p->robot_description = reader->text("robot_description", p->robot_description);
  p->frame_prefix = prefix(reader);
  p->srdf = reader->text("srdf", p->srdf);
  readRobots(reader, warnings, p);
  p->geometry.kind = static_cast<GeometryKind>(
      reader->choice("geometry", {"collision", "visual", "collision_or_visual"}, 0));
  p->geometry.links = reader->texts("links");
  p->geometry.ignored_links = reader->texts("ignored_links");
  p->strict_geometry = reader->flag("strict_geometry", p->strict_geometry);
  p->margin_m = static_cast<float>(reader->number("margin_m", p->margin_m, 0, kMaxMarginM));
  p->link_margin_m = reader->numbers("link_margin_m", 0, kMaxMarginM);
}

// Adds a problem unless the name works as a body's name in rules.
void checkName(const std::string& name, std::set<std::string>* names, ParameterReader* entry) {
  if (name.empty()) {
    entry->addProblem("name", "is missing");
  } else if (name == "*") {
    entry->addProblem("name", "is '*', which means any body in allowed_contacts");
  } else if (!names->insert(name).second) {
    entry->addProblem("name", "is '" + name + "', which is another object's name");
  }
}

// Reads what objects of all types have.
template <class Object>
void readNameAndSize(ParameterReader* entry, float margin_m, Object* object) {
  object->name = entry->text("name", "");
  const double own_margin_m = entry->number("margin_m", -1, 0, kMaxMarginM);
  object->shares_margin = own_margin_m < 0;
  object->margin_m = object->shares_margin ? margin_m : static_cast<float>(own_margin_m);
  object->radius_m = static_cast<float>(entry->number("radius_m", 0, 0, kMaxRadiusM));
}

// Comes after readRobot(), because objects without a margin of their own use margin_m.
void readObjects(ParameterReader* reader, std::vector<std::string>* warnings,
                 MonitorParameters* p) {
  constexpr std::size_t kMebibyte = 1U << 20U;
  p->max_mesh_bytes = kMebibyte * reader->integer("max_mesh_mib", 512, 1, 4095);
  std::set<std::string> names;
  for (ParameterReader& entry : reader->structs("objects")) {
    if (isRigid(&entry)) {
      RigidParameters rigid;
      readNameAndSize(&entry, p->margin_m, &rigid);
      checkName(rigid.name, &names, &entry);
      readRigid(&entry, warnings, &rigid);
      entry.warnOfUnknown(warnings);
      p->rigids.push_back(std::move(rigid));
      continue;
    }
    ObjectParameters object;
    readNameAndSize(&entry, p->margin_m, &object);
    object.topic = entry.text("topic", "");
    object.required = entry.flag("required", object.required);
    object.stamp_offset_s =
        entry.number("stamp_offset_s", object.stamp_offset_s, -kMaxStampOffsetS, kMaxStampOffsetS);
    readObjectType(&entry, warnings, &object);
    const bool has_faces = object.type == MeshType::kPointCloud && object.faces != nullptr;
    const std::string faces = has_faces ? entry.text("faces", "") : "";
    object.parts = readParts(&entry, object.name, faces, warnings);
    checkName(object.name, &names, &entry);
    // Without a topic, the name must work as a part of one.
    std::string error;
    if (object.topic.empty() && !ros::names::validate("objects/" + object.name + "/mesh", error)) {
      entry.addProblem("topic", "is missing, and '" + object.name + "' cannot be part of a topic");
    } else if (!ros::names::validate(object.topic, error)) {
      entry.addProblem("topic", "is not a valid name: " + error);
    }
    entry.warnOfUnknown(warnings);
    p->objects.push_back(std::move(object));
  }
}

// The name "object:part" must be that of one thing, and what parts do not work with is refused.
// Comes after everything else was read.
void checkParts(const MonitorParameters& p, ParameterReader* reader) {
  for (const ObjectParameters& object : p.objects) {
    if (object.parts.empty()) continue;
    const auto check = [&](const std::string& other) {
      if (other.compare(0, object.name.size() + 1, object.name + ":") != 0) return;
      reader->addProblem("objects", "have '" + other + "', which looks like a part of '" +
                                        object.name + "'; rename the object");
    };
    for (const ObjectParameters& other : p.objects) check(other.name);
    for (const RigidParameters& other : p.rigids) check(other.name);
    const std::string refused = " is not supported with parts, which '" + object.name + "' has";
    if (p.detector.tolerance_m > 0) reader->addProblem("tolerance_m", "above 0" + refused);
    if (p.containment) reader->addProblem("containment: true", refused.substr(1));
  }
}

// Refuses what does not work with a radius. Comes after everything else was read.
void checkRadii(const MonitorParameters& p, ParameterReader* reader) {
  const auto check = [&](const std::string& object, float radius_m) {
    if (radius_m == 0) return;
    const std::string refused =
        " is not supported with radius_m, which '" + object + "' has above 0";
    if (p.detector.tolerance_m > 0) reader->addProblem("tolerance_m", "above 0" + refused);
    if (p.motion == Motion::kSwept) reader->addProblem("motion: swept", refused.substr(1));
  };
  for (const ObjectParameters& object : p.objects) check(object.name, object.radius_m);
  for (const RigidParameters& rigid : p.rigids) check(rigid.name, rigid.radius_m);
}

// A rigid object that no class is about is probably an oversight: both classes are off by default.
void warnOfUnusedRigids(const MonitorParameters& p, std::vector<std::string>* warnings) {
  const PairClasses& classes = p.pair_classes;
  if (p.rigids.empty() || classes.deformable_rigid || classes.robot_rigid) return;
  warnings->push_back("nothing looks at rigid object '" + p.rigids.front().name +
                      "': ~pair_classes has neither deformable_rigid nor robot_rigid");
}

// A list of classes replaces the default list; an empty list means the default.
void readPairs(ParameterReader* reader, std::vector<std::string>* warnings, MonitorParameters* p) {
  PairClasses classes{false};
  const std::vector<std::string> names = reader->texts("pair_classes", {"robot_deformable"});
  for (const std::string& name : names) {
    const auto found =
        std::find_if(std::begin(kPairClasses), std::end(kPairClasses),
                     [&name](const NamedPairClass& one) { return name == one.name; });
    if (found != std::end(kPairClasses)) {
      classes.*found->is_on = true;
    } else {
      reader->addProblem("pair_classes",
                         "has '" + name +
                             "', must be one of: robot_deformable, deformable_deformable, "
                             "deformable_self, robot_self, deformable_rigid, robot_rigid");
    }
  }
  if (!names.empty()) p->pair_classes = classes;
  // dynamic_reconfigure leaves a flag per class on the parameter server. They do not count here.
  for (const auto& [name, is_on] : kPairClasses) {
    const bool starts_on = p->pair_classes.*is_on;
    if (!reader->has(name) || reader->flag(name, starts_on) == starts_on) continue;
    warnings->push_back("~" + std::string(name) +
                        " has no effect at start, where ~pair_classes decides");
  }

  for (ParameterReader& entry : reader->structs("allowed_contacts")) {
    AllowedContact rule;
    rule.body_a = entry.text("body_a", "");
    rule.body_b = entry.text("body_b", "");
    rule.allowed = entry.flag("allowed", true);
    rule.reason = entry.text("reason", "configured");
    if (rule.body_a.empty() || rule.body_b.empty()) {
      entry.addProblem("body_a and body_b", "must both be set (a name, or '*' for any body)");
    } else {
      p->allowed_contacts.add(rule);
    }
    entry.warnOfUnknown(warnings);
  }
}

// Options that several programs share have their ranges in problems(Options). Those ranges are left
// open here, so that a bad value is reported once.
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
      static_cast<Predicates>(reader->choice("predicates", {"exact", "conservative"}, 0));
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
    reader->addProblem("tolerance_m", "is above 0, which is not supported with motion: swept");
  }
  p->swept_tolerance_m = reader->number("swept_tolerance_m", p->swept_tolerance_m, 0, 1);
  o.near_pairs = reader->flag("near_pairs", o.near_pairs);
  o.geometry = reader->flag("contact_geometry", o.geometry);
  p->containment = reader->flag("containment", p->containment);
  p->cuda.warm_up = o;
  p->cuda.warm_up.motion = p->motion;
  p->cuda.warm_up.nearest = true;  // as in every cycle (CycleDetection)
}

// Reads rates, times, and what limits messages and markers.
void readOutput(ParameterReader* reader, MonitorParameters* p) {
  constexpr int kMaxCount = 1000000000;
  constexpr int kMostMarkerTriangles = 5000000;  // 600 MB; roscpp rejects messages above 1 GB
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

// Returns the shortest decimal number that rounds to this float32. Nine digits always suffice.
double toDecimal(float number) {
  double decimal = number;
  for (int digits = 6; digits <= 9; ++digits) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.*g", digits, static_cast<double>(number));
    decimal = std::strtod(text, nullptr);
    if (static_cast<float>(decimal) == number) break;
  }
  return decimal;
}

}  // namespace

BodyStatus bodyOf(const ObjectParameters& object) {
  BodyStatus body;
  body.name = object.name;
  body.kind = BodyKind::kDeformable;
  if (object.parts.empty()) return body;
  body.parts = std::make_shared<const BodyParts>(partsOf(object.parts));
  return body;
}

BodyParts partsOf(const std::vector<PartParameters>& given) {
  BodyParts parts;
  for (const PartParameters& part : given) {
    parts.names.push_back(part.name);
    if (part.margin_m) parts.margins_m[static_cast<PartId>(parts.names.size())] = *part.margin_m;
  }
  return parts;
}

// Either parameter leaves pairs undecided, or decides them within a tolerance.
bool tradesAccuracy(const MonitorParameters& parameters) {
  return parameters.detector.tolerance_m > 0 || parameters.budget_ms > 0;
}

std::vector<RobotParameters> MonitorParameters::allRobots() const {
  if (!robots.empty()) return robots;
  return {{robot_description, "", srdf}};
}

double linkMarginM(const MonitorParameters& parameters, const std::string& link) {
  const auto own = parameters.link_margin_m.find(link);
  return own == parameters.link_margin_m.end() ? parameters.margin_m : own->second;
}

// Goes on after a problem, so that a user sees all of them after one start.
MonitorParameters parseParameters(const XmlRpc::XmlRpcValue& tree,
                                  std::vector<std::string>* warnings) {
  std::vector<std::string> found;
  ParameterReader reader(tree, "~", &found);
  MonitorParameters p;
  p.reference_frame = frame(&reader, "reference_frame", p.reference_frame);
  readRobot(&reader, warnings, &p);
  readObjects(&reader, warnings, &p);
  readPairs(&reader, warnings, &p);
  readDetector(&reader, &p);
  readOutput(&reader, &p);
  checkParts(p, &reader);
  checkRadii(p, &reader);
  warnOfUnusedRigids(p, warnings);
  for (const std::string& problem : problems(p.detector)) found.push_back("~" + problem);
  reader.warnOfUnknown(warnings);
  p.changed = reader.changed();
  if (found.empty()) return p;
  // Warnings are part of the text: a misspelled name often explains a problem.
  std::string all =
      std::to_string(found.size()) + " bad parameter(s), see config/contact_monitor.yaml:";
  for (const std::string& problem : found) all += "\n  " + problem;
  for (const std::string& warning : *warnings) all += "\n  " + warning;
  throw ParameterError(all);
}

std::vector<std::string> writeMarginsAsNumbers(XmlRpc::XmlRpcValue* tree) {
  std::vector<std::string> changed;
  if (tree->hasMember("link_margin_m")) {
    if (replaceTextsByNumbers(&(*tree)["link_margin_m"])) changed.push_back("link_margin_m");
  }
  if (tree->hasMember("objects")) {
    XmlRpc::XmlRpcValue& objects = (*tree)["objects"];
    bool is_changed = false;
    for (int i = 0; i < objects.size(); ++i) {
      const auto replaceMargin = [&is_changed](XmlRpc::XmlRpcValue& of) {
        if (of.hasMember("margin_m")) is_changed |= replaceTextByNumber(&of["margin_m"]);
      };
      replaceMargin(objects[i]);
      if (!objects[i].hasMember("parts")) continue;
      XmlRpc::XmlRpcValue& parts = objects[i]["parts"];
      for (int k = 0; k < parts.size(); ++k) replaceMargin(parts[k]);
    }
    if (is_changed) changed.push_back("objects");
  }
  return changed;
}

void requireOwnTopics(const std::vector<ObjectParameters>& objects,
                      const std::function<std::string(const ObjectParameters&)>& topic_of) {
  std::map<std::string, std::string> names;  // by topic
  std::string problems;
  for (const ObjectParameters& object : objects) {
    const auto [other, is_new] = names.emplace(topic_of(object), object.name);
    if (is_new) continue;
    problems += (problems.empty() ? "" : "\n") + ("objects '" + other->second + "' and '") +
                object.name + "' have one topic, " + other->first +
                "; give each object a topic of its own";
  }
  if (!problems.empty()) throw ParameterError(problems);
}

LiveParameters startValues(const MonitorParameters& parameters) {
  LiveParameters live;
  live.margin_m = toDecimal(parameters.margin_m);
  live.near_pairs = parameters.detector.near_pairs;
  live.max_rate_hz = parameters.max_rate_hz;
  live.robot_rate_hz = parameters.robot_rate_hz;
  live.marker_rate_hz = parameters.marker_rate_hz;
  live.pair_classes = parameters.pair_classes;
  live.predicates = parameters.detector.predicates;
  live.overlap = toDecimal(parameters.detector.overlap);
  live.clusters = parameters.detector.clusters;
  live.iterations = parameters.detector.iterations;
  live.refresh_period = parameters.detector.refresh_period;
  return live;
}

// All objects have the same limit; the robot's cycles have their own.
std::vector<double> maxRatesHz(const LiveParameters& live, std::size_t objects) {
  std::vector<double> rates_hz(objects, live.max_rate_hz);
  rates_hz.push_back(live.robot_rate_hz);
  return rates_hz;
}

void setOptions(const LiveParameters& live, Options* options) {
  options->near_pairs = live.near_pairs;
  options->predicates = live.predicates;
  options->overlap = static_cast<float>(live.overlap);
  options->clusters = live.clusters;
  options->iterations = live.iterations;
  options->refresh_period = live.refresh_period;
}

}  // namespace deformable_contact_monitor
