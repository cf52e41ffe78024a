// The scene of a cycle: which bodies there are, where they stand, and which pairs are looked at.
#pragma once

#include <ros/time.h>

#include <memory_resource>
#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

using MeshInputs = std::vector<MeshInput>;  // in the order of the objects

MeshInputs makeMeshInputs(const MonitorParameters& parameters);

// What the transforms of a cycle were like, for the diagnostics.
struct TransformReport {
  struct Miss {
    std::string body;
    PoseAnswer answer;
  };
  double waited_s = 0;
  std::vector<std::string> asked;  // bodies
  std::vector<Miss> misses;
};

// Whose cycle it is: that of some objects, or the robot's own.
struct CycleTrigger {
  std::vector<std::size_t> objects;
  bool robot = false;
};

// Bodies are the robot's links, then the objects. While no robot is known, one body "robot" that
// is UNKNOWN stands in for its links, so that nobody takes their silence for "no contact". One
// thread at a time.
class MonitorScene {
 public:
  // The parameters must outlive this, and so must the vertices' memory. Without a robot until
  // setRobot().
  explicit MonitorScene(
      const MonitorParameters& parameters,
      std::pmr::memory_resource& vertex_memory = *std::pmr::new_delete_resource());

  // Builds the scene anew, with the SRDF's rules. The names of links and objects must differ.
  void setRobot(const RobotGeometry& robot);

  void setAllowedContacts(const AllowedContacts& allowed);
  void setAttached(const AttachedObjects& attached);
  const ContactRules& rules() const { return rules_; }

  // Of every body that has no margin of its own [m].
  void setMargin(double margin_m);
  // The robot stays as it is: bodies keep their numbers.
  void setPairClasses(const PairClasses& classes);

  // Frames that the cycle of an object at `t` waits for, with their stamps: its own, and those of
  // the links that it may touch. Other objects' frames are nothing to wait for.
  std::vector<FrameAtStamp> awaitedFrames(std::size_t object, const ros::Time& t,
                                          const MeshInputs& inputs) const;
  // The links that the robot's own cycles pose, by frame.
  std::vector<std::string> selfPairedLinks() const;

  // Brings the bodies of a cycle's pairs (isOfCycle) to stamp `t`: links at t, each object with its
  // newest mesh at t, posed at that mesh's own stamp. Others are left as they are and take no part.
  // Links that no enabled pair of known bodies needs are not posed. Bodies that cannot be had are
  // UNKNOWN and their pairs are off.
  TransformReport prepare(const ros::Time& t, const CycleTrigger& trigger, const MeshInputs& inputs,
                          const TransformLookup& lookup);

  // Whether some pair is to be looked at after prepare().
  bool looksAtAny() const { return looks_at_any_; }

  // For a report without detection: object i is UNKNOWN because of why[i], unless that is empty;
  // links are not looked at.
  void markUnknown(const std::vector<std::string>& why);

  // Of a cycle with that stamp and number: its bodies and pairs as they are now, without a result.
  CycleReport makeReport(const ros::Time& stamp, std::uint64_t cycle) const;

  // To set where bodies were at the beginning of a step; pairs are to be as they were afterwards.
  Scene& sceneOfStep() { return scene_; }

  const Scene& scene() const { return scene_; }
  BodyId firstObject() const { return first_object_; }
  // What the scene holds of an object; null: a link.
  const AcceptedMesh* loadedMesh(BodyId id) const {
    return isLink(id) ? nullptr : &loaded_[id - first_object_];
  }
  const std::vector<BodyStatus>& bodies() const { return bodies_; }
  const std::vector<MonitoredPair>& pairs() const { return pairs_; }

 private:
  struct Question {
    BodyId body;
    FrameAtStamp frame;
  };

  void listPairs();
  void applyMargin();
  void clearStatuses();
  void markTriggered(const CycleTrigger& trigger);
  bool isLink(BodyId id) const { return id < first_object_; }
  std::vector<const AcceptedMesh*> chooseMeshes(const ros::Time& t, const MeshInputs& inputs);
  std::vector<bool> neededBodies() const;
  void enablePairs();
  void poseBodies(const std::vector<Question>& questions, const TransformLookup& lookup,
                  TransformReport* report);
  void loadMesh(std::size_t object, const AcceptedMesh& mesh);
  bool isKnown(BodyId id) const { return bodies_[id].unknown_because.empty(); }

  const MonitorParameters& parameters_;
  std::pmr::memory_resource& vertex_memory_;
  ContactRules rules_;
  // In place of the parameters'; nothing: as those.
  std::optional<PairClasses> classes_;
  std::optional<double> margin_m_;
  Scene scene_;
  std::vector<BodyStatus> bodies_;
  std::vector<std::string> link_problems_;  // of the links (or their stand-in); empty: none
  std::vector<MonitoredPair> pairs_;
  std::vector<AcceptedMesh> loaded_;  // by object: what the scene holds
  BodyId first_object_ = 0;
  bool looks_at_any_ = false;
};

}  // namespace deformable_contact_monitor
