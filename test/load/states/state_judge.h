// Judges every message of states by the truth: by what StateWorld sent, and by brute force.
//
// What is judged of a state that says NONE, NEAR, CONTACT or PASSED:
// - It is right for the data at its stamp. With motion: swept, nothing touched since the state
//   before, unless it says so; and the interval starts where that state ended.
// - Its data are valid, not from before a reset, not from the future, and not too old.
// - It comes from a cycle that began after the last ~reset and ~set_enabled false were answered.
// UNKNOWN is always right; share() tells how often something was known.
#pragma once

#include <deformable_contact_monitor/ContactStates.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle_report.h"
#include "state_world.h"

namespace deformable_contact_monitor {

class StateJudge {
 public:
  // Both must outlive this.
  StateJudge(StateWorld& world, const MonitorParameters& parameters)
      : world_(world), parameters_(parameters) {}

  // Notes that a step of the loop begins, with the margin that was asked for last [m].
  void beginStep(double margin_m) { margins_m_ = {margin_m}; }
  // Notes that another margin is asked for, which may hold in this step or from the next one on.
  void changeMargin(double margin_m) { margins_m_.push_back(margin_m); }
  // Notes that a cycle begins, whose number is not known yet.
  void beginCycle(const MeshInputs& meshes);
  // Notes that what came before is forgotten, of an object or, if the name is empty, of everything:
  // no interval starts there any more.
  void forget(const std::string& body);
  // Notes that nothing that was found in cycles that have begun may be known any more: ~reset, or
  // ~set_enabled was answered, with that value.
  void answer(bool is_enabled);

  // Judges the message of a cycle.
  void judgeCycle(const CycleReport& report, const ContactStates& message);
  // Judges a message without a cycle. `expired`: states that are too old were removed just now.
  void judge(const ContactStates& message, bool expired);

  const std::vector<std::string>& faults() const { return faults_; }
  void addFault(const std::string& fault) { faults_.push_back(fault); }
  std::size_t stateCount() const { return states_; }
  std::size_t knownCount() const { return known_count_; }
  std::size_t judgedCount() const { return judged_; }
  std::size_t passedCount() const { return passed_; }

 private:
  using Names = std::pair<std::string, std::string>;

  // Holds what a cycle used of a body.
  struct Used {
    ros::Time stamp;
    std::string frame;
    std::optional<std::size_t> object;
    std::uint32_t topology = 0;
    RigidTransform pose;
    SmallShape local, placed;  // in its frame, and in the scene
  };
  // A cycle that an interval may start from.
  struct Start {
    std::uint64_t cycle;  // its number
    ros::Time stamp;
    std::map<std::string, Used> bodies;
  };
  struct Known {
    std::uint8_t state;
    ros::Time stamp;
    std::uint64_t cycle;             // in which it was found
    ros::Time reached_a, reached_b;  // the newest data of each body since the pair is known
  };
  // A state that a cycle found, with all that is needed to judge it.
  struct Claim {
    const CycleReport* report;
    const ContactState* state;
    const BodyStatus *a, *b;
    Used used_a, used_b;
  };

  void fault(const ContactState& state, const std::string& what);
  void judgeState(const CycleReport* report, const ContactState& state, bool expired);
  void judgeKept(const ContactState& state, const Known& before, bool expired);
  void judgeOlder(const CycleReport& report, const ContactState& state, Known* known);
  // Notes what data of the bodies the cycle used.
  static void reach(const CycleReport& report, const ContactState& state, Known* known);
  void judgeClaim(const CycleReport& report, const ContactState& state, const Known* before);
  void judgeAtStamp(const Claim& claim);
  void judgeInterval(const Claim& claim, const Known* before);
  bool judgeData(const Claim& claim);
  // Returns whether what has that stamp is older than max_mesh_age_s.
  bool isTooOld(const ros::Time& now, const ros::Time& stamp) const;
  std::optional<Used> usedOf(const BodyStatus& body) const;
  std::optional<std::size_t> objectOf(const std::string& name) const;
  const Start* laterOfPartner(const Start* own, const Claim& claim) const;
  const Start* startOf(const Claim& claim) const;
  static bool hasBody(const Start& start, const std::string& name, const Used& now);
  static bool beginsFrom(const Start& start, const Claim& claim);
  std::optional<SmallMotion> motionOf(const Used& from, const Used& to) const;
  void rememberCycle(const CycleReport& report);

  StateWorld& world_;
  const MonitorParameters& parameters_;
  std::vector<double> margins_m_;
  std::vector<bool> refused_;            // by object: its newest mesh was refused
  std::map<std::string, Start> starts_;  // by object, and "robot"
  std::map<Names, Known> known_;
  std::uint64_t begun_ = 0, floor_ = 0;  // numbers of cycles
  bool is_enabled_ = true;
  std::vector<std::string> faults_;
  std::size_t states_ = 0, known_count_ = 0, judged_ = 0, passed_ = 0;
};

}  // namespace deformable_contact_monitor
