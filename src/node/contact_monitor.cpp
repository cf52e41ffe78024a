// The monitor: how it is set up, and what its callbacks store.
#include "node/contact_monitor.h"

#include <utility>

#include "node/time_difference.h"

namespace deformable_contact_monitor {
namespace {

MonitorParameters readParameters(const ros::NodeHandle& private_node) {
  XmlRpc::XmlRpcValue tree;
  ros::param::get(private_node.getNamespace(), tree);
  std::vector<std::string> warnings;
  MonitorParameters parameters = parseParameters(tree, &warnings);
  for (const std::string& warning : warnings) ROS_WARN_STREAM(warning);
  if (parameters.objects.empty()) {
    ROS_WARN("~objects is empty: there is nothing to monitor");
  }
  return parameters;
}

MeshInputs makeInputs(const MonitorParameters& parameters) {
  MeshInputs inputs;
  for (const ObjectParameters& object : parameters.objects) {
    inputs.push_back(std::make_unique<MeshInput>(object.name, parameters.max_mesh_age_s));
  }
  return inputs;
}

}  // namespace

ContactMonitor::ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      parameters_(readParameters(private_node)),
      inputs_(makeInputs(parameters_)),
      listener_(buffer_, node, true, ros::TransportHints().tcpNoDelay()),
      lookup_(buffer_, parameters_.reference_frame, parameters_.tf_timeout_s),
      robot_source_(parameters_, node, private_node, [this] { wake(); }),
      publisher_(parameters_, private_node),
      diagnostics_(parameters_, inputs_, robot_source_, node, private_node),
      scene_(parameters_),
      detector_(makeDetectorFor(parameters_.backend, parameters_.cuda,
                                [](const std::string& why) { ROS_WARN_STREAM(why); })) {
  allowed_ = parameters_.allowed_contacts;
  subscribeToMeshes();
  advertiseServices();
  diagnostics_timer_ = node_.createWallTimer(
      ros::WallDuration(1), [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
  thread_ = std::thread(&ContactMonitor::run, this);
  ROS_INFO_STREAM("monitoring " << inputs_.size() << " object(s) in frame '"
                                << parameters_.reference_frame << "' on the "
                                << detector_->backend());
}

ContactMonitor::~ContactMonitor() {
  diagnostics_timer_.stop();
  stop_ = true;
  wake();
  thread_.join();
}

void ContactMonitor::subscribeToMeshes() {
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const ObjectParameters& object = parameters_.objects[i];
    const boost::function<void(const DeformableMesh::ConstPtr&)> store =
        [this, i](const DeformableMesh::ConstPtr& message) {
          inputs_[i]->store(message);
          wake();
        };
    const bool is_private = object.topic.empty() || object.topic.front() == '~';
    const std::string topic = object.topic.empty() ? "objects/" + object.name + "/mesh"
                              : is_private         ? object.topic.substr(1)
                                                   : object.topic;
    subscribers_.push_back((is_private ? private_node_ : node_)
                               .subscribe<DeformableMesh>(topic, 1, store, ros::VoidConstPtr(),
                                                          ros::TransportHints().tcpNoDelay()));
  }
}

void ContactMonitor::advertiseServices() {
  services_ = {private_node_.advertiseService("set_allowed_contacts",
                                              &ContactMonitor::setAllowedContacts, this),
               private_node_.advertiseService("get_contacts", &ContactMonitor::getContacts, this),
               private_node_.advertiseService("set_enabled", &ContactMonitor::setEnabled, this),
               private_node_.advertiseService("reset", &ContactMonitor::requestReset, this),
               private_node_.advertiseService("reload_robot", &ContactMonitor::reloadRobot, this)};
}

void ContactMonitor::wake() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    woken_ = true;
  }
  wake_.notify_one();
}

bool ContactMonitor::setAllowedContacts(SetAllowedContacts::Request& request,
                                        SetAllowedContacts::Response& response) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    AllowedContacts allowed = allowed_;
    try {
      for (const AllowedContact& rule : request.rules) allowed.add(rule);
    } catch (const std::invalid_argument& error) {
      ROS_ERROR_STREAM("~set_allowed_contacts: " << error.what() << "; no rule was changed");
      return false;
    }
    allowed_ = std::move(allowed);
    requests_.allowed_contacts = true;
    response.rules = allowed_.rules();
  }
  wake();
  return true;
}

bool ContactMonitor::getContacts(GetContacts::Request& /*request*/,
                                 GetContacts::Response& response) {
  const CyclePublisher::Latest latest = publisher_.latest();
  response.available = latest.contacts != nullptr;
  if (!response.available) return true;
  response.contacts = *latest.contacts;
  response.states = *latest.states;
  response.age = toDuration(secondsBetween(ros::Time::now(), latest.contacts->header.stamp));
  return true;
}

bool ContactMonitor::setEnabled(std_srvs::SetBool::Request& request,
                                std_srvs::SetBool::Response& response) {
  enabled_ = request.data;
  wake();
  response.success = true;
  response.message = request.data ? "enabled" : "disabled: every pair is UNKNOWN";
  return true;
}

bool ContactMonitor::requestReset(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_.reset = true;
  }
  wake();
  response.success = true;
  response.message = "meshes, transforms and contact states are forgotten";
  return true;
}

bool ContactMonitor::reloadRobot(std_srvs::Trigger::Request& /*request*/,
                                 std_srvs::Trigger::Response& response) {
  try {
    robot_source_.reload();
    response.success = true;
    response.message = "robot loaded";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
    ROS_ERROR_STREAM("~reload_robot: " << error.what() << "; the robot stays as it was");
  }
  return true;
}

}  // namespace deformable_contact_monitor
