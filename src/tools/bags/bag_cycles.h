// The monitor's cycles for what bags hold: every deformable mesh at its own stamp.
#pragma once

#include <tf2/buffer_core.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle/monitor_scene.h"
#include "monitor/cycle/step_planner.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_meshes.h"
#include "tools/bags/bag_part.h"
#include "tools/bags/bag_reader.h"
#include "tools/common/mesh_player.h"

namespace deformable_contact_monitor {

// Where a link is, in the frame of a played object; nothing: transforms do not say.
using LinkPose = std::function<std::optional<Eigen::Isometry3d>(const std::string& link)>;

// An object that is not in the bag: its states come from files or a simulation.
struct PlayedObject {
  std::string object;  // one of the parameters' objects
  std::string frame;   // of the vertices
  double rate_hz = 30;
  // The next state; nothing: there is none any more.
  std::function<std::optional<MeshFrame>(const LinkPose& pose)> next;
};

// The node's rules for meshes, transforms and states, without its queues and clocks: every mesh has
// its cycle, in the order of stamps, meshes with one stamp share one, and no transform is late. So
// the same bags give the same cycles. Memory holds some seconds of the bag, not all of it.
class BagCycles {
 public:
  // The parameters and contents must outlive this. `played` may be null.
  BagCycles(const MonitorParameters& parameters, const BagContents& contents,
            const RobotGeometry& robot, const PlayedObject* played);

  // Hands each cycle to `visit`, without a result yet. Once. Returns what BagReader::read does.
  std::string run(BagReader* reader, const std::function<void(CycleReport*)>& visit);

  // As run(), but hands over the cycles of a part alone. Transforms, meshes, earlier states and a
  // played object have come the whole way from the bags' beginning, so each of these cycles is as
  // run() has it. Reads no further than the part goes. Parts have about as many meshes each.
  void runPart(const BagPart& part, BagReader* reader,
               const std::function<void(CycleReport*)>& visit);

  // That of the cycle that is being visited; for its steps, see StepRunner.
  Scene& sceneOfStep() { return scene_.sceneOfStep(); }

  std::uint64_t refusedTransforms() const { return refused_transforms_; }

 private:
  // One mesh that is to have its cycle.
  struct Event {
    ros::Time stamp;
    ros::Time ready;  // the bags must be read up to here, by receipt; played: by transforms' stamps
    bool played = false;
    std::size_t input = 0;     // of mailboxes_ and inputs_
    std::uint64_t number = 0;  // of the mesh in the bags
  };

  void plan(const BagContents& contents);
  void take(const BagMessage& message);
  void takeTransforms(const BagMessage& message);
  ros::Time beginningOf(const BagPart& part) const;
  bool isReady(const Event& event) const;
  void release(const std::function<void(CycleReport*)>& visit);
  std::optional<ReceivedMesh> nextMesh(const Event& event);
  DeformableMesh::ConstPtr nextPlayed(const ros::Time& stamp);
  void detectAt(const ros::Time& stamp, const CycleTrigger& trigger,
                const std::function<void(CycleReport*)>& visit);

  const MonitorParameters& parameters_;
  const BagContents& contents_;
  const PlayedObject* played_;
  std::map<std::string, std::size_t> input_of_topic_;
  MonitorScene scene_;
  std::vector<RecordedMeshReader> mesh_readers_;  // by object
  MeshMailboxes mailboxes_;
  MeshInputs inputs_;
  tf2::BufferCore buffer_;
  const TransformLookup lookup_;
  StepPlanner planner_;
  std::vector<Event> events_;  // ascending stamps
  std::size_t next_ = 0;       // of events_
  // Messages that were read and wait for their turn, by number: what they become may depend on
  // those before them in the order of stamps.
  std::map<std::uint64_t, BagMessage> held_;
  std::uint64_t meshes_read_ = 0;
  ros::Time received_, newest_transform_;  // of what was read so far
  bool at_end_ = false;                    // of the bags
  bool played_out_ = false;
  std::uint64_t cycle_ = 0, refused_transforms_ = 0;
};

// The topic of an object, absolute, for a monitor of the name /contact_monitor.
std::string topicOf(const ObjectParameters& object);

}  // namespace deformable_contact_monitor
