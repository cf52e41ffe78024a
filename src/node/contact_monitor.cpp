// The monitor: how it is set up, and what its callbacks do.
#include "node/contact_monitor.h"

#include <xmlrpcpp/XmlRpcException.h>

#include <chrono>
#include <map>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "cuda/detector_choice.h"
#include "monitor/diagnostics/backend_status.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/rules/attach_object.h"
#include "monitor/time_difference.h"
#include "node/cycle_publisher.h"
#include "node/monitor_sink.h"

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

MeshMailboxes makeMeshMailboxes(const MonitorParameters& parameters) {
  MeshMailboxes mailboxes;
  for (const ObjectParameters& object : parameters.objects) mailboxes.emplace_back(object.name);
  return mailboxes;
}

// The loop dies with its thread.
std::thread startThread(Mailbox& mailbox, std::unique_ptr<DetectionLoop> loop) {
  return std::thread([&mailbox, loop = std::move(loop)] {
    SteadyTime wake_time = std::chrono::steady_clock::now();
    while (mailbox.wait(wake_time)) wake_time = loop->step();
  });
}

}  // namespace

ContactMonitor::ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      parameters_(readParameters(private_node)),
      mailbox_(parameters_.allowed_contacts),
      mesh_mailboxes_(makeMeshMailboxes(parameters_)),
      transforms_(buffer_, node),
      states_(parameters_, private_node),
      robot_source_(parameters_, node, private_node, [this] { noteRobot(); }),
      diagnostics_(parameters_, mesh_mailboxes_, robot_source_, node, private_node),
      master_watch_(private_node.resolveName("contacts")) {
  std::unique_ptr<DetectionLoop> loop = makeLoop();
  subscribeToMeshes();
  advertiseServices();
  diagnostics_timer_ = node_.createWallTimer(
      ros::WallDuration(1), [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
  ros::NodeHandle watch_node(node_);
  watch_node.setCallbackQueue(&watch_queue_);
  watch_timer_ = watch_node.createWallTimer(ros::WallDuration(1),
                                            [this](const ros::WallTimerEvent&) { lookAround(); });
  ros::NodeHandle reconfigure_node(private_node_);
  reconfigure_node.setCallbackQueue(&watch_queue_);
  reconfigure_ = std::make_unique<Reconfigure>(
      parameters_, reconfigure_node, [this](const LiveParameters& live) { mailbox_.change(live); });
  watch_spinner_.start();
  thread_ = startThread(mailbox_, std::move(loop));
  states_thread_ = std::thread([this] { keepStatesFresh(); });
}

ContactMonitor::~ContactMonitor() {
  watch_timer_.stop();
  watch_spinner_.stop();
  robot_source_.stop();
  reload_spinner_.stop();
  diagnostics_timer_.stop();
  mailbox_.stop();
  thread_.join();
  states_thread_.join();
}

// A state becomes too old at a time of the ROS clock, which may run fast or jump: it is looked at.
void ContactMonitor::keepStatesFresh() {
  constexpr std::chrono::milliseconds kPeriod(10);
  while (!mailbox_.stopped()) {
    states_.beat(diagnostics_.whySilent());
    std::this_thread::sleep_for(kPeriod);
  }
}

// Once a second, in the thread that may wait for the ROS master.
void ContactMonitor::lookAround() {
  try {
    warnOfInputs();
    lookAtMaster();
  } catch (const XmlRpc::XmlRpcException& error) {
    ROS_WARN_STREAM("the ROS master's answer cannot be read: " << error.getMessage());
  }
}

void ContactMonitor::warnOfInputs() {
  if (!diagnostics_.isEnabled()) return;
  const std::map<std::string, std::string> types = publishedTypes();
  std::vector<InputStatus> inputs;
  for (std::size_t i = 0; i < subscribers_.size(); ++i) {
    InputStatus input;
    input.object = parameters_.objects[i].name;
    input.topic = subscribers_[i].getTopic();
    input.wanted_type = messageType(parameters_.objects[i].type);
    input.required = parameters_.objects[i].required;
    input.received = mesh_mailboxes_[i].counters().received;
    std::tie(input.refusal, input.oddity) = diagnostics_.meshProblems(i);
    input.publishers = subscribers_[i].getNumPublishers();
    const auto type = types.find(input.topic);
    if (type != types.end()) input.type = type->second;
    inputs.push_back(std::move(input));
  }
  for (const std::string& warning : input_warnings_.look(
           inputs, ros::Time::now(), ros::Time::isSimTime(), std::chrono::steady_clock::now())) {
    ROS_WARN_STREAM(warning);
  }
}

void ContactMonitor::lookAtMaster() {
  constexpr std::chrono::seconds kPeriod(3);
  const auto now = std::chrono::steady_clock::now();
  if (now < master_due_) return;
  master_due_ = now + kPeriod;
  if (!master_watch_.isForgotten()) return;
  ROS_ERROR(
      "the ROS master was started anew and does not know this node: nobody finds its topics. Load "
      "its parameters there and start it again");
  diagnostics_.recordForgotten();
  is_forgotten_ = true;
}

std::unique_ptr<DetectionLoop> ContactMonitor::makeLoop() {
  auto publisher = std::make_unique<CyclePublisher>(parameters_, private_node_, states_, latest_);
  return std::make_unique<DetectionLoop>(
      parameters_,
      LoopSources{mailbox_, mesh_mailboxes_, buffer_, [this] { return robot_source_.newest(); }},
      LoopTime{std::chrono::steady_clock::now, ros::Time::now},
      makeDetector(
          parameters_.backend, WithoutCuda::kTryAgain, parameters_.cuda,
          [this](const BackendState& state) { noteBackend(state); },
          tradesAccuracy(parameters_) ? std::make_shared<TilingCache>() : nullptr),
      std::make_unique<MonitorSink>(std::move(publisher), diagnostics_));
}

// Called by the detector: at first here, then by the detection thread.
void ContactMonitor::noteBackend(const BackendState& state) {
  diagnostics_.recordBackend(state);
  const BackendStatus status = backendStatus(parameters_.backend, state);
  if (status.level == diagnostic_msgs::DiagnosticStatus::ERROR) {
    ROS_ERROR_STREAM(status.summary);
  } else if (!status.summary.empty()) {
    ROS_WARN_STREAM(status.summary);
  } else {
    ROS_INFO("contacts are found with CUDA again");
  }
}

void ContactMonitor::subscribeToMeshes() {
  for (std::size_t i = 0; i < mesh_mailboxes_.size(); ++i) {
    const ObjectParameters& object = parameters_.objects[i];
    const MeshReceiver store = [this, i](const ReceivedMesh& mesh) {
      const bool is_first =
          mesh.stamped_on_receipt && mesh_mailboxes_[i].counters().stamped_on_receipt == 0;
      if (is_first) {
        ROS_WARN_STREAM("object '" << parameters_.objects[i].name
                                   << "': its messages have no stamp and are stamped on receipt, "
                                      "so the time that they were under way is not seen");
      }
      mesh_mailboxes_[i].store(mesh);
      mailbox_.wake();
    };
    const bool is_private = object.topic.empty() || object.topic.front() == '~';
    const std::string topic = object.topic.empty() ? "objects/" + object.name + "/mesh"
                              : is_private         ? object.topic.substr(1)
                                                   : object.topic;
    ros::SubscribeOptions options = meshSubscription(topic, object, parameters_.max_mesh_bytes,
                                                     store, [this] { mailbox_.expect(); });
    subscribers_.push_back((is_private ? private_node_ : node_).subscribe(options));
  }
}

void ContactMonitor::advertiseServices() {
  ros::NodeHandle reload_node(private_node_);
  reload_node.setCallbackQueue(&reload_queue_);
  services_ = {private_node_.advertiseService("set_allowed_contacts",
                                              &ContactMonitor::setAllowedContacts, this),
               private_node_.advertiseService("attach_object", &ContactMonitor::attachObject, this),
               private_node_.advertiseService("get_contacts", &ContactMonitor::getContacts, this),
               private_node_.advertiseService("set_enabled", &ContactMonitor::setEnabled, this),
               private_node_.advertiseService("reset", &ContactMonitor::requestReset, this),
               reload_node.advertiseService("reload_robot", &ContactMonitor::reloadRobot, this)};
  reload_spinner_.start();
}

bool ContactMonitor::setAllowedContacts(SetAllowedContacts::Request& request,
                                        SetAllowedContacts::Response& response) {
  try {
    response.rules =
        mailbox_.changeAllowedContacts({request.replace != 0, request.remove, request.rules});
  } catch (const std::invalid_argument& error) {
    ROS_ERROR_STREAM("~set_allowed_contacts: " << error.what() << "; no rule was changed");
    return false;
  }
  return true;
}

bool ContactMonitor::attachObject(AttachObject::Request& request,
                                  AttachObject::Response& response) {
  response.message = attachProblem(request.object, request.links, parameters_.objects,
                                   robot_source_.newest().get());
  response.success = response.message.empty();
  if (response.success) {
    response.message = describeHeld(mailbox_.attach(request.object, request.links));
    ROS_INFO_STREAM(response.message);
  } else {
    ROS_ERROR_STREAM("~attach_object: " << response.message << "; nothing was changed");
  }
  return true;
}

// Another robot may lack links of the one before.
void ContactMonitor::noteRobot() {
  for (const std::string& held : mailbox_.releaseFromOthers(robot_source_.newest()->link_names)) {
    ROS_WARN_STREAM("the robot has changed and lacks a link that held something: " << held);
  }
  mailbox_.wake();
}

bool ContactMonitor::getContacts(GetContacts::Request& /*request*/,
                                 GetContacts::Response& response) {
  response.states = states_.states();
  const boost::shared_ptr<const ContactArray> latest = latest_.get();
  response.available = latest != nullptr;
  if (!response.available) return true;
  response.contacts = *latest;
  response.age = toDuration(secondsBetween(ros::Time::now(), latest->header.stamp));
  return true;
}

bool ContactMonitor::setEnabled(std_srvs::SetBool::Request& request,
                                std_srvs::SetBool::Response& response) {
  mailbox_.setEnabled(request.data);
  response.success = true;
  response.message = request.data ? "enabled" : "disabled: every pair is UNKNOWN";
  return true;
}

bool ContactMonitor::requestReset(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  mailbox_.requestReset();
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
