// The scene of a cycle: its bodies, their poses and meshes, and the pairs that are computed.
#pragma once

#include <ros/time.h>

#include <functional>
#include <memory>
#include <memory_resource>
#include <optional>
#include <string>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle/part_chooser.h"
#include "monitor/cycle/rigid_place.h"
#include "monitor/cycle_report.h"
#include "monitor/input/mesh_input.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// How the lookup of a cycle's transforms went, for diagnostics and warnings.
struct TransformReport {
  struct Miss {
    std::string body;
    PoseAnswer answer;
  };
  double waited_s = 0;             // how long the cycle's meshes waited for transforms
  std::vector<std::string> asked;  // names of the bodies whose transforms were looked up
  std::vector<Miss> misses;
};

// The pairs that a cycle is about: those of these objects, or those without a deformable object.
struct CycleTrigger {
  std::vector<std::size_t> objects;
  bool robot = false;
};

// What a question about states of the robot is about (monitor/planning), by body.
struct StatesAsked {
  std::vector<bool> moved;    // links and rigid objects that the states pose
  std::vector<bool> unclear;  // those of which nobody knows whether they move along
  std::vector<bool> asked;    // bodies that are asked about

  // Returns whether the states decide about this pair.
  bool has(const MonitoredPair& pair) const {
    return (mayMove(pair.a) || mayMove(pair.b)) && (asked[pair.a] || asked[pair.b]);
  }
  bool mayMove(BodyId id) const { return moved[id] || unclear[id]; }
};

// Returns the mesh to use of an object, or null and why there is none. The mesh must live until the
// call that asked for it returns.
using MeshChoice = std::function<const IncomingMesh*(std::size_t object, std::string* why_not)>;

// Bodies are the robot's links in URDF order, then the rigid objects, then the others. While no
// robot is known, a single body "robot" that is UNKNOWN stands in for its links: nobody must
// mistake their absence for "no contact". One thread at a time.
class MonitorScene {
 public:
  // The parameters must outlive this, and so must the memory of the vertices. There is no robot
  // until setRobot().
  explicit MonitorScene(
      const MonitorParameters& parameters,
      std::pmr::memory_resource& vertex_memory = *std::pmr::new_delete_resource());

  // Builds the scene anew with these links and the SRDF's rules. The names of links and objects
  // must differ.
  void setRobot(const RobotGeometry& robot);

  void setAllowedContacts(const AllowedContacts& allowed);
  // A hold ends in prepare() when the object has a newer mesh with other triangles. It is among
  // rules().ended_holds then, until the next call of this function.
  void setAttached(const AttachedObjects& attached);
  const ContactRules& rules() const { return rules_; }

  // Sets the margin [m] of every body without a margin of its own.
  void setMargin(double margin_m);
  // Changes which classes of pairs are computed. Bodies keep their ids.
  void setPairClasses(const PairClasses& classes);

  // Returns the frames that a cycle of this object at stamp `t` waits for, with their stamps: the
  // frame of its mesh, and those of the links and rigid objects that it may touch. Empty if the
  // mesh was rejected. A cycle does not wait for the frames of other objects.
  std::vector<FrameAtStamp> awaitedFrames(std::size_t object, const ros::Time& t,
                                          const IncomingMesh& mesh) const;
  // Returns the frames whose poses the robot's own cycles need.
  std::vector<std::string> framesOfRobotCycle() const;

  // Brings the bodies of the cycle's pairs (isOfCycle) to stamp `t`. Links and rigid objects are
  // posed at `t`. Each other object, also one that triggered the cycle, has its newest accepted
  // mesh at `t`, posed at that mesh's own stamp. Other bodies stay as they are and take no part.
  // Links and rigid objects are posed only if an enabled pair of known bodies needs them. A body
  // without mesh or pose is UNKNOWN, and its pairs are off.
  TransformReport prepare(const ros::Time& t, const CycleTrigger& trigger, const MeshInputs& inputs,
                          const TransformLookup& lookup);

  // Brings the bodies of a question's pairs to the present, as prepare() does those of a cycle. The
  // chosen meshes are posed at their own stamps, and at `t` the links and rigid objects that the
  // states do not move. Those that they move get no pose here. A scene for such questions has no
  // cycles.
  void prepareStates(const ros::Time& t, StatesAsked question, const MeshChoice& choose,
                     const TransformLookup& lookup);

  // Prepares a report without detection: deformable object i is UNKNOWN because of why[i], unless
  // that is empty. Other bodies are left out.
  void markUnknown(const std::vector<std::string>& why);

  // Returns a report of the bodies and pairs as they are now, without a result.
  CycleReport makeReport(const ros::Time& stamp, std::uint64_t cycle) const;

  // Returns the scene, for setting where bodies were at the beginning of a time interval, or other
  // margins for a question. The caller must leave the pairs, and the margins after it, as they
  // were.
  Scene& sceneOfStep() { return scene_; }

  const Scene& scene() const { return scene_; }
  // Bodies before it are links; those from it on, and before firstObject(), are rigid objects.
  BodyId firstRigid() const { return first_rigid_; }
  BodyId firstObject() const { return first_object_; }
  // Returns where a link or a rigid object is.
  FramePlace placeOf(BodyId id) const;
  // Returns the mesh that the scene holds of an object; null for a link and a rigid object.
  const IncomingMesh* loadedMesh(BodyId id) const {
    return isPosed(id) ? nullptr : &loaded_[id - first_object_];
  }
  const std::vector<BodyStatus>& bodies() const { return bodies_; }
  const std::vector<MonitoredPair>& pairs() const { return pairs_; }
  const std::vector<MonitoredPair>& partPairs() const { return part_pairs_; }

 private:
  // The pose of one body, which is to be looked up.
  struct Question {
    BodyId body;
    FrameAtStamp frame;
  };

  // Returns the question for the pose of a link or a rigid object at stamp `t`.
  FrameAtStamp frameAt(BodyId id, const ros::Time& t) const;
  void listPairs();
  TransformReport prepareChosen(const ros::Time& t, const CycleTrigger& trigger,
                                const MeshChoice& choose, const TransformLookup& lookup);
  // Returns whether the cycle, or the question, is about this pair.
  bool isAbout(const MonitoredPair& pair) const {
    return isOfCycle(bodies_, pair) && (!states_ || states_->has(pair));
  }
  void followParts(const ros::Time& t, const MeshChoice& choose);
  void applyMargin();
  void clearStatuses();
  void markTriggered(const CycleTrigger& trigger);
  bool isLink(BodyId id) const { return id < first_rigid_; }
  // Returns whether TF poses the body at the stamp of the cycle: it is a link or a rigid object.
  bool isPosed(BodyId id) const { return id < first_object_; }
  const RigidParameters& rigid(BodyId id) const { return parameters_.rigids[id - first_rigid_]; }
  bool sharesMargin(BodyId id) const;
  std::vector<const IncomingMesh*> chooseMeshes(const MeshChoice& choose);
  std::vector<bool> neededBodies() const;
  void enablePairs();
  void poseBodies(const std::vector<Question>& questions, const TransformLookup& lookup,
                  TransformReport* report);
  void loadMesh(std::size_t object, const IncomingMesh& mesh);
  void showParts(std::size_t object);
  bool isKnown(BodyId id) const { return bodies_[id].unknown_because.empty(); }

  const MonitorParameters& parameters_;
  std::pmr::memory_resource& vertex_memory_;
  ContactRules rules_;
  // They replace the parameters' values once they were set.
  std::optional<PairClasses> classes_;
  std::optional<double> margin_m_;
  Scene scene_;
  std::vector<BodyStatus> bodies_;
  // By body, of those that TF poses: why it is UNKNOWN for good; empty: it is not.
  std::vector<std::string> posed_problems_;
  std::vector<MonitoredPair> pairs_, part_pairs_;  // of bodies; of named parts (CycleReport)
  std::shared_ptr<const std::vector<PartPair>> allowed_parts_;  // CycleReport's
  std::vector<IncomingMesh> loaded_;                            // by object: the mesh in the scene
  std::vector<PartChooser> choosers_;                           // by object
  std::vector<std::shared_ptr<const BodyParts>> parts_in_scene_;  // by object
  BodyId first_rigid_ = 0, first_object_ = 0;
  std::optional<StatesAsked> states_;  // the question; nothing: there are cycles
};

}  // namespace deformable_contact_monitor
