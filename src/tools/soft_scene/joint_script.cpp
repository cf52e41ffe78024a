// A motion of a robot that a file tells.
#include "tools/soft_scene/joint_script.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/common/yaml_parameters.h"

namespace deformable_contact_monitor {
namespace {

using XmlRpc::XmlRpcValue;

// Throws what the constructor promises.
[[noreturn]] void refuseScript(const std::string& path, const std::string& what) {
  throw std::runtime_error(path + ": " + what);
}

double numberOf(const XmlRpcValue& value) {
  XmlRpcValue copy = value;  // older XmlRpcValues have no const conversions
  if (copy.getType() == XmlRpcValue::TypeInt) return static_cast<int>(copy);
  if (copy.getType() == XmlRpcValue::TypeDouble) return static_cast<double>(copy);
  return std::nan("");
}

// Returns the list of that name; an empty one if there is none.
std::vector<XmlRpcValue> listOf(const std::string& path, XmlRpcValue* script,
                                const std::string& name) {
  std::vector<XmlRpcValue> list;
  if (!script->hasMember(name)) return list;
  XmlRpcValue& value = (*script)[name];
  if (value.getType() != XmlRpcValue::TypeArray) refuseScript(path, name + " is not a list");
  for (int i = 0; i < value.size(); ++i) list.push_back(value[i]);
  return list;
}

// Reads a hold: [time], or [time, radius, links...].
ScriptedHold readHold(const std::string& path, XmlRpcValue entry) {
  const std::string wanted = "each hold is [time], or [time, radius, link, ...]";
  if (entry.getType() != XmlRpcValue::TypeArray || entry.size() < 1 || entry.size() == 2) {
    refuseScript(path, wanted);
  }
  ScriptedHold hold;
  hold.time_s = numberOf(entry[0]);
  if (entry.size() > 1) hold.radius_m = numberOf(entry[1]);
  for (int i = 2; i < entry.size(); ++i) {
    if (entry[i].getType() != XmlRpcValue::TypeString) refuseScript(path, wanted);
    hold.links.push_back(static_cast<std::string>(entry[i]));
  }
  const bool is_radius = hold.links.empty() || hold.radius_m > 0;
  if (!(hold.time_s >= 0) || !is_radius || !std::isfinite(hold.radius_m)) {
    refuseScript(path, wanted + ", with a time from 0 on and a radius above 0");
  }
  return hold;
}

}  // namespace

JointScript::JointScript(const std::string& path) {
  XmlRpcValue script = readYamlParameters(path);
  if (script.getType() != XmlRpcValue::TypeStruct) refuseScript(path, "is not a map");
  for (const auto& member : script) {
    const std::string& name = member.first;
    if (name != "joints" && name != "points" && name != "hold" && name != "loop") {
      refuseScript(path, "'" + name + "' is not one of joints, points, hold, loop");
    }
  }
  for (XmlRpcValue& name : listOf(path, &script, "joints")) {
    if (name.getType() != XmlRpcValue::TypeString) refuseScript(path, "joints are names");
    names_.push_back(static_cast<std::string>(name));
  }
  for (XmlRpcValue& entry : listOf(path, &script, "points")) {
    const int wanted = static_cast<int>(names_.size()) + 1;
    Point point{-1, {}};
    const bool is_list = entry.getType() == XmlRpcValue::TypeArray && entry.size() == wanted;
    for (int i = 0; is_list && i < wanted; ++i) {
      const double number = numberOf(entry[i]);
      if (!std::isfinite(number)) refuseScript(path, "a point has something that is no number");
      if (i == 0) point.time_s = number;
      if (i > 0) point.positions.push_back(number);
    }
    const double last = points_.empty() ? -1 : points_.back().time_s;
    if (!is_list || point.time_s < 0 || point.time_s <= last) {
      refuseScript(path, "each point is a time, from 0 on and ascending, and " +
                             std::to_string(names_.size()) + " positions");
    }
    points_.push_back(point);
  }
  if (names_.empty() || points_.empty()) refuseScript(path, "needs joints and points");
  for (const XmlRpcValue& entry : listOf(path, &script, "hold")) {
    holds_.push_back(readHold(path, entry));
    const std::size_t n = holds_.size();
    if (n > 1 && holds_[n - 1].time_s < holds_[n - 2].time_s) {
      refuseScript(path, "the times of hold do not ascend");
    }
  }
  if (!script.hasMember("loop")) return;
  if (script["loop"].getType() != XmlRpcValue::TypeBoolean) refuseScript(path, "loop is a boolean");
  loops_ = static_cast<bool>(script["loop"]) && points_.back().time_s > 0;
}

double JointScript::inTheScript(double time_s) const {
  return loops_ ? std::fmod(time_s, points_.back().time_s) : time_s;
}

// Between two points the motion starts and ends softly, along 3 t^2 - 2 t^3.
std::vector<double> JointScript::positions(double time_s) const {
  const double now = inTheScript(time_s);
  const auto next = std::find_if(points_.begin(), points_.end(),
                                 [now](const Point& point) { return point.time_s > now; });
  if (next == points_.begin()) return points_.front().positions;
  if (next == points_.end()) return points_.back().positions;
  const Point& last = *std::prev(next);
  const double t = (now - last.time_s) / (next->time_s - last.time_s);
  const double share = t * t * (3 - 2 * t);
  std::vector<double> positions = last.positions;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    positions[i] += share * (next->positions[i] - positions[i]);
  }
  return positions;
}

std::vector<ScriptedHold> JointScript::holds(double after_s, double until_s) const {
  std::vector<ScriptedHold> result;
  double after = inTheScript(after_s);
  const double until = inTheScript(until_s);
  if (loops_ && until < after) {
    for (const ScriptedHold& hold : holds_) {
      if (hold.time_s > after) result.push_back(hold);
    }
    result.emplace_back();
    result.back().begins_again = true;
    after = -1;
  }
  for (const ScriptedHold& hold : holds_) {
    if (hold.time_s > after && hold.time_s <= until) result.push_back(hold);
  }
  return result;
}

}  // namespace deformable_contact_monitor
