// What tests of questions about states share: an arm beside a cloth.
#pragma once

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "monitor/planning/state_questions.h"

namespace deformable_contact_monitor {

using Names = std::vector<std::string>;

// An arm of 1 m that turns about z, and a hand at its end that slides outwards.
inline constexpr const char* kRobot = R"(<robot name="test">
  <link name="base"/>
  <link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry>
    </collision></link>
  <link name="hand"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="arm"/><child link="hand"/>
    <origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/></joint>
</robot>)";
inline constexpr double kFree = 0, kAtCloth = M_PI / 2;  // positions of `turn`

inline std::string noFile(const std::string& uri) { throw std::runtime_error(uri); }

inline MonitorParameters parameters() {
  MonitorParameters p;
  p.reference_frame = "base";
  p.objects = {{"cloth", "", 0.25F, true}};
  p.objects[0].parts = {{"low", {{0, 0}}}};
  p.pair_classes = {true, false, false, false, true, false};
  p.margin_m = 0.25F;
  p.max_mesh_age_s = 0.5;
  p.tf_timeout_s = 0;
  const TriangleMesh rod{{0, -.0625F, 0, 0.25F, .0625F, 0, 0, 0, .0625F}, {0, 1, 2}};
  p.rigids.push_back({"tool", "tool_tip", std::make_shared<const TriangleMesh>(rod)});
  return p;
}

// Returns a rule that lets two bodies touch.
inline AllowedContact allowed(const std::string& body_a, const std::string& body_b) {
  AllowedContact rule;
  rule.body_a = body_a;
  rule.body_b = body_b;
  rule.allowed = true;
  return rule;
}

class StateQuestionsTest : public ::testing::Test {
 protected:
  StateQuestionsTest() {
    robot_ = load({{kRobot, "", "", {}}});
    give();
    put("arm", "base", 0);
    put("hand", "arm", 1);
    put("tool_tip", "base", -5);
  }

  static std::shared_ptr<const RobotGeometry> load(const std::vector<RobotDescription>& robots) {
    return std::make_shared<const RobotGeometry>(loadRobots(robots, {}, noFile));
  }

  // A sheet in the plane x = 0 at y of 0.8 to 1.2, of two triangles.
  void give(float x = 0, const std::string& frame = "base") {
    auto message = boost::make_shared<DeformableMesh>();
    message->header.stamp = now_;
    message->header.frame_id = frame;
    message->topology_id = 3;
    message->vertices = {x, 0.8F, -.5F, x, 1.2F, -.5F, x, 1.2F, .5F, x, 0.8F, .5F};
    message->triangles = {0, 1, 2, 0, 2, 3};
    IncomingMesh mesh{message};
    meshes()[0].store(mesh);
    meshes()[0].take(now_, &mesh);
    EXPECT_EQ(mesh.problem, "");
  }

  MeshInputs& meshes() {
    if (meshes_.empty()) meshes_ = makeMeshInputs(parameters_);
    return meshes_;
  }

  void put(const std::string& frame, const std::string& parent, double x, double angle = 0) {
    putInto(&transforms_, frame, parent, x, angle);
  }
  void putInto(tf2::BufferCore* buffer, const std::string& frame, const std::string& parent,
               double x, double angle) {
    geometry_msgs::TransformStamped t;
    t.header.frame_id = parent;
    t.header.stamp = now_;
    t.child_frame_id = frame;
    t.transform.translation.x = x;
    t.transform.rotation.z = std::sin(angle / 2);
    t.transform.rotation.w = std::cos(angle / 2);
    buffer->setTransform(t, "test");
  }

  StateQuestions& questions() {
    if (!questions_) {
      questions_ = std::make_unique<StateQuestions>(
          parameters_,
          QuestionSources{requests_, meshes(), transforms_, [this] { return robot_; },
                          [this] { return now_; }},
          makeCpuStateChecker());
    }
    return *questions_;
  }

  StatesChecked ask(const std::vector<double>& positions, const Names& joints = {"turn"},
                    float margin = 0, const Names& objects = {}) {
    StatesToCheck question;
    question.positions = positions;
    question.joint_names = joints;
    question.margin = margin;
    question.objects = objects;
    return questions().answer(question);
  }

  // Returns a letter for each state, and the reason unless it is empty.
  std::string states(const StatesChecked& answer) {
    std::string text;
    for (const std::uint8_t state : answer.state) text += std::string("-nCa?P").at(state);
    return text + (answer.reason.empty() ? "" : " " + answer.reason);
  }

  MonitorParameters parameters_ = parameters();
  ros::Time now_{100};
  LoopRequests requests_{AllowedContacts()};
  MeshInputs meshes_;
  TransformBuffer transforms_;
  std::shared_ptr<const RobotGeometry> robot_;
  std::unique_ptr<StateQuestions> questions_;
};

}  // namespace deformable_contact_monitor
