// soft_scene: simulates a soft object among a robot's links, or plays mesh files, and moves the
// robot's joints.
//
// It replaces a camera and a robot in demonstrations and tests. One loop, at the rate of --rate,
// moves the links, makes the next state of the object and sends both with the same stamp, to topics
// or into a bag. Everything runs in the main thread.
#include <deformable_contact_monitor/AttachObject.h>
#include <ros/ros.h>
#include <std_msgs/Float64.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "tools/common/command_line.h"
#include "tools/common/ros_words.h"
#include "tools/common/run_tool.h"
#include "tools/common/yaml_parameters.h"
#include "tools/simulation/scene_object.h"
#include "tools/simulation/soft_world.h"
#include "tools/soft_scene/joint_mover.h"
#include "tools/soft_scene/joint_script.h"
#include "tools/soft_scene/scene_output.h"
#include "tools/soft_scene/scene_robot.h"

namespace deformable_contact_monitor {
namespace {

const ros::Time kBagBegin(1000, 0);  // the stamp of a bag's first messages

// The options of the command line.
struct Settings {
  SceneObject object;
  std::string topic = "deformable_mesh";
  bool joints = false, tf = false;
  std::string motion, robot, bag, monitor;
  double seconds = 0;
};

// Adds the options to the command line; `s` holds the defaults.
void describe(CommandLine* line, Settings* s) {
  describe(line, &s->object);
  line->add("--topic", &s->topic, "where the object is published");
  line->addFlag("--joints", &s->joints,
                "move the robot's joints along sinusoids: publish joint_states");
  line->add("--motion", &s->motion, "move the robot's joints as this yaml file says");
  line->addFlag("--tf", &s->tf, "links are where TF says, not where joint_states says");
  line->add("--robot", &s->robot,
            "URDF file of the robot (default: the parameter robot_description)");
  line->add("--monitor", &s->monitor,
            "name of a contact_monitor whose ~attach_object is called, too, whenever links take "
            "hold of the object or let go of it");
  line->add("--bag", &s->bag, "write to this bag instead of topics; needs no ROS master");
  line->add("--seconds", &s->seconds, "end after so many seconds of the scene; 0: never",
            inRange(0.0, 1e6));
  line->refuseTogether("--joints", "--motion");
  line->refuseTogether("--tf", "--joints");
  line->refuseTogether("--tf", "--motion");
  line->refuseTogether("--tf", "--bag");
  line->refuseTogether("--monitor", "--bag");
  line->requireFor("--bag", "--seconds");
}

// Checks what single options cannot know.
void check(const Settings& s) {
  if (!s.object.isWanted() && !s.joints && s.motion.empty()) {
    throw std::runtime_error(
        "nothing to publish: give --object, --meshes, --joints or --motion (see --help)");
  }
  if (!s.bag.empty() && s.robot.empty() && (s.joints || !s.motion.empty())) {
    throw std::runtime_error("--bag needs no ROS master, so the robot must come from --robot");
  }
}

// Loads the robot; nothing if there is none. `node` may be null.
std::optional<Robot> findRobot(const Settings& s, ros::NodeHandle* node) {
  if (!s.robot.empty()) return readRobot(readRobotDescription(s.robot));
  std::string key, xml;
  if (node == nullptr || !node->searchParam("robot_description", key) ||
      !node->getParam(key, xml)) {
    return std::nullopt;
  }
  return readRobot(xml);
}

// Measures how fast the scene runs: seconds of the scene in a second, and how much of a second was
// spent on computing.
class Pace {
 public:
  void count(double scene_s, double busy_s) {
    scene_s_ += scene_s;
    busy_s_ += busy_s;
  }

  // Returns the real-time factor since the last call, and writes it to the log.
  double tell(std::uint64_t messages, std::size_t triangles) {
    const double wall_s = std::chrono::duration<double>(Clock::now() - begin_).count();
    const double factor = scene_s_ / wall_s;
    ROS_INFO("message %llu, %zu triangles; real-time factor %.2f, computing takes %.0f %% of it",
             static_cast<unsigned long long>(messages), triangles, factor,
             100 * busy_s_ / std::max(scene_s_, 1e-9));
    if (factor < 0.9) ROS_WARN("the scene is slower than real time: fewer --vertices are faster");
    *this = Pace();
    return factor;
  }

  bool isDue() const { return Clock::now() - begin_ > std::chrono::seconds(10); }

 private:
  using Clock = std::chrono::steady_clock;

  Clock::time_point begin_ = Clock::now();
  double scene_s_ = 0, busy_s_ = 0;
};

// The service ~attach_object, which has the type of the monitor's: links hold what of the object is
// within a radius, until they let go. A monitor is told, if there is one.
class Grasp {
 public:
  Grasp(const SceneObject& object, std::string monitor, SoftWorld* world)
      : object_(object), monitor_(std::move(monitor)), world_(world) {}

  bool attach(AttachObject::Request& request, AttachObject::Response& response) {
    response = hold(request);
    return true;
  }

  // Takes hold, or lets go.
  AttachObject::Response hold(const AttachObject::Request& request) {
    AttachObject::Response response;
    if (request.object != object_.name) {
      response.message = "there is no object '" + request.object + "', but '" + object_.name + "'";
    } else if (request.links.empty()) {
      world_->release();
      response.success = true;
      response.message = object_.name + " is held no more";
    } else if (!(request.radius > 0) || !std::isfinite(request.radius)) {
      response.message = "a simulated object needs a radius above 0";
    } else {
      try {
        const std::size_t vertices = world_->hold(request.links, request.radius);
        response.success = vertices > 0;
        response.held_triangles = static_cast<std::uint32_t>(world_->heldTriangles());
        response.message = vertices > 0
                               ? std::to_string(vertices) + " vertices are held"
                               : "no vertex that is free is within the radius of the links";
      } catch (const std::invalid_argument& error) {
        response.message = error.what();
      }
    }
    if (response.success && !monitor_.empty()) tellMonitor(request, &response.message);
    return response;
  }

 private:
  // A monitor that is not there is no reason not to hold.
  void tellMonitor(const AttachObject::Request& request, std::string* message) const {
    AttachObject service;
    service.request = request;
    const bool answered = ros::service::call(monitor_ + "/attach_object", service);
    *message += "; " + monitor_ + ": " + (answered ? service.response.message : "no answer");
  }

  const SceneObject& object_;
  const std::string monitor_;
  SoftWorld* world_;
};

// Everything that a scene consists of, and its loop.
class SoftScene {
 public:
  SoftScene(const Settings& s, ros::NodeHandle* node);

  // Runs until ROS shuts down, the meshes end or the time is over.
  void run();

 private:
  void moveByScript(double time_s);
  void tell(std::uint64_t messages, const std::optional<MeshFrame>& state);

  const Settings& s_;
  ros::NodeHandle* node_;
  std::optional<JointScript> script_;
  double scripted_s_ = -1;  // the script has been followed up to this time
  MeshSource source_;
  std::optional<Robot> robot_;
  std::shared_ptr<SoftWorld> world_;
  std::optional<MovedJoints> moved_;
  std::optional<SceneRobot> scene_robot_;
  std::optional<SceneOutput> output_;
  std::optional<Grasp> grasp_;
  ros::ServiceServer service_;
  ros::Publisher factor_;
  Pace pace_;
};

// Files are read first: bad ones are rejected before anything else happens.
SoftScene::SoftScene(const Settings& s, ros::NodeHandle* node) : s_(s), node_(node) {
  const SceneObject& object = s.object;
  if (!s.motion.empty()) script_.emplace(s.motion);
  if (!object.meshes.empty()) {
    source_ = makeFileSource(object, [&object](std::size_t count) {
      ROS_INFO_THROTTLE(1, "read %zu of %zu meshes", count, object.meshes.size());
    });
  }
  const bool moves = s.joints || script_;
  if (moves || !object.shape.object.empty()) robot_ = findRobot(s, node);
  if (moves && !robot_) {
    throw std::runtime_error(
        "--joints and --motion need the parameter robot_description, or --robot");
  }
  if (!object.shape.object.empty()) {
    world_ = makeSoftWorld(object, robot_ ? robot_->geometry : RobotGeometry());
    source_ = makeSoftSource(object, world_);
    grasp_.emplace(object, s.monitor, world_.get());
  }
  const std::string frame =
      !object.frame.empty() ? object.frame : (robot_ ? robot_->geometry.root_link : "base_link");
  if (s.joints) {
    const auto mover = std::make_shared<JointMover>(robot_->geometry.joints, object.shape.seed);
    moved_ =
        MovedJoints{mover->names(), [mover](double time_s) { return mover->positions(time_s); }};
  } else if (script_) {
    moved_ =
        MovedJoints{script_->names(), [this](double time_s) { return script_->positions(time_s); }};
  }
  const bool has_poses = moved_ || node != nullptr;
  if (robot_ && has_poses) {
    scene_robot_.emplace(*robot_, frame, moved_ ? &*moved_ : nullptr, s.tf, node);
  }
  output_.emplace(object, s.topic, frame, node, s.bag, robot_ ? robot_->urdf_xml : "", kBagBegin);
  if (node == nullptr) return;
  ros::NodeHandle own("~");
  factor_ = own.advertise<std_msgs::Float64>("real_time_factor", 1, true);
  if (grasp_) service_ = own.advertiseService("attach_object", &Grasp::attach, &*grasp_);
}

// Takes hold and lets go of the object as the script says, up to this time of the scene.
void SoftScene::moveByScript(double time_s) {
  if (!script_ || !grasp_) return;
  for (const ScriptedHold& hold : script_->holds(scripted_s_, time_s)) {
    if (hold.begins_again) world_->restart();
    AttachObject::Request request;
    request.object = s_.object.name;
    request.links = hold.links;
    request.radius = static_cast<float>(hold.radius_m);
    const AttachObject::Response response = grasp_->hold(request);
    ROS_INFO("%.2f s into the scene: %s", time_s, response.message.c_str());
  }
  scripted_s_ = time_s;
}

void SoftScene::tell(std::uint64_t messages, const std::optional<MeshFrame>& state) {
  if (state && !state->problem.empty()) {
    ROS_ERROR_THROTTLE(1, "a step was undone, and the object stays where it was: %s",
                       state->problem.c_str());
  }
  if (!pace_.isDue()) return;
  std_msgs::Float64 factor;
  factor.data = pace_.tell(messages, state ? state->mesh.triangleCount() : 0);
  if (factor_) factor_.publish(factor);
}

// Scene time counts messages, not seconds, so that the same command gives the same states on any
// machine.
void SoftScene::run() {
  const double rate_hz = s_.object.rate_hz;
  std::optional<ros::Rate> rate;
  if (node_ != nullptr) rate.emplace(rate_hz);
  for (std::uint64_t cycle = 0; node_ == nullptr || ros::ok(); ++cycle) {
    const double time_s = static_cast<double>(cycle) / rate_hz;
    if (s_.seconds > 0 && time_s >= s_.seconds) break;
    if (node_ != nullptr) ros::spinOnce();
    const auto begin = std::chrono::steady_clock::now();
    // Links move first, so that the object meets them where they are at this stamp.
    if (scene_robot_) scene_robot_->moveTo(time_s);
    std::optional<MeshFrame> state;
    if (source_) {
      state = source_([this](const std::string& link) {
        return scene_robot_ ? scene_robot_->poseOf(link) : std::nullopt;
      });
      if (!state) break;
    }
    const ros::Time stamp = node_ != nullptr ? ros::Time::now() : kBagBegin + ros::Duration(time_s);
    if (scene_robot_ && scene_robot_->movedJoints() != nullptr) {
      output_->send(*scene_robot_->movedJoints(), stamp);
    }
    if (state) output_->send(*state, stamp);
    moveByScript(time_s);
    pace_.count(1 / rate_hz,
                std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    tell(cycle + 1, state);
    if (rate) rate->sleep();
  }
  output_->finish();
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("soft_scene", [&argc, argv] {
    dcm::Settings settings;
    dcm::CommandLine line("soft_scene",
                          "Simulates a soft object among a robot's links with Bullet, or plays "
                          "mesh files, and moves the robot's joints.");
    describe(&line, &settings);
    if (!line.parse(dcm::wordsForNode(argc, argv))) return 0;
    dcm::check(settings);
    ros::Time::init();  // messages to the console look at the clock, also without a node
    std::optional<ros::NodeHandle> node;
    if (settings.bag.empty()) {
      ros::init(argc, argv, "soft_scene");
      node.emplace();
    }
    dcm::SoftScene(settings, node ? &*node : nullptr).run();
    return 0;
  });
}
