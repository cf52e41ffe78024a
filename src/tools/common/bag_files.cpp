// Declares the options that evaluate_bag and measure_trade share.
#include "tools/common/bag_files.h"

namespace deformable_contact_monitor {

void describe(CommandLine* line, BagFiles* files, const std::string& required) {
  const std::string with = required.empty() ? "" : "With " + required + ": ";
  const auto add = [&](const char* name, std::string* value, const char* help) {
    line->add(name, value, with + help);
    if (!required.empty()) line->requireFor(name, required);
  };
  const auto addRepeated = [&](const char* name, std::vector<std::string>* values,
                               const char* help) {
    line->addRepeated(name, values, with + help);
    if (!required.empty()) line->requireFor(name, required);
  };
  add("--config", &files->config,
      "Parameters of contact_monitor (yaml). Without it, every topic of deformable meshes is an "
      "object, and all other parameters have their defaults");
  add("--robot-description", &files->robot_description,
      "URDF, or a rosparam dump of it. Without it, the bags' link meshes or robot_description");
  add("--srdf", &files->srdf,
      "SRDF whose disabled pairs of links may touch, or none. Without it, the configuration's "
      "srdf, where auto is the bags' robot_description_semantic");
  add("--reference-frame", &files->reference_frame,
      "Frame of the contacts, instead of the configuration's");
  add("--frame-prefix", &files->frame_prefix,
      "What precedes the links' names in TF frames (left/ for left/hand), instead of the "
      "configuration's frame_prefix");
  addRepeated("--tf-topic", &files->tf_topics,
              "Topics of transforms instead of /tf and /tf_static; TOPIC stands for TOPIC_static "
              "too");
  add("--joint-states", &files->joint_states, "Topic of joint states instead of /joint_states");
  add("--robot-description-topic", &files->robot_description_topic,
      "Topic of the URDF, where the bags have several");
  add("--robot-meshes-topic", &files->robot_meshes_topic,
      "Topic of the link meshes, where the bags have several");
  addRepeated("--topic", &files->objects,
              "OBJECT=TOPIC: where an object's meshes are, if several topics have them, or "
              "instead of the configuration's topic");
  line->refuseTogether("--robot-description", "--robot-description-topic");
}

}  // namespace deformable_contact_monitor
