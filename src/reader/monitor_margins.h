// The margins of a running monitor, from its parameters. ~contact_states does not say them.
#pragma once

#if __cplusplus < 201703L
#error "deformable_contact_monitor needs C++17: set(CMAKE_CXX_STANDARD 17)"
#endif

#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/ContactStates.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <cstddef>
#include <map>
#include <sstream>
#include <string>

namespace deformable_contact_monitor {

// The margin of single bodies and parts, and the common margin of all others [m]. An object whose
// parts have margins of their own has the least of them here: to this distance its NONE is certain.
struct MonitorMargins {
  double common_m = 0;
  std::map<std::string, double> own_m;

  double of(const std::string& body) const {
    const auto found = own_m.find(body);
    if (found != own_m.end()) return found->second;
    // A part without a margin of its own, such as "cloth:hem", has that of its object.
    const auto whole = own_m.find(body.substr(0, body.rfind(':')));
    return whole == own_m.end() ? common_m : whole->second;
  }
  // Returns the margin of a pair, the larger one of its two bodies.
  double of(const ContactState& state) const {
    return std::max(of(state.body_a), of(state.body_b));
  }
};

// Adds the margins of links. In a name with a slash, such as left/hand, the slash may divide maps:
// the parameter server makes {left: {hand: 1}} of {left/hand: 1}. `numberOf` reads a value of a
// map.
template <typename NumberOf>
void addLinkMargins(XmlRpc::XmlRpcValue& links, const std::string& prefix, const NumberOf& numberOf,
                    MonitorMargins* margins) {
  for (auto& [name, value] : links) {
    if (value.getType() == XmlRpc::XmlRpcValue::TypeStruct) {
      addLinkMargins(value, prefix + name + "/", numberOf, margins);
    } else {
      margins->own_m[prefix + name] = numberOf(links, name, margins->common_m);
    }
  }
}

// Reads margins from the private parameters of a monitor, as the parameter server returns them. A
// value of a wrong type is ignored, because a monitor does not start with it.
inline MonitorMargins marginsOf(XmlRpc::XmlRpcValue parameters) {
  using XmlRpc::XmlRpcValue;
  const auto numberOf = [](XmlRpcValue& map, const std::string& name, double fallback) {
    if (!map.hasMember(name)) return fallback;
    const XmlRpcValue& value = map[name];
    if (value.getType() == XmlRpcValue::TypeInt) {
      return static_cast<double>(static_cast<const int&>(value));
    }
    const bool is_number = value.getType() == XmlRpcValue::TypeDouble;
    return is_number ? static_cast<const double&>(value) : fallback;
  };
  MonitorMargins margins;
  if (parameters.getType() != XmlRpcValue::TypeStruct) return margins;
  margins.common_m = numberOf(parameters, "margin_m", 0);
  XmlRpcValue& links = parameters["link_margin_m"];
  if (links.getType() == XmlRpcValue::TypeStruct) addLinkMargins(links, "", numberOf, &margins);
  XmlRpcValue& objects = parameters["objects"];
  if (objects.getType() != XmlRpcValue::TypeArray) return margins;
  for (int i = 0; i < objects.size(); ++i) {
    XmlRpcValue& object = objects[i];
    if (object.getType() != XmlRpcValue::TypeStruct || !object.hasMember("name")) continue;
    const XmlRpcValue& name = object["name"];
    if (name.getType() != XmlRpcValue::TypeString) continue;
    const std::string& object_name = static_cast<const std::string&>(name);
    const double own_m = numberOf(object, "margin_m", margins.common_m);
    double& least_m = margins.own_m[object_name] = own_m;
    XmlRpcValue& parts = object["parts"];
    for (int k = 0; parts.getType() == XmlRpcValue::TypeArray && k < parts.size(); ++k) {
      XmlRpcValue& part = parts[k];
      if (part.getType() != XmlRpcValue::TypeStruct || !part.hasMember("name")) continue;
      const XmlRpcValue& part_name = part["name"];
      if (part_name.getType() != XmlRpcValue::TypeString) continue;
      const double part_m = numberOf(part, "margin_m", own_m);
      margins.own_m[object_name + ":" + static_cast<const std::string&>(part_name)] = part_m;
      least_m = std::min(least_m, part_m);
    }
  }
  return margins;
}

// Returns which pairs have a margin below a distance, in words: "2 pair(s), such as hand and cloth
// (0.05 m)"; empty: none. Leaves out pairs that are ALLOWED, or for which `counts` returns false.
// Compares in float32, as the monitor keeps margins.
template <typename Counts>
std::string pairsBelow(double distance_m, const MonitorMargins& margins,
                       const ContactStates& states, const Counts& counts) {
  std::size_t count = 0;
  std::ostringstream first;
  for (const ContactState& state : states.states) {
    const double margin_m = margins.of(state);
    if (state.state == ContactState::ALLOWED || !counts(state) ||
        static_cast<float>(margin_m) >= static_cast<float>(distance_m)) {
      continue;
    }
    if (++count == 1) first << state.body_a << " and " << state.body_b << " (" << margin_m << " m)";
  }
  return count == 0 ? "" : std::to_string(count) + " pair(s), such as " + first.str();
}

}  // namespace deformable_contact_monitor
