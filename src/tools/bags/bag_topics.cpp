// Chooses topics by their types, their names and the options. Where several would do, a user has to
// choose, because a wrong guess would show only in wrong contacts.
#include "tools/bags/bag_topics.h"

#include <algorithm>
#include <boost/algorithm/cxx11/any_of.hpp>
#include <boost/algorithm/string/predicate.hpp>
#include <stdexcept>

#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_reader.h"

namespace deformable_contact_monitor {
namespace {

using boost::algorithm::any_of_equal;
using boost::algorithm::ends_with;

using Names = std::vector<std::string>;

const char* const kDescription = "robot_description";
const char* const kSemantic = "_semantic";
const char* const kStatic = "_static";

// Returns the names of the topics with a type that satisfies the condition.
template <typename Condition>
Names topicsOf(const RecordedTopics& recorded, const Condition& has_type) {
  Names names;
  for (const auto& [name, type] : recorded) {
    if (has_type(BagMessage{name, type, "", ros::Time(), {}})) names.push_back(name);
  }
  return names;
}

// Makes the choices, and keeps what all of them need.
class Chooser {
 public:
  Chooser(const RecordedTopics& recorded, const BagFiles& files)
      : recorded_(recorded), files_(files) {}

  // Takes /tf and /tf_static, or what the option names in place of them.
  void chooseTransforms(BagTopics* topics) const {
    const Names there = topicsOf(recorded_, isTransforms);
    const Names asked = files_.tf_topics.empty() ? Names{"/tf"} : files_.tf_topics;
    bool any = false;
    for (const std::string& name : asked) {
      const std::string topic = absoluteTopic(name);
      const bool is_there = any_of_equal(there, topic) || any_of_equal(there, topic + kStatic);
      if (!is_there && !files_.tf_topics.empty()) refuseMissing("--tf-topic", topic, there);
      topics->transforms.insert({topic, topic + kStatic});
      any |= is_there;
    }
    Names others;
    for (const std::string& topic : there) {
      if (topics->transforms.count(topic) == 0) others.push_back(topic);
    }
    if (others.empty()) return;
    Names proposed = any ? asked : Names();
    for (const std::string& topic : others) {
      const bool is_implied =
          ends_with(topic, kStatic) &&
          any_of_equal(others, topic.substr(0, topic.size() - std::string(kStatic).size()));
      if (!is_implied) proposed.push_back(topic);
    }
    topics->other_transforms =
        "the transforms on " + joined(others, ", ") +
        (any ? " are left out; to read them too" : " are not read; to read them") +
        ", give --tf-topic " + joined(proposed, ",");
  }

  void chooseJointStates(BagTopics* topics) const {
    Names there = topicsOf(recorded_, isJointState);
    topics->joint_states = jointStatesTopic(files_);
    const auto chosen = std::find(there.begin(), there.end(), topics->joint_states);
    if (chosen == there.end() && !files_.joint_states.empty()) {
      refuseMissing("--joint-states", topics->joint_states, there);
    }
    if (chosen != there.end()) there.erase(chosen);
    if (there.empty()) return;
    topics->other_joint_states = "there are joint states on " + joined(there, ", ") +
                                 "; to read them, give --joint-states " + there.front();
  }

  // A file in place of the bags' URDF leaves nothing to choose. Link meshes count only where no
  // option names another source.
  void chooseRobot(const MonitorParameters& parameters, BagTopics* topics) const {
    if (parameters.robots.empty()) {
      topics->robots.emplace_back();
      if (files_.robot_description.empty()) chooseDescription(&topics->robots.front());
      chooseSemantic(&topics->robots.front());
    }
    for (const RobotParameters& robot : parameters.robots) chooseOwn(robot.description, topics);
    const Names meshes = topicsOf(recorded_, isLinkMeshes);
    const bool is_described =
        !files_.robot_description.empty() || !files_.robot_description_topic.empty();
    if (is_described && files_.robot_meshes_topic.empty()) return;
    topics->link_meshes =
        chosen("link meshes", "--robot-meshes-topic", files_.robot_meshes_topic, meshes);
  }

 private:
  // Robots of a list have their own topics, so there is nothing to choose.
  void chooseOwn(const std::string& description, BagTopics* topics) const {
    const Names texts = topicsOf(recorded_, isText);
    const std::string topic = absoluteTopic(description);
    topics->robots.emplace_back();
    if (any_of_equal(texts, topic)) topics->robots.back().description = topic;
    if (any_of_equal(texts, topic + kSemantic)) topics->robots.back().semantic = topic + kSemantic;
  }

  void chooseDescription(BagTopics::Robot* robot) const {
    const Names texts = topicsOf(recorded_, isText);
    if (!files_.robot_description_topic.empty()) {
      const std::string topic = absoluteTopic(files_.robot_description_topic);
      if (!any_of_equal(texts, topic)) refuseMissing("--robot-description-topic", topic, texts);
      robot->description = topic;
      return;
    }
    robot->description = chosen("URDFs", "--robot-description-topic", "", ending(texts, ""));
  }

  // Prefers the SRDF that has the name of the chosen URDF.
  void chooseSemantic(BagTopics::Robot* robot) const {
    const Names there = ending(topicsOf(recorded_, isText), kSemantic);
    const std::string own = robot->description + kSemantic;
    if (any_of_equal(there, own)) {
      robot->semantic = own;
    } else if (files_.srdf.empty()) {
      robot->semantic = chosen("SRDFs", "--srdf FILE (or none)", "", there);
    }
  }

  static Names ending(const Names& names, const std::string& end) {
    Names found;
    std::copy_if(names.begin(), names.end(), std::back_inserter(found),
                 [&end](const std::string& name) { return ends_with(name, kDescription + end); });
    return found;
  }

  // Returns the topic that the option names, or the only one that is there.
  std::string chosen(const char* what, const std::string& option, const std::string& asked,
                     const Names& there) const {
    std::string topic = asked.empty() ? "" : absoluteTopic(asked);
    if (!asked.empty() && !any_of_equal(there, topic)) refuseMissing(option, topic, there);
    if (!asked.empty()) return topic;
    if (there.size() > 1) {
      refuse(std::string(what) + " are on " + joined(there, ", ") + ": choose with " + option);
    }
    return there.empty() ? "" : there.front();
  }

  [[noreturn]] void refuseMissing(const std::string& option, const std::string& topic,
                                  const Names& there) const {
    refuse(option + " " + topic + ": nothing of this kind was recorded there" +
           (there.empty() ? " or elsewhere" : "; there is " + joined(there, ", ")));
  }

  [[noreturn]] void refuse(const std::string& what) const {
    throw std::runtime_error(joined(files_.bags, ", ") + ": " + what);
  }

  const RecordedTopics& recorded_;
  const BagFiles& files_;
};

}  // namespace

BagTopics chooseTopics(const RecordedTopics& recorded, const BagFiles& files,
                       const MonitorParameters& parameters) {
  const Chooser chooser(recorded, files);
  BagTopics topics;
  chooser.chooseTransforms(&topics);
  chooser.chooseJointStates(&topics);
  if (parameters.pair_classes.needRobot()) chooser.chooseRobot(parameters, &topics);
  return topics;
}

std::string jointStatesTopic(const BagFiles& files) {
  return absoluteTopic(files.joint_states.empty() ? "joint_states" : files.joint_states);
}

std::map<std::string, std::string> objectTopics(const BagFiles& files) {
  std::map<std::string, std::string> topics;
  std::map<std::string, std::string> objects;  // by topic
  for (const std::string& text : files.objects) {
    const std::size_t equals = text.rfind('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
      throw std::runtime_error("--topic: '" + text + "' is not OBJECT=TOPIC");
    }
    const std::string object = text.substr(0, equals),
                      topic = absoluteTopic(text.substr(equals + 1));
    if (!topics.emplace(object, topic).second) {
      throw std::runtime_error("--topic: object '" + object + "' has two topics");
    }
    const auto [other, is_new] = objects.emplace(topic, object);
    if (!is_new) {
      throw std::runtime_error("--topic: " + topic + " is the topic of two objects, '" +
                               other->second + "' and '" + object + "'");
    }
  }
  return topics;
}

bool isStatic(const std::string& topic) { return ends_with(topic, kStatic); }

// The node's own topics are below its name, which is contact_monitor in recordings.
std::string topicOf(const ObjectParameters& object) {
  const std::string& topic = object.topic;
  if (topic.empty()) return "/contact_monitor/objects/" + object.name + "/mesh";
  return absoluteTopic(topic.front() == '~' ? "contact_monitor/" + topic.substr(1) : topic);
}

}  // namespace deformable_contact_monitor
