// Combines the configuration, the robot and the objects for the cycles of bags, and warns about the
// usual mistakes.
#include "tools/bags/bag_setup.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <vector>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/input/mesh_subscription.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/rule_texts.h"
#include "robot/nearest_name.h"
#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_robots.h"
#include "tools/common/command_line.h"
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

// Returns the topics with meshes.
std::set<std::string> meshTopics(const BagContents& contents) {
  std::set<std::string> topics;
  for (const BagContents::Mesh& mesh : contents.meshes) topics.insert(mesh.topic);
  return topics;
}

// Throws unless the meshes of that object can be on the topic.
void checkChosenTopic(const BagContents& contents, const std::string& object,
                      const std::string& topic) {
  const std::string what = "--topic " + object + "=" + topic + ": ";
  const std::set<std::string> topics = meshTopics(contents);
  if (topics.count(topic) == 0) {
    throw std::runtime_error(
        what + "no deformable mesh was recorded there" +
        (topics.empty() ? "" : "; there are meshes on " + joined(topics, ", ")));
  }
  const std::string& name = contents.topics.at(topic).object;
  if (!name.empty() && name != object) {
    throw std::runtime_error(what + "its messages are of object '" + name + "'");
  }
}

// Makes every topic of meshes an object. Where several have meshes of one object, an option must
// choose; the others are left out then.
void addRecordedObjects(const BagFiles& files, const BagContents& contents,
                        MonitorParameters* parameters, const Warn& warn) {
  const std::map<std::string, std::string> chosen = objectTopics(files);
  std::map<std::string, std::set<std::string>> topics_of;  // by object
  for (const auto& [object, topic] : chosen) checkChosenTopic(contents, object, topic);
  for (const std::string& topic : meshTopics(contents)) {
    const auto is_on = [&topic](const auto& choice) { return choice.second == topic; };
    const auto choice = std::find_if(chosen.begin(), chosen.end(), is_on);
    const std::string& name = contents.topics.at(topic).object;
    topics_of[choice != chosen.end() ? choice->first
              : name.empty()         ? lastPart(topic)
                                     : name]
        .insert(topic);
  }
  for (auto& [name, topics] : topics_of) {
    const auto choice = chosen.find(name);
    if (choice != chosen.end()) topics.erase(choice->second);
    if (choice != chosen.end() && !topics.empty()) {
      warn("object '" + name + "' is on " + choice->second + "; the meshes on " +
           joined(topics, ", ") + " are left out");
    } else if (topics.size() > 1) {
      throw std::runtime_error("object '" + name + "' is on " + joined(topics, ", ") +
                               ": choose one with --topic " + name + "=" + *topics.begin());
    }
    for (const RigidParameters& rigid : parameters->rigids) {
      if (rigid.name != name) continue;
      throw std::runtime_error("object '" + name + "' is recorded on " + *topics.begin() +
                               ", and rigid in the configuration; rename the rigid object");
    }
    ObjectParameters object;
    object.name = name;
    object.topic = choice != chosen.end() ? choice->second : *topics.begin();
    object.margin_m = parameters->margin_m;
    parameters->objects.push_back(object);
  }
}

// Gives the configuration's objects the topics that the option chooses.
void chooseTopics(const BagFiles& files, std::vector<ObjectParameters>* objects) {
  std::vector<std::string> names;
  for (const ObjectParameters& object : *objects) names.push_back(object.name);
  for (const auto& [name, topic] : objectTopics(files)) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      throw std::runtime_error("--topic " + name + "=" + topic + ": " + files.config +
                               " has no object '" + name + "'" + nearestNameHint(name, names));
    }
    (*objects)[static_cast<std::size_t>(found - names.begin())].topic = topic;
  }
}

// Adds the played object, unless the configuration has an object of that name. Throws if meshes of
// that name were recorded as well.
void addPlayedObject(const SceneObject& object, const BagContents& contents,
                     MonitorParameters* parameters) {
  std::vector<ObjectParameters>& objects = parameters->objects;
  for (const RigidParameters& rigid : parameters->rigids) {
    if (rigid.name != object.name) continue;
    throw std::runtime_error("object '" + object.name +
                             "' is rigid in the configuration; give the played one another name "
                             "with --name");
  }
  for (const ObjectParameters& other : objects) {
    if (other.name != object.name) continue;
    if (meshTopics(contents).count(topicOf(other)) == 0) return;
    throw std::runtime_error("object '" + object.name + "' was recorded on " + topicOf(other) +
                             "; give the played one another name with --name");
  }
  ObjectParameters added;
  added.name = object.name;
  added.topic = "~objects/" + object.name + "/mesh";
  added.margin_m = parameters->margin_m;
  if (object.isRope()) added.radius_m = object.radius_m;
  objects.push_back(added);
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
  warn("no transform knows the reference frame '" + frame +
       "'; their roots are: " + joined(roots, ", "));
}

// Makes the object that is not in the bags. The robot's links push what is simulated.
PlayedObject playedObject(const SceneObject& settings, const BagSetup& setup) {
  PlayedObject played;
  played.object = settings.name;
  played.frame =
      settings.frame.empty() ? setup.parameters.reference_frame : plainFrame(settings.frame);
  played.rate_hz = settings.rate_hz;
  const RobotGeometry& robot = setup.robots[firstWithShapes(setup.robots)].value;
  played.next = settings.shape.object.empty()
                    ? makeFileSource(settings, [](std::size_t) {})
                    : makeSoftSource(settings, makeSoftWorld(settings, robot));
  return played;
}

// Warns about objects without messages. A configuration with other topics than the bags' is the
// most frequent mistake.
void checkObjects(const BagFiles& files, const BagContents& contents, const BagSetup& setup,
                  const Warn& warn) {
  const std::set<std::string> there = meshTopics(contents);
  const std::string recorded = joined(there, ", ");
  if (there.empty() && !setup.played) {
    throw std::runtime_error(
        "no deformable mesh in the bags: record the topic too (launch/record.launch), or give "
        "--meshes or --object");
  }
  bool any = setup.played.has_value();
  for (const ObjectParameters& object : setup.parameters.objects) {
    if (setup.played && setup.played->object == object.name) continue;
    const auto other = contents.recorded.find(topicOf(object));
    const bool is_there = there.count(topicOf(object)) > 0 && other != contents.recorded.end() &&
                          other->second == messageType(object.type);
    any |= is_there;
    if (is_there) continue;
    const std::string found =
        other == contents.recorded.end()
            ? "nothing was recorded"
            : other->second + " was recorded, and not " + messageType(object.type) + ",";
    warn("object '" + object.name + "': " + found + " on " + topicOf(object) +
         (recorded.empty() ? "" : "; there are meshes on " + recorded));
  }
  if (!any) {
    throw std::runtime_error(files.config + ": no object of it is in the bags, which have " +
                             recorded);
  }
}

// Returns the bodies that the monitor will have, by name and kind.
std::vector<BodyStatus> bodiesOf(const RobotGeometry& robot, const MonitorParameters& parameters) {
  std::vector<BodyStatus> bodies;
  for (const LinkGeometry& link : robot.links) {
    bodies.push_back({link.link, BodyKind::kLink, ros::Time(), 0, ""});
  }
  for (const RigidParameters& rigid : parameters.rigids) {
    bodies.push_back({rigid.name, BodyKind::kRigid, ros::Time(), 0, ""});
  }
  for (const ObjectParameters& object : parameters.objects) {
    bodies.push_back(bodyOf(object));
  }
  return bodies;
}

// Warns of what is suspicious about the robots, as the node does, and of names that they lack.
void warnOfRobots(const BagSetup& setup, const Warn& warn) {
  const MonitorParameters& parameters = setup.parameters;
  std::set<std::string> warned;
  for (const Recorded<RobotGeometry>& robot : setup.robots) {
    if (isWithoutShapes(robot.value)) continue;  // loadBagRobots() said why
    std::vector<std::string> lines = robotWarnings(robot.value, parameters);
    for (const std::string& line : describeUnknownNames(parameters, parameters.allowed_contacts,
                                                        bodiesOf(robot.value, parameters))) {
      lines.push_back(line);
    }
    for (const std::string& line : lines) {
      if (warned.insert(line).second) warn(line);
    }
  }
}

// Warns about topics that are not read although they may have what is missing.
void warnOfTopics(const BagSetup& setup, const BagContents& contents, const Warn& warn) {
  const BagTopics& chosen = contents.chosen;
  if (!chosen.other_transforms.empty()) warn(chosen.other_transforms);
  for (const RigidParameters& rigid : setup.parameters.rigids) {
    const bool has_frame =
        rigid.frame == setup.parameters.reference_frame || contents.hasFrame(rigid.frame);
    if (!has_frame)
      warn("no transform has the frame '" + rigid.frame + "' of '" + rigid.name + "'");
  }
  const bool are_several = !setup.parameters.robots.empty() && !contents.joints.empty();
  const std::string joints = are_several
                                 ? "joint states pose no links of `robots`, only transforms do"
                                 : chosen.other_joint_states;
  if (joints.empty()) return;
  const auto has_no_frame = [&](const LinkGeometry& link) {
    const std::string frame = setup.parameters.frameOf(link.link);
    return frame != setup.parameters.reference_frame && !contents.hasFrame(frame);
  };
  const std::vector<LinkGeometry>& links = setup.robots.front().value.links;
  const auto link = std::find_if(links.begin(), links.end(), has_no_frame);
  if (link == links.end()) return;
  warn("no transform has the frame of link '" + link->link + "'; " + joints);
}

// Returns why an object cannot be played.
std::string whyNotPlayed(const BagTopics& chosen) {
  std::string why =
      "no moving transform in the bags, and no joint states of the robot's joints on " +
      chosen.joint_states + ": no time to play an object in";
  for (const std::string& hint : {chosen.other_transforms, chosen.other_joint_states}) {
    if (!hint.empty()) why += "; " + hint;
  }
  return why;
}

// Throws std::runtime_error if an option is about the only robot, where the configuration has a
// list of them.
void refuseSingleRobot(const BagFiles& files) {
  const auto refuse = [&files](const char* option, const std::string& value) {
    if (value.empty()) return;
    throw std::runtime_error(std::string(option) + " is of a single robot, but " + files.config +
                             " has robots");
  };
  refuse("--robot-description", files.robot_description);
  refuse("--robot-description-topic", files.robot_description_topic);
  refuse("--srdf", files.srdf);
  refuse("--frame-prefix", files.frame_prefix);
}

// Forgets the meshes on topics that no object has, which the node would not receive.
void dropOtherMeshes(const MonitorParameters& parameters, BagContents* contents) {
  std::set<std::string> topics;
  for (const ObjectParameters& object : parameters.objects) topics.insert(topicOf(object));
  const auto is_other = [&topics](const BagContents::Mesh& mesh) {
    return topics.count(mesh.topic) == 0;
  };
  std::vector<BagContents::Mesh>& meshes = contents->meshes;
  meshes.erase(std::remove_if(meshes.begin(), meshes.end(), is_other), meshes.end());
}

}  // namespace

MonitorParameters readBagParameters(const BagFiles& files, const Warn& warn) {
  MonitorParameters parameters;
  std::vector<std::string> warnings;
  try {
    if (!files.config.empty()) {
      parameters = parseParameters(readYamlParameters(files.config), &warnings);
      for (const std::string& warning : warnings) warn(files.config + ": " + warning);
    }
    if (!parameters.robots.empty()) refuseSingleRobot(files);
    if (!files.frame_prefix.empty()) parameters.frame_prefix = plainFrame(files.frame_prefix);
    if (!parameters.objects.empty()) chooseTopics(files, &parameters.objects);
    requireOwnTopics(parameters.objects, topicOf);
    return parameters;
  } catch (const ParameterError& error) {
    std::string text = error.what();
    // The parameter errors have a line each; a tool reports one line.
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw std::runtime_error(files.config + ": " + text);
  }
}

// Joint states are needed where TF lacks a frame, which is known only after the first reading.
BagSelection neededMessages(const MonitorParameters& parameters, const BagFiles& files) {
  BagSelection selection;
  selection.types = neededTypes();
  for (const ObjectParameters& object : parameters.objects) {
    selection.types_of_topics[topicOf(object)] = messageType(object.type);
  }
  selection.types_of_topics.emplace(jointStatesTopic(files),
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
  if (contents->repeated_meshes > 0) {
    warn(std::to_string(contents->repeated_meshes) +
         " meshes are in two bags, with the same time and the same bytes, and count twice; leave "
         "out the bag that is a copy");
  }
  if (parameters.objects.empty()) addRecordedObjects(files, *contents, &parameters, warn);
  if (object.isWanted()) addPlayedObject(object, *contents, &parameters);
  if (parameters.pair_classes.needRobot()) {
    setup.robots = loadBagRobots(files, parameters, *contents, &setup.robot_from, warn);
    // Nobody chose a frame, so the root link is the most useful one.
    const std::string& root = setup.robots.front().value.root_link;
    if (!root.empty() && files.config.empty() && files.reference_frame.empty()) {
      parameters.reference_frame = parameters.frameOf(root);
    }
    useJointStates(files, parameters, contents, warn);
  } else {
    setup.robots.emplace_back();
  }
  warnOfRobots(setup, warn);
  checkReferenceFrame(files, *contents, &parameters, warn);
  warnOfTopics(setup, *contents, warn);
  if (object.isWanted()) {
    // The object is played while transforms are known, so there must be some.
    if (contents->ended().isZero()) throw std::runtime_error(whyNotPlayed(contents->chosen));
    setup.played = playedObject(object, setup);
  }
  checkObjects(files, *contents, setup, warn);
  dropOtherMeshes(parameters, contents);
  return setup;
}

}  // namespace deformable_contact_monitor
