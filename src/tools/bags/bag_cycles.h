// Makes the monitor's cycles from bags: every deformable mesh gets its cycle at its own stamp.
//
// evaluate_bag and measure_trade both run their cycles through BagCycles.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle/step_planner.h"
#include "monitor/input/transform_buffer.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_reader.h"
#include "tools/simulation/scene_object.h"

namespace deformable_contact_monitor {

// An object that is not in the bag. Its states come from files or from a simulation.
struct PlayedObject {
  std::string object;  // the name of one of the parameters' objects
  std::string frame;   // of the vertices
  double rate_hz = 30;
  // Returns the next state; nothing after the last one.
  std::function<std::optional<MeshFrame>(const LinkPose& pose)> next;
};

// Applies the node's rules for meshes, transforms and states without its queues and clocks. Every
// mesh gets its cycle, in the order of stamps; meshes with the same stamp share one; no transform
// is late, as it may be for the node (lateCycles()). So the same bags always give the same cycles.
//
// A cycle knows the robot and the static transforms that had been recorded when the node would have
// run it: when its mesh came or, at most tf_timeout_s later, its transforms. Before the first of
// these were recorded, it knows the first.
//
// A mesh waits until the bags are read some seconds beyond it, so that transforms which were
// recorded late are known. Memory holds only those seconds of the bags.
class BagCycles {
 public:
  // The references must outlive this. `robots` has at least one. `played` may be null.
  BagCycles(const MonitorParameters& parameters, const BagContents& contents,
            const History<RobotGeometry>& robots, const PlayedObject* played);

  // Calls visit(report) for each cycle; the report has no result yet. Call it once. Returns what
  // BagReader::read returns.
  std::string run(BagReader* reader, const std::function<void(CycleReport*)>& visit);

  // Returns the scene of the cycle that is being visited. CycleDetection changes it for each
  // interval.
  Scene& sceneOfStep() { return scene_.sceneOfStep(); }

  // Returns why the visited cycle forgets all earlier ones, as the node does: "robot changed", or
  // the clock went back. Empty: it does not.
  const std::string& forgets() const { return forgets_; }

  // Returns the index of the robot that the visited cycle has.
  std::size_t robot() const { return robot_; }

  std::uint64_t refusedTransforms() const { return refused_transforms_; }
  // Counts those of them that are refused for what they say (see isValid()) or because their stamp
  // is far ahead, and not because tf2 has them already.
  std::uint64_t badTransforms() const { return bad_transforms_; }

  // Counts the cycles that used a transform which was recorded more than tf_timeout_s after their
  // mesh, so that the node would not have waited for it.
  std::uint64_t lateCycles() const { return late_cycles_; }

  // How often the simulation of the played object undid a step, and why it did so first.
  struct UndoneSteps {
    std::uint64_t count = 0;
    std::string first;
  };
  const UndoneSteps& undoneSteps() const { return undone_steps_; }

 private:
  // A mesh that waits for its cycle.
  struct Event {
    ros::Time stamp;
    // The bags must be read up to this time of receipt first. For a played object, this is a
    // transform's stamp.
    ros::Time ready;
    // The time of receipt up to which the cycle knows the robot and the static transforms. Of a
    // played object, it is that of a transform with its stamp.
    ros::Time due;
    bool played = false;
    std::size_t input = 0;     // index of inputs_
    std::uint64_t number = 0;  // BagContents::Mesh::number
    std::size_t part = 0;      // BagContents::Mesh::part
    ros::Time place;           // BagContents::Mesh::place
    bool is_passing = false;   // BagContents::Mesh::is_passing
  };
  // A frame whose static transform changes.
  struct ChangingFrame {
    const History<StaticTransform>* transforms = nullptr;
    std::size_t current = 0;  // which of them is in the buffer
  };

  // Lists the meshes that get cycles.
  void plan(const BagContents& contents);
  // These read messages: meshes wait, transforms go to the buffer.
  void take(const BagMessage& message);
  void takeTransforms(const BagMessage& message);
  void addTransform(const geometry_msgs::TransformStamped& transform, const std::string& publisher,
                    bool is_static);
  void notePlayed(const ros::Time& received);
  void postpone(const ros::Time& change);
  bool isLate(const Event& event, const BagMessage& message) const;
  void noteLate(const ros::Time& received);
  // These run the cycles whose meshes are ready.
  void startParts(std::size_t part, bool is_end, const std::function<void(CycleReport*)>& visit);
  void startPart(std::size_t part, const std::function<void(CycleReport*)>& visit);
  bool isReady(const Event& event) const;
  void release(const std::function<void(CycleReport*)>& visit);
  std::optional<IncomingMesh> nextMesh(const Event& event);
  DeformableMesh::ConstPtr nextPlayed(const ros::Time& stamp);
  bool knowsSame(const ros::Time& a, const ros::Time& b) const;
  void recallAt(const ros::Time& due);
  void recallTransforms(const ros::Time& due);
  void detectAt(const ros::Time& stamp, const CycleTrigger& trigger,
                const std::function<void(CycleReport*)>& visit);

  const MonitorParameters& parameters_;
  const BagContents& contents_;
  const History<RobotGeometry>& robots_;
  const PlayedObject* played_;
  std::map<std::string, std::size_t> input_of_topic_;
  MonitorScene scene_;
  std::size_t robot_ = 0;  // of robots_: the one in scene_
  std::vector<ChangingFrame> changing_frames_;
  std::set<ros::Time> changes_;  // times of receipt when robot or static transforms change
  std::vector<RecordedMeshReader> mesh_readers_;  // by object
  MeshInputs inputs_;
  ros::Time reading_;  // when the message that is being read was received
  TransformBuffer buffer_;
  const TransformLookup lookup_;
  StepPlanner planner_;
  std::vector<Event> events_;  // ascending stamps
  std::size_t next_ = 0;       // of events_
  std::size_t part_ = 0;       // of the bags, which is being read
  std::string forgets_;
  std::size_t next_played_ = 0;  // of events_: the first whose stamp no transform has reached
  // Messages that wait for their cycle, by number. They are decoded in the order of stamps, because
  // a mesh may use the triangles of the mesh before it.
  std::map<std::uint64_t, BagMessage> held_;
  std::map<std::uint64_t, std::size_t> event_of_mesh_;  // index of events_, by number
  // Meshes for whose transforms the node would wait, by number, in the order of receipt, and those
  // for which it would have given up.
  std::deque<std::uint64_t> awaiting_;
  std::set<std::uint64_t> late_;
  std::uint64_t meshes_read_ = 0;
  // The parts of meshes that were recorded after the clock had gone back, and are from before it,
  // by number, until they are read. Meanwhile the later transforms wait.
  std::map<std::uint64_t, std::size_t> leftovers_;
  std::vector<BagMessage> postponed_;
  ros::Time received_, newest_transform_;  // the newest times that were read so far
  bool at_end_ = false;                    // the bags are read to their end
  bool played_out_ = false;
  std::uint64_t cycle_ = 0, refused_transforms_ = 0, bad_transforms_ = 0, late_cycles_ = 0;
  UndoneSteps undone_steps_;
};

}  // namespace deformable_contact_monitor
