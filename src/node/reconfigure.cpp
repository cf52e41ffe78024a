// Offers the parameters that may change while the monitor runs to dynamic_reconfigure.
#include "node/reconfigure.h"

#include <ros/console.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// Calls visit(name, value, its field of the config) for each parameter but the predicates, which
// are a text there.
template <class Live, class Config, class Visit>
void forEach(Live& live, Config& config, const Visit& visit) {
  auto& classes = live.pair_classes;
  visit("margin_m", live.margin_m, config.margin_m);
  visit("near_pairs", live.near_pairs, config.near_pairs);
  visit("max_rate_hz", live.max_rate_hz, config.max_rate_hz);
  visit("robot_rate_hz", live.robot_rate_hz, config.robot_rate_hz);
  visit("marker_rate_hz", live.marker_rate_hz, config.marker_rate_hz);
  visit("robot_deformable", classes.robot_deformable, config.robot_deformable);
  visit("deformable_deformable", classes.deformable_deformable, config.deformable_deformable);
  visit("deformable_self", classes.deformable_self, config.deformable_self);
  visit("robot_self", classes.robot_self, config.robot_self);
  visit("deformable_rigid", classes.deformable_rigid, config.deformable_rigid);
  visit("robot_rigid", classes.robot_rigid, config.robot_rigid);
  visit("overlap", live.overlap, config.overlap);
  visit("clusters", live.clusters, config.clusters);
  visit("iterations", live.iterations, config.iterations);
  visit("refresh_period", live.refresh_period, config.refresh_period);
}

}  // namespace

void fill(const LiveParameters& live, ContactMonitorConfig* config) {
  forEach(live, *config, [](const char*, const auto& value, auto& field) { field = value; });
  config->predicates = toString(live.predicates);
}

// Keeps the values in force where those of the request cannot be used. dynamic_reconfigure's server
// clamps finite numbers to the ranges of ContactMonitor.cfg.
LiveParameters fromConfig(const ContactMonitorConfig& config, const LiveParameters& in_force,
                          bool has_robot, std::vector<std::string>* rejected) {
  LiveParameters live = in_force;
  forEach(live, config, [rejected](const char* name, auto& value, const auto& field) {
    if (std::isfinite(static_cast<double>(field))) {
      value = field;
    } else {
      rejected->push_back(std::string(name) + " must be finite");
    }
  });
  try {
    live.predicates = toPredicates(config.predicates);
  } catch (const std::invalid_argument& error) {
    rejected->emplace_back(error.what());
  }
  if (!has_robot && live.pair_classes.needRobot()) {
    rejected->push_back(
        "robot_deformable, robot_self and robot_rigid need the robot, which is loaded at start "
        "only if one of them is in ~pair_classes; add it there and restart the node");
    live.pair_classes = in_force.pair_classes;
  }
  return live;
}

// The classes are flags here, but a list (pair_classes) among the parameters. change() keeps that
// list up to date as well, so that a dump of the parameters and a restarted node have the values in
// force. If all are off, a restarted node has the default, as the empty list means that.
Reconfigure::Reconfigure(const MonitorParameters& parameters, const ros::NodeHandle& private_node,
                         std::function<void(const LiveParameters&)> apply)
    : private_node_(private_node),
      apply_(std::move(apply)),
      has_robot_(parameters.pair_classes.needRobot()),
      in_force_(startValues(parameters)) {
  ContactMonitorConfig first;
  fill(in_force_, &first);
  first.__toServer__(private_node_);
  server_ = std::make_unique<dynamic_reconfigure::Server<ContactMonitorConfig>>(private_node_);
  server_->setCallback([this](ContactMonitorConfig& config, std::uint32_t level) {
    constexpr std::uint32_t kAtStart = ~std::uint32_t{0};
    if (level != kAtStart) change(&config);
  });
}

// Writes the values in force back to `config`, which is the answer of the service.
void Reconfigure::change(ContactMonitorConfig* config) {
  std::vector<std::string> rejected;
  const LiveParameters live = fromConfig(*config, in_force_, has_robot_, &rejected);
  for (const std::string& line : rejected) {
    ROS_ERROR_STREAM("~set_parameters: " << line << "; see config/README.md#while-it-runs");
  }
  if (!(live.pair_classes == in_force_.pair_classes)) {
    private_node_.setParam("pair_classes", namesOf(live.pair_classes));
  }
  in_force_ = live;
  apply_(live);
  fill(live, config);
}

}  // namespace deformable_contact_monitor
