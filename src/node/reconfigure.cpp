// Offers the parameters that may change while the monitor runs to dynamic_reconfigure.
#include "node/reconfigure.h"

#include <ros/console.h>

#include <cmath>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// Returns `value` if it is finite; else adds a line to `rejected` and returns `in_force`.
// dynamic_reconfigure's server clamps all other numbers to the ranges of ContactMonitor.cfg.
double usable(const char* name, double value, double in_force, std::vector<std::string>* rejected) {
  if (std::isfinite(value)) return value;
  rejected->push_back(std::string(name) + " must be finite");
  return in_force;
}

PairClasses classesOf(const ContactMonitorConfig& config) {
  return {config.robot_deformable, config.deformable_deformable, config.deformable_self,
          config.robot_self,       config.deformable_rigid,      config.robot_rigid};
}

}  // namespace

void fill(const LiveParameters& live, ContactMonitorConfig* config) {
  config->margin_m = live.margin_m;
  config->near_pairs = live.near_pairs;
  config->max_rate_hz = live.max_rate_hz;
  config->robot_rate_hz = live.robot_rate_hz;
  config->marker_rate_hz = live.marker_rate_hz;
  config->robot_deformable = live.pair_classes.robot_deformable;
  config->deformable_deformable = live.pair_classes.deformable_deformable;
  config->deformable_self = live.pair_classes.deformable_self;
  config->robot_self = live.pair_classes.robot_self;
  config->deformable_rigid = live.pair_classes.deformable_rigid;
  config->robot_rigid = live.pair_classes.robot_rigid;
  config->predicates = toString(live.predicates);
  config->overlap = live.overlap;
  config->clusters = live.clusters;
  config->iterations = live.iterations;
  config->refresh_period = live.refresh_period;
}

// Starts from the values of the request and replaces those that cannot be used.
LiveParameters fromConfig(const ContactMonitorConfig& config, const LiveParameters& in_force,
                          bool has_robot, std::vector<std::string>* rejected) {
  LiveParameters live;
  live.margin_m = usable("margin_m", config.margin_m, in_force.margin_m, rejected);
  live.near_pairs = config.near_pairs;
  live.max_rate_hz = usable("max_rate_hz", config.max_rate_hz, in_force.max_rate_hz, rejected);
  live.robot_rate_hz =
      usable("robot_rate_hz", config.robot_rate_hz, in_force.robot_rate_hz, rejected);
  live.marker_rate_hz =
      usable("marker_rate_hz", config.marker_rate_hz, in_force.marker_rate_hz, rejected);
  live.overlap = usable("overlap", config.overlap, in_force.overlap, rejected);
  live.clusters = config.clusters;
  live.iterations = config.iterations;
  live.refresh_period = config.refresh_period;
  live.predicates = in_force.predicates;
  try {
    live.predicates = toPredicates(config.predicates);
  } catch (const std::invalid_argument& error) {
    rejected->push_back(std::string("predicates: ") + error.what());
  }
  live.pair_classes = classesOf(config);
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
// force.
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
