// Writes bags of a small scene and evaluates them.
#include "written_bag.h"

#include <console_bridge/console.h>
#include <deformable_contact_monitor/DeformableMesh.h>
#include <deformable_contact_monitor/LinkMeshes.h>
#include <std_msgs/String.h>
#include <tf2_msgs/TFMessage.h>
#include <unistd.h>
#include <visualization_msgs/MarkerArray.h>

#include <cstdio>
#include <memory>

#include "core/cpu_detector.h"
#include "tools/bags/bag_cycles.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

ros::Time at(double s) {
  constexpr double kStart = 1000;
  return ros::Time(kStart + s);
}

WrittenBag::WrittenBag() {
  close(mkstemps(path_, 4));
  bag_.open(path_, rosbag::bagmode::Write);
}

WrittenBag::~WrittenBag() { std::remove(path_); }

void WrittenBag::transform(const std::string& topic, const ros::Time& received,
                           const ros::Time& stamp, const std::string& frame, double z,
                           const std::string& publisher) {
  tf2_msgs::TFMessage message;
  message.transforms.resize(1);
  geometry_msgs::TransformStamped& transform = message.transforms[0];
  transform.header.stamp = stamp;
  transform.header.frame_id = "base_link";
  transform.child_frame_id = frame;
  transform.transform.translation.z = z;
  transform.transform.rotation.w = 1;
  if (publisher.empty()) return add(topic, received, message);
  namespace traits = ros::message_traits;
  bag_.write(topic, received, message,
             boost::make_shared<ros::M_string>(
                 ros::M_string{{"callerid", publisher},
                               {"type", traits::datatype(message)},
                               {"md5sum", traits::md5sum(message)},
                               {"message_definition", traits::definition(message)}}));
}

void WrittenBag::mesh(const ros::Time& received, const ros::Time& stamp,
                      const std::string& object) {
  DeformableMesh mesh;
  mesh.header.stamp = stamp;
  mesh.header.frame_id = "camera";
  mesh.object = object;
  mesh.vertices = {0, 0, 0, 0.2F, 0, 0, 0, 0.2F, 0};
  mesh.triangles = {0, 1, 2};
  add("/" + object, received, mesh);
}

visualization_msgs::Marker WrittenBag::markerOf(double s, std::int32_t action) {
  visualization_msgs::Marker marker;
  marker.action = action;
  marker.type = visualization_msgs::Marker::TRIANGLE_LIST;
  marker.header.frame_id = "camera";
  if (action == visualization_msgs::Marker::ADD) marker.header.stamp = at(s);
  marker.scale.x = marker.scale.y = marker.scale.z = marker.pose.orientation.w = 1;
  marker.points.resize(3);
  marker.points[1].x = marker.points[2].y = 0.2;
  return marker;
}

void WrittenBag::markerArray(double s, std::int32_t action) {
  visualization_msgs::MarkerArray array;
  array.markers = {markerOf(s, action), markerOf(s, visualization_msgs::Marker::DELETE)};
  array.markers[0].id = 2;
  array.markers[1].id = 1;
  add("/cloth", at(s + kDelay), array);
}

void WrittenBag::meshes(int first, int count) {
  for (int i = first; i < first + count; ++i) {
    finger(kPeriod * i);
    mesh(at(kPeriod * i + kDelay), at(kPeriod * i), "cloth");
  }
}

void WrittenBag::links(double s, double z, const std::string& more) {
  LinkMeshes message;
  message.header.stamp = at(s);
  for (const std::string& name : {std::string("finger"), more}) {
    if (name.empty()) continue;
    LinkMesh link;
    link.link = name;
    const float h = static_cast<float>(z);
    link.vertices = {0.05F, 0.05F, h - 1, 0.05F, 0.05F, h + 1, 0.05F, 0.06F, h};
    link.triangles = {0, 1, 2};
    message.meshes.push_back(link);
  }
  add("/contact_monitor/robot_meshes", at(s), message);
}

void WrittenBag::text(double s, const std::string& topic, const std::string& data) {
  std_msgs::String message;
  message.data = data;
  add(topic, at(s), message);
}

std::string WrittenBag::finish() {
  bag_.close();
  return path_;
}

std::string urdf(const std::string& joint_type, double size, double z) {
  const std::string side = std::to_string(size);
  return "<robot name='r'><link name='base_link'/><link name='finger'><collision><geometry><box "
         "size='" +
         side + " " + side + " " + side +
         "'/></geometry></collision></link><joint name='j' type='" + joint_type +
         "'><origin xyz='0 0 " + std::to_string(z) +
         "'/><parent link='base_link'/><child link='finger'/><axis xyz='0 0 1'/><limit lower='-9' "
         "upper='9' effort='1' velocity='1'/></joint></robot>";
}

Found evaluate(const BagFiles& files, const MonitorParameters& configured) {
  ros::Time::init();
  console_bridge::noOutputHandler();  // tf2 prints a line for each bad transform
  Found found;
  const auto warn = [&](const std::string& what) { found.warnings.push_back(what); };
  BagReader reader(files.bags, neededMessages(configured, files));
  BagContents contents = scanBags(&reader, files, configured, [](std::uint64_t) {});
  const BagSetup setup = setUpBags(files, configured, SceneObject(), &contents, warn);
  EvaluationRun run("cpu", makeCpuDetector(), Options(), stateRules(setup.parameters), {});
  BagCycles cycles(setup.parameters, contents, setup.robots, nullptr);
  cycles.run(&reader, [&](CycleReport* cycle) {
    if (!cycles.forgets().empty()) run.forget(cycles.forgets(), cycle->header.stamp);
    found.stamps.push_back(cycle->header.stamp);
    run.evaluate(cycle, &cycles.sceneOfStep());
    for (const ContactEvent& event : run.steps.events()) found.events.push_back(event);
    for (std::size_t i = 0; i < cycle->pairs.size(); ++i) {
      const ContactState& state = run.states.states.at(i);
      if (!isOfCycle(cycle->bodies, cycle->pairs[i]) || state.body_a != "finger") continue;
      found.states[state.body_b] += std::string("-nC!?P").at(state.state);
    }
  });
  found.late_cycles = cycles.lateCycles();
  found.bad_transforms = cycles.badTransforms();
  return found;
}

Found evaluate(WrittenBag* bag, const std::string& urdf_xml, const MonitorParameters& parameters) {
  BagFiles files;
  files.bags = {bag->finish()};
  files.reference_frame = "base_link";
  char path[] = "/tmp/recorded_time_XXXXXX.urdf";
  if (!urdf_xml.empty()) {
    close(mkstemps(path, 5));
    FILE* const file = std::fopen(path, "w");
    std::fputs(urdf_xml.c_str(), file);
    std::fclose(file);
    files.robot_description = path;
  }
  Found found = evaluate(files, parameters);
  if (!urdf_xml.empty()) std::remove(path);
  return found;
}

std::string statesOf(WrittenBag* bag, const std::string& urdf_xml) {
  return evaluate(bag, urdf_xml).states["cloth"];
}

std::string times(int count, char state) {
  return std::string(static_cast<std::size_t>(count), state);
}

}  // namespace deformable_contact_monitor
