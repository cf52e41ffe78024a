// Sets the monitor up and implements its callbacks.
//
// The constructor first makes what can fail (parameters, robot, detector), then subscribes,
// advertises and starts the threads. The destructor stops whoever calls into shared members before
// these go.
#include "node/contact_monitor.h"

#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "cuda/detector_choice.h"
#include "monitor/diagnostics/start_block.h"
#include "monitor/diagnostics/watches.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/rules/rule_texts.h"
#include "monitor/time_difference.h"
#include "node/cycle_publisher.h"

namespace deformable_contact_monitor {
namespace {

// Reads all parameters of the private namespace at once. Warns of names that nothing reads.
MonitorParameters readParameters(const ros::NodeHandle& private_node) {
  XmlRpc::XmlRpcValue tree;
  ros::param::get(private_node.getNamespace(), tree);
  std::vector<std::string> warnings;
  MonitorParameters parameters = parseParameters(tree, &warnings);
  for (const std::string& name : writeMarginsAsNumbers(&tree)) {
    private_node.setParam(name, tree[name]);
  }
  for (const std::string& warning : warnings) {
    ROS_WARN_STREAM(warning << "; see config/README.md#all-parameters");
  }
  if (parameters.objects.empty() && parameters.rigids.empty()) {
    ROS_WARN(
        "~objects is empty, so no object is monitored; list objects with their topics there; see "
        "config/README.md#objects");
  }
  return parameters;
}

// Asks the master for /use_sim_time only where roscpp did not find it at the start.
ClockStatus clockStatus() {
  ClockStatus clock{ros::Time::now(), ros::Time::isSimTime()};
  if (!clock.is_simulated) ros::param::get("/use_sim_time", clock.is_sim_time_set);
  return clock;
}

// Runs the loop until it is asked to stop. The thread owns the loop, which ends with it.
std::thread startThread(LoopRequests& requests, std::unique_ptr<DetectionLoop> loop) {
  return std::thread([&requests, loop = std::move(loop)] {
    SteadyTime wake_time = std::chrono::steady_clock::now();
    while (requests.wait(wake_time)) wake_time = loop->step();
  });
}

}  // namespace

// Members are made in the order of their declaration. Callbacks may arrive as soon as something is
// subscribed or advertised, so everything that they use exists by then.
ContactMonitor::ContactMonitor(const ros::NodeHandle& node, const ros::NodeHandle& private_node)
    : node_(node),
      private_node_(private_node),
      parameters_(readParameters(private_node)),
      requests_(parameters_.allowed_contacts),
      meshes_(makeMeshInputs(parameters_)),
      buffer_(ros::Time::now, parameters_.maxTransformGapS()),
      transforms_(buffer_, node),
      states_(parameters_, private_node),
      robot_source_(parameters_, node, private_node, [this] { noteRobot(); }),
      diagnostics_(parameters_, meshes_, robot_source_, node, private_node),
      master_watch_(private_node.resolveName("contacts")) {
  // Making the loop makes the detector, which may fail. The detection thread does not run yet.
  std::unique_ptr<DetectionLoop> loop = makeLoop();
  subscribeToMeshes();
  advertiseServices();
  diagnostics_timer_ = node_.createWallTimer(
      ros::WallDuration(1), [this](const ros::WallTimerEvent&) { diagnostics_.publish(); });
  ros::NodeHandle watch_node(node_);
  watch_node.setCallbackQueue(&watch_queue_);
  watch_timer_ = watch_node.createWallTimer(
      ros::WallDuration(1), [this](const ros::WallTimerEvent&) { checkInputsAndMaster(); });
  ros::NodeHandle reconfigure_node(private_node_);
  reconfigure_node.setCallbackQueue(&watch_queue_);
  reconfigure_ = std::make_unique<Reconfigure>(parameters_, reconfigure_node,
                                               [this](const LiveParameters& live) {
                                                 diagnostics_.recordMaxRate(live.max_rate_hz);
                                                 requests_.change(live);
                                               });
  watch_spinner_.start();
  thread_ = startThread(requests_, std::move(loop));
  states_thread_ = std::thread([this] { keepStatesFresh(); });
}

// Timers and spinners stop first, because their callbacks use the mailbox and the diagnostics. The
// robot source ends a reload that runs, which its spinner would wait for.
ContactMonitor::~ContactMonitor() {
  watch_timer_.stop();
  watch_spinner_.stop();
  robot_source_.stop();
  reload_spinner_.stop();
  attach_spinner_.stop();
  diagnostics_timer_.stop();
  requests_.stop();
  state_service_->stop();
  thread_.join();
  states_thread_.join();
}

// Polls, because a state gets too old at a time of the ROS clock, which may run fast or jump.
void ContactMonitor::keepStatesFresh() {
  constexpr std::chrono::milliseconds kPeriod(10);
  while (!requests_.stopped()) {
    states_.beat(diagnostics_.whySilent());
    std::this_thread::sleep_for(kPeriod);
  }
}

// Runs once a second in the thread that may wait for the ROS master.
void ContactMonitor::checkInputsAndMaster() {
  try {
    lookAtInputs();
    transforms_.dropStaticsOfThoseGone();
    checkMaster();
  } catch (const XmlRpc::XmlRpcException& error) {
    ROS_WARN_STREAM("the answer of the ROS master cannot be read: "
                    << error.getMessage() << "; see config/docs/console.md#the-ros-master");
  }
}

// The block is shown once the first meshes and transforms have had time to come. A disabled monitor
// ignores its meshes, so it does not warn.
void ContactMonitor::lookAtInputs() {
  const std::vector<InputStatus> inputs = inputStatuses();
  if (!std::exchange(is_started_, true)) showStart(inputs);
  if (!diagnostics_.isEnabled()) return;
  for (const std::string& warning :
       input_warnings_.look(inputs, clockStatus(), std::chrono::steady_clock::now())) {
    ROS_WARN_STREAM(warning << "; see config/docs/console.md#no-mesh-or-a-strange-one");
  }
}

// Shows what is watched, how, and what is still missing.
void ContactMonitor::showStart(const std::vector<InputStatus>& inputs) {
  const std::shared_ptr<const RobotGeometry> robot = robot_source_.newest();
  StartFacts facts{robot.get(), {}, backend_, backend_problem_, missingInputs(inputs)};
  for (const InputStatus& input : inputs) facts.topics.push_back(input.topic);
  if (ros::Time::isSimTime() && ros::Time::now().isZero()) {
    facts.missing.push_back("a time on /clock (use_sim_time is true)");
  }
  for (const std::string& line : missingTransforms(parameters_, robot.get(), buffer_)) {
    facts.missing.push_back(line);
  }
  if (robot == nullptr && parameters_.pair_classes.needRobot()) {
    facts.missing.push_back("link meshes on " + private_node_.resolveName("robot_link_meshes"));
  }
  ROS_INFO_STREAM(describeStart(parameters_, facts));
}

// Collects what is known of each object's input.
std::vector<InputStatus> ContactMonitor::inputStatuses() const {
  const std::map<std::string, std::string> types = publishedTypes();
  std::vector<InputStatus> inputs;
  for (std::size_t i = 0; i < receptions_.size(); ++i) {
    const ros::Subscriber& subscriber = receptions_[i].subscriber;
    InputStatus input;
    input.object = parameters_.objects[i].name;
    input.topic = subscriber.getTopic();
    input.wanted_type = messageType(parameters_.objects[i].type);
    input.required = parameters_.objects[i].required;
    input.received = meshes_[i].counters().received;
    std::tie(input.refusal, input.anomaly) = diagnostics_.meshProblems(i);
    input.rivals = meshes_[i].rivals(std::chrono::steady_clock::now());
    input.publishers = subscriber.getNumPublishers();
    const auto type = types.find(input.topic);
    if (type != types.end()) input.type = type->second;
    inputs.push_back(std::move(input));
  }
  return inputs;
}

// Asks every 3 s, because a restarted master is rare and an answer costs the master time.
void ContactMonitor::checkMaster() {
  constexpr std::chrono::seconds kPeriod(3);
  const auto now = std::chrono::steady_clock::now();
  if (now < master_due_) return;
  master_due_ = now + kPeriod;
  if (!master_watch_.isUnregistered()) return;
  ROS_ERROR(
      "the ROS master was restarted, and this node is no longer registered with it, so nobody "
      "finds its topics. Load the node's parameters again and restart the node; see "
      "config/docs/console.md#the-ros-master");
  diagnostics_.recordUnregistered();
  is_unregistered_ = true;
}

// Gives the loop its sources, its clocks, its detector and its sink, which the loop's thread uses.
// With a tolerance or a budget, the CPU backend keeps tiles of bodies from cycle to cycle.
std::unique_ptr<DetectionLoop> ContactMonitor::makeLoop() {
  std::unique_ptr<Detector> detector = makeDetector(
      parameters_.backend, WithoutCuda::kTryAgain, parameters_.cuda,
      [this](const BackendState& state) { noteBackend(state); },
      tradesAccuracy(parameters_) ? std::make_shared<TilingCache>() : nullptr);
  backend_ = detector->backend();
  return std::make_unique<DetectionLoop>(
      parameters_,
      LoopSources{requests_, meshes_, buffer_, [this] { return robot_source_.newest(); },
                  [this] { return transforms_.describePublishers(); }},
      LoopTime{std::chrono::steady_clock::now, ros::Time::now, ros::Time::isSimTime()},
      std::move(detector),
      std::make_unique<CyclePublisher>(parameters_, private_node_, states_, diagnostics_));
}

// Is called by the detector: first in the constructor's thread, later in the detection thread. That
// `auto` finds no CUDA is known from the start on, and the block says it.
void ContactMonitor::noteBackend(const BackendState& state) {
  if (backend_.empty()) backend_problem_ = state.problem;
  diagnostics_.recordBackend(state);
  const BackendStatus status = backendStatus(parameters_.backend, state);
  if (status.level == diagnostic_msgs::DiagnosticStatus::ERROR) {
    ROS_ERROR_STREAM(status.summary << "; see config/docs/console.md#the-backend");
  } else if (status.level == diagnostic_msgs::DiagnosticStatus::WARN) {
    ROS_WARN_STREAM(status.summary << "; see config/docs/console.md#the-backend");
  } else if (status.summary.empty()) {
    ROS_INFO("contacts are computed with CUDA again");
  }
}

// A topic that begins with '~' is in the private namespace, any other relative one in the node's.
std::pair<ros::NodeHandle*, std::string> ContactMonitor::nameOf(const ObjectParameters& object) {
  if (object.topic.empty()) return {&private_node_, "objects/" + object.name + "/mesh"};
  if (object.topic.front() == '~') return {&private_node_, object.topic.substr(1)};
  return {&node_, object.topic};
}

// A mesh goes to its object's mailbox as it is; the detection thread examines it.
void ContactMonitor::subscribeToMeshes() {
  requireOwnTopics(parameters_.objects, [this](const ObjectParameters& object) {
    const auto [node, topic] = nameOf(object);
    return node->resolveName(topic);
  });
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    const ObjectParameters& object = parameters_.objects[i];
    const MeshReceiver store = [this, i](const IncomingMesh& mesh) {
      const bool is_first =
          mesh.stamped_on_receipt && meshes_[i].counters().stamped_on_receipt == 0;
      if (is_first) {
        ROS_WARN_STREAM("object '"
                        << parameters_.objects[i].name
                        << "': its messages have no stamp and are stamped on receipt, so "
                           "their transport time is not known; publish a type with a "
                           "stamp if you can; see config/README.md#objects");
      }
      meshes_[i].store(mesh);
      requests_.wake();
    };
    const auto [node, topic] = nameOf(object);
    ros::SubscribeOptions options =
        meshSubscription(topic, object, parameters_.max_mesh_bytes, store);
    MeshReception& reception = receptions_.emplace_back();
    options.callback_queue = &reception.queue;
    reception.subscriber = node->subscribe(options);
    reception.spinner.start();
  }
}

// Serves ~reload_robot, ~attach_object and ~check_states in threads of their own, all others in
// that of the callbacks.
void ContactMonitor::advertiseServices() {
  ros::NodeHandle reload_node(private_node_), attach_node(private_node_);
  reload_node.setCallbackQueue(&reload_queue_);
  attach_node.setCallbackQueue(&attach_queue_);
  services_ = {private_node_.advertiseService("set_allowed_contacts",
                                              &ContactMonitor::setAllowedContacts, this),
               attach_node.advertiseService("attach_object", &ContactMonitor::attachObject, this),
               private_node_.advertiseService("get_contacts", &ContactMonitor::getContacts, this),
               private_node_.advertiseService("set_enabled", &ContactMonitor::setEnabled, this),
               private_node_.advertiseService("reset", &ContactMonitor::requestReset, this),
               reload_node.advertiseService("reload_robot", &ContactMonitor::reloadRobot, this)};
  reload_spinner_.start();
  attach_spinner_.start();
  state_service_ = std::make_unique<StateService>(
      parameters_,
      QuestionSources{requests_, meshes_, buffer_, [this] { return robot_source_.newest(); },
                      ros::Time::now},
      makeStateChecker(parameters_.backend, WithoutCuda::kTryAgain, parameters_.cuda),
      private_node_);
}

// A failed call changes nothing. roscpp's services report failure without a text, so it is logged.
bool ContactMonitor::setAllowedContacts(SetAllowedContacts::Request& request,
                                        SetAllowedContacts::Response& response) {
  try {
    response.rules =
        requests_.changeAllowedContacts({request.replace != 0, request.remove, request.rules});
  } catch (const std::invalid_argument& error) {
    ROS_ERROR_STREAM("~set_allowed_contacts: "
                     << error.what()
                     << "; no rule was changed; see config/README.md#what-may-touch");
    return false;
  }
  return true;
}

// The answer says what holds now, or why nothing was changed.
bool ContactMonitor::attachObject(AttachObject::Request& request,
                                  AttachObject::Response& response) {
  const std::shared_ptr<const RobotGeometry> robot = robot_source_.newest();
  response.message = attachProblem(request.object, request.links, parameters_, robot.get());
  std::shared_ptr<const HeldPart> part;
  std::shared_ptr<const RigidGrip> grip;
  try {
    const RigidParameters* const rigid = findRigid(parameters_, request.object);
    const bool attaches = response.message.empty() && !request.links.empty();
    if (attaches && rigid != nullptr) grip = findGrip(request, *rigid);
    if (attaches && rigid == nullptr && request.radius != 0) {
      part = findHeld(request, robot == nullptr ? RobotGeometry() : *robot);
    }
  } catch (const std::invalid_argument& error) {
    response.message = error.what();
  }
  if (response.message.empty() && robot_source_.newest() != robot) {
    response.message = "the robot changed meanwhile; ask again";
  }
  response.success = response.message.empty();
  if (response.success) {
    response.held_triangles =
        part == nullptr ? 0 : static_cast<std::uint32_t>(part->triangles.size());
    response.message =
        describeHeld(requests_.attach(request.object, request.links, std::move(part), grip));
    ROS_INFO_STREAM(response.message);
    if (robot_source_.newest() != robot) noteRobot();  // it came in the meantime
  } else {
    ROS_ERROR_STREAM("~attach_object: "
                     << response.message
                     << "; nothing was changed; see config/README.md#what-may-touch");
  }
  return true;
}

std::shared_ptr<const RigidGrip> ContactMonitor::findGrip(const AttachObject::Request& request,
                                                          const RigidParameters& rigid) {
  const AttachedObjects attached = requests_.attached();
  const TransformLookup lookup(buffer_, parameters_.reference_frame);
  return deformable_contact_monitor::findGrip(
      {rigid, request.links.front(), attached, request.radius, ros::Time::now()}, parameters_,
      lookup);
}

// Waits for late transforms, which arrive in another thread.
std::shared_ptr<const HeldPart> ContactMonitor::findHeld(const AttachObject::Request& request,
                                                         const RobotGeometry& robot) {
  std::string problem = holdProblem(request.object, request.radius, parameters_);
  if (!problem.empty()) throw std::invalid_argument(problem);
  const auto is_asked = [&](const ObjectParameters& one) { return one.name == request.object; };
  const auto index =
      std::find_if(parameters_.objects.begin(), parameters_.objects.end(), is_asked) -
      parameters_.objects.begin();
  const std::optional<IncomingMesh> mesh =
      meshes_[static_cast<std::size_t>(index)].newest(&problem);
  if (!mesh) throw std::invalid_argument(request.object + ": " + problem);
  const double age_s = secondsBetween(ros::Time::now(), mesh->stamp());
  if (age_s > parameters_.max_mesh_age_s) {
    throw std::invalid_argument(request.object + ": its newest mesh is " + std::to_string(age_s) +
                                " s old, more than max_mesh_age_s");
  }
  const HoldQuestion question{request.object, *mesh, request.links, request.radius,
                              requests_.attached()};
  const TransformLookup lookup(buffer_, parameters_.reference_frame);
  const std::vector<FrameAtStamp> frames = framesOfHold(question, parameters_);
  const SteadyTime end = std::chrono::steady_clock::now() + fromSeconds(parameters_.tf_timeout_s);
  while (lookup.isWorthWaiting(frames) && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return findHeldPart(question, robot, parameters_, lookup);
}

// Releases objects from links that a new robot lacks.
void ContactMonitor::noteRobot() {
  const std::shared_ptr<const RobotGeometry> robot = robot_source_.newest();
  const bool is_used = robot_source_.problem().empty();
  if (is_used) ROS_INFO_STREAM("using a new robot:" << describeRobots(*robot));
  std::set<std::string> holders = robot->link_names;
  for (const RigidParameters& rigid : parameters_.rigids) holders.insert(rigid.name);
  for (const std::string& held : requests_.releaseFromOthers(holders)) {
    ROS_WARN_STREAM("the new robot lacks a link that held an object, which is released from it: "
                    << held << "; see config/README.md#what-may-touch");
  }
  requests_.wake();
}

// Answers with the states as they are now, and with the contacts of the newest cycle, if any.
bool ContactMonitor::getContacts(GetContacts::Request& /*request*/,
                                 GetContacts::Response& response) {
  response.states = states_.states();
  const boost::shared_ptr<const ContactArray> latest = states_.contacts();
  response.available = latest != nullptr;
  if (!response.available) return true;
  response.contacts = *latest;
  response.age = toDuration(secondsBetween(ros::Time::now(), latest->header.stamp));
  return true;
}

// States are UNKNOWN from the answer on, also where a cycle is running. Everything else takes
// effect when the detection thread takes the request.
bool ContactMonitor::setEnabled(std_srvs::SetBool::Request& request,
                                std_srvs::SetBool::Response& response) {
  const std::uint64_t epoch = requests_.setEnabled(request.data);
  if (!request.data) states_.discard("disabled", epoch);
  response.success = true;
  response.message = request.data ? "enabled" : "disabled: every pair is UNKNOWN";
  return true;
}

// Asks the detection thread to discard everything that it knows, as after a jump of ROS time.
// States are UNKNOWN from the answer on.
bool ContactMonitor::requestReset(std_srvs::Trigger::Request& /*request*/,
                                  std_srvs::Trigger::Response& response) {
  states_.discard("reset", requests_.requestReset());
  response.success = true;
  response.message = "meshes, transforms and contact states are discarded";
  return true;
}

// If the new robot cannot be used, the monitor keeps the old one.
bool ContactMonitor::reloadRobot(std_srvs::Trigger::Request& /*request*/,
                                 std_srvs::Trigger::Response& response) {
  try {
    robot_source_.reload();
    response.success = true;
    response.message = "robot loaded";
  } catch (const std::exception& error) {
    response.success = false;
    response.message = error.what();
    ROS_ERROR_STREAM("~reload_robot: "
                     << error.what()
                     << "; the robot stays as it was; see config/docs/console.md#the-robot");
  }
  return true;
}

}  // namespace deformable_contact_monitor
