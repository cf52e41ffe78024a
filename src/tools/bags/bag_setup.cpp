// Combines the configuration, the robot and the objects for the cycles of bags, and warns about the
// usual mistakes.
#include "tools/bags/bag_setup.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/messages/contact_messages.h"
#include "tools/bags/bag_messages.h"
#include "tools/common/robot_obstacles.h"
#include "tools/common/yaml_parameters.h"

namespace deformable_contact_monitor {
namespace {

using Warn = std::function<void(const std::string&)>;

// Returns what follows the last slash of a topic.
std::string lastPart(const std::string& topic) {
  const std::size_t slash =
      topic.find_last_not_of('/') == std::string::npos ? std::string::npos : topic.rfind('/');
  return slash == std::string::npos ? topic : topic.substr(slash + 1);
}

// Makes every topic of meshes an object.
void addRecordedObjects(const BagContents& contents, MonitorParameters* parameters) {
  std::set<std::string> topics;
  for (const BagContents::Mesh& mesh : contents.meshes) topics.insert(mesh.topic);
  for (const std::string& topic : topics) {
    ObjectParameters object;
    const std::string& name = contents.topics.at(topic).object;
    object.name = name.empty() ? lastPart(topic) : name;
    object.topic = topic;
    object.margin_m = parameters->margin_m;
    parameters->objects.push_back(object);
  }
}

// Adds the played object, unless the configuration has an object of that name.
void addPlayedObject(const SceneObject& object, MonitorParameters* parameters) {
  std::vector<ObjectParameters>& objects = parameters->objects;
  const auto same = [&object](const ObjectParameters& other) { return other.name == object.name; };
  if (std::any_of(objects.begin(), objects.end(), same)) return;
  ObjectParameters added;
  added.name = object.name;
  added.topic = "~objects/" + object.name + "/mesh";
  added.margin_m = parameters->margin_m;
  objects.push_back(added);
}

// Makes a robot from each recorded value. One that cannot be used leaves the robot as it was, as in
// the node. Throws what the last one throws if none can be used.
template <typename T>
History<RobotGeometry> robotsOf(const History<T>& values, const MonitorParameters& parameters,
                                const std::function<RobotGeometry(const T&)>& make,
                                const Warn& warn) {
  History<RobotGeometry> robots;
  for (const Recorded<T>& recorded : values) {
    try {
      RobotGeometry robot = make(recorded.value);
      checkRobot(robot, parameters);
      robots.push_back({recorded.received, std::move(robot)});
    } catch (const std::exception& error) {
      if (&recorded == &values.back() && robots.empty()) throw;
      warn("the robot that was recorded at " + stampText(recorded.received) +
           " is not used: " + error.what());
    }
  }
  return robots;
}

// Loads the robot from the option's URDF, the bags' link meshes or the bags' robot_description, in
// this order. Without another choice, the root link of a URDF becomes the reference frame.
void loadRobot(const BagFiles& files, const BagContents& contents, BagSetup* setup,
               const Warn& warn) {
  const MonitorParameters& parameters = setup->parameters;
  setup->urdfs = contents.robot_descriptions;
  setup->robot_from = "the bags' robot_description";
  if (!files.robot_description.empty()) {
    setup->urdfs = {{ros::Time(), readRobotDescription(files.robot_description)}};
    setup->robot_from = files.robot_description;
  } else if (!contents.link_meshes.empty()) {
    setup->robots = robotsOf<LinkMeshes>(
        contents.link_meshes, parameters,
        [&](const LinkMeshes& sent) {
          return selectedLinks(fromLinkMeshes(sent), parameters.geometry);
        },
        warn);
    setup->robot_from = "the bags' link meshes";
    return;
  }
  if (setup->urdfs.empty()) {
    throw std::runtime_error(
        "no robot: the bags hold neither link meshes nor a robot_description; give "
        "--robot-description FILE");
  }
  setup->robots = robotsOf<std::string>(
      setup->urdfs, parameters,
      [&](const std::string& urdf) {
        try {
          return loadRobotGeometry(urdf, parameters.geometry, makeRosResolver());
        } catch (const std::invalid_argument& error) {
          throw std::runtime_error(setup->robot_from + ": " + error.what());
        }
      },
      warn);
  // Nobody chose a frame, so the root link is the most useful one.
  if (files.config.empty() && files.reference_frame.empty()) {
    setup->parameters.reference_frame = setup->robots.front().value.root_link;
  }
}

// Adds frames from joint states. TF has priority: only frames that it does not have are added.
void useJoints(const BagSetup& setup, BagContents* contents, const Warn& warn) {
  if (setup.urdfs.empty()) return;
  try {
    contents->addJointTransforms(setup.urdfs);
  } catch (const std::exception& error) {
    warn(std::string("the URDF poses no links by /joint_states: ") + error.what());
  }
}

// Loads the SRDF that the option names, or the configuration, or else the one in the bags. Its
// rules are about pairs of links, which no cycle of a mesh looks at, so it needs no history.
void loadSrdf(const BagFiles& files, const BagContents& contents, BagSetup* setup,
              const Warn& warn) {
  const std::string& named = files.srdf.empty() ? setup->parameters.srdf : files.srdf;
  if (named == kSrdfNone || (named == kSrdfAuto && contents.robot_semantic.empty())) return;
  Srdf srdf;
  try {
    if (named == kSrdfAuto) {
      srdf = readSrdf(contents.robot_semantic);
    } else {
      srdf =
          readSrdfFile(named.find("://") == std::string::npos ? named : makeRosResolver()(named));
    }
  } catch (const std::exception& error) {
    if (named != kSrdfAuto) throw std::runtime_error(error.what());
    return warn(std::string("the bags' robot_description_semantic is not used: ") + error.what());
  }
  for (Recorded<RobotGeometry>& robot : setup->robots) robot.value.srdf = srdf;
  const RobotGeometry& newest = setup->robots.back().value;
  for (const std::string& line : srdfWarnings(srdf, newest.name, newest.link_names)) warn(line);
}

// Warns about a reference frame that no transform knows, because everything in other frames would
// be UNKNOWN. The default frame is replaced if the transforms have exactly one root.
void checkReferenceFrame(const BagFiles& files, const BagContents& contents,
                         MonitorParameters* parameters, const Warn& warn) {
  std::string& frame = parameters->reference_frame;
  const std::set<std::string> roots = contents.rootFrames();
  if (roots.empty() || contents.hasFrame(frame)) return;
  const bool by_default = files.config.empty() && files.reference_frame.empty();
  if (by_default && roots.size() == 1) {
    frame = *roots.begin();
    return warn("contacts are in frame '" + frame +
                "', the root of the transforms; choose another "
                "with --reference-frame");
  }
  std::string all;
  for (const std::string& root : roots) all += (all.empty() ? "" : ", ") + root;
  warn("no transform knows the reference frame '" + frame + "'; their roots are: " + all);
}

// Makes the object that is not in the bags. The robot's links push a simulated cloth.
PlayedObject playedObject(const SceneObject& settings, const BagSetup& setup) {
  PlayedObject played;
  played.object = settings.name;
  played.frame =
      settings.frame.empty() ? setup.parameters.reference_frame : plainFrame(settings.frame);
  played.rate_hz = settings.rate_hz;
  std::map<std::string, Capsule> capsules;
  if (settings.cloth_triangles) capsules = linkCapsules(setup.robots.front().value);
  played.next = [source = makeMeshSource(settings, [](std::size_t) {}),
                 capsules](const LinkPose& pose_of) mutable {
    std::vector<Capsule> obstacles;
    for (const auto& [link, capsule] : capsules) {
      const std::optional<Eigen::Isometry3d> pose = pose_of(link);
      if (pose) obstacles.push_back({*pose * capsule.a, *pose * capsule.b, capsule.radius_m});
    }
    return source(obstacles);
  };
  return played;
}

// Warns about objects without messages. A configuration with other topics than the bags' is the
// most frequent mistake.
void checkObjects(const BagFiles& files, const BagContents& contents, const BagSetup& setup,
                  const Warn& warn) {
  std::set<std::string> there;
  for (const BagContents::Mesh& mesh : contents.meshes) there.insert(mesh.topic);
  std::string recorded;
  for (const std::string& topic : there) recorded += (recorded.empty() ? "" : ", ") + topic;
  if (there.empty() && !setup.played) {
    throw std::runtime_error(
        "no deformable mesh in the bags: record the topic too (launch/record.launch), or give "
        "--meshes or --cloth");
  }
  bool any = setup.played.has_value();
  for (const ObjectParameters& object : setup.parameters.objects) {
    if (setup.played && setup.played->object == object.name) continue;
    any |= there.count(topicOf(object)) > 0;
    if (there.count(topicOf(object)) > 0) continue;
    warn("object '" + object.name + "': nothing was recorded on " + topicOf(object) +
         (recorded.empty() ? "" : "; there are meshes on " + recorded));
  }
  if (!any) {
    throw std::runtime_error(files.config + ": no object of it is in the bags, which have " +
                             recorded);
  }
}

// Warns once about all links without geometry.
void warnOfLinks(const History<RobotGeometry>& robots, const Warn& warn) {
  std::string first;
  std::set<std::string> links;
  for (const Recorded<RobotGeometry>& robot : robots) {
    for (const LinkGeometry& link : robot.value.links) {
      if (link.problem.empty()) continue;
      if (links.empty()) first = link.problem;
      links.insert(link.link);
    }
  }
  if (!links.empty()) {
    warn(std::to_string(links.size()) +
         " link(s) without usable geometry are UNKNOWN; the first: " + first);
  }
}

}  // namespace

MonitorParameters readBagParameters(const BagFiles& files, const Warn& warn) {
  if (files.config.empty()) return MonitorParameters();
  std::vector<std::string> warnings;
  try {
    MonitorParameters parameters = parseParameters(readYamlParameters(files.config), &warnings);
    for (const std::string& warning : warnings) warn(files.config + ": " + warning);
    return parameters;
  } catch (const ParameterError& error) {
    std::string text = error.what();
    // The parameter errors have a line each; a tool reports one line.
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw std::runtime_error(files.config + ": " + text);
  }
}

// Joint states are needed where TF lacks a frame, which is known only after the first reading.
BagSelection neededMessages(const MonitorParameters& parameters) {
  BagSelection selection;
  selection.types = neededTypes();
  for (const ObjectParameters& object : parameters.objects) {
    selection.types_of_topics[topicOf(object)] = messageType(object.type);
  }
  selection.types_of_topics.emplace(kJointsTopic,
                                    ros::message_traits::datatype<sensor_msgs::JointState>());
  return selection;
}

BagSetup setUpBags(const BagFiles& files, const MonitorParameters& configured,
                   const SceneObject& object, BagContents* contents, const Warn& warn) {
  BagSetup setup;
  setup.parameters = configured;
  MonitorParameters& parameters = setup.parameters;
  if (!files.reference_frame.empty()) {
    parameters.reference_frame = plainFrame(files.reference_frame);
  }
  if (parameters.objects.empty()) addRecordedObjects(*contents, &parameters);
  if (object.isWanted()) addPlayedObject(object, &parameters);
  if (parameters.pair_classes.needRobot()) {
    loadRobot(files, *contents, &setup, warn);
    loadSrdf(files, *contents, &setup, warn);
    useJoints(setup, contents, warn);
  } else {
    setup.robots.emplace_back();
  }
  warnOfLinks(setup.robots, warn);
  checkReferenceFrame(files, *contents, &parameters, warn);
  if (object.isWanted()) {
    // The object is played while transforms are known, so there must be some.
    if (contents->ended().isZero()) {
      throw std::runtime_error(
          "no moving transform in the bags, and no /joint_states of the robot's joints: no time to "
          "play "
          "an object in");
    }
    setup.played = playedObject(object, setup);
  }
  checkObjects(files, *contents, setup, warn);
  return setup;
}

}  // namespace deformable_contact_monitor
