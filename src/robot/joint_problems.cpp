// Follows each joint to the joint that carries it, and to the one that it mimics. Takes time in
// proportion to the number of joints, because anybody may write a URDF.
#include "robot/joint_problems.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <string>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kNone = static_cast<std::size_t>(-1);

// The joint at which the chain from a joint ends, or one joint of the loop that it enters.
struct End {
  std::size_t joint = kNone;
  bool is_circle = false;
};

// Follows each joint to its next one, until there is none.
std::vector<End> endsOf(const std::vector<std::size_t>& next) {
  std::vector<End> ends(next.size());
  std::vector<std::size_t> walked_from(next.size(), kNone);
  for (std::size_t first = 0; first < next.size(); ++first) {
    std::vector<std::size_t> way;
    std::size_t at = first;
    while (at != kNone && walked_from[at] == kNone) {
      walked_from[at] = first;
      way.push_back(at);
      at = next[at];
    }
    if (way.empty()) continue;
    End end{way.back(), false};
    if (at != kNone) end = walked_from[at] == first ? End{at, true} : ends[at];
    for (const std::size_t joint : way) ends[joint] = end;
  }
  return ends;
}

std::string quoted(const std::string& name) { return "'" + name + "'"; }

// Names joints, the first few of them.
std::string namesOf(const std::vector<const RobotJoint*>& joints) {
  constexpr std::size_t kShown = 8;
  std::string names;
  for (std::size_t i = 0; i < std::min(joints.size(), kShown); ++i) {
    names += (i == 0 ? "" : ", ") + quoted(joints[i]->name);
  }
  return names + (joints.size() > kShown ? ", ..." : "");
}

// Returns the loop of joints that this one is in.
std::string loopText(const std::vector<RobotJoint>& joints, const std::vector<std::size_t>& carrier,
                     std::size_t first) {
  std::vector<const RobotJoint*> loop;
  std::size_t at = first;
  do {
    loop.push_back(&joints[at]);
    at = carrier[at];
  } while (at != first);
  return loop.size() == 1 ? "joint " + namesOf(loop) + " joins a link to itself"
                          : "joints " + namesOf(loop) + " form a loop";
}

void findTreeProblems(std::vector<RobotJoint>* joints) {
  std::map<std::string, std::vector<std::size_t>> carrying;  // by child link
  for (std::size_t i = 0; i < joints->size(); ++i) carrying[(*joints)[i].child].push_back(i);
  for (const auto& [link, by] : carrying) {
    if (by.size() == 1) continue;
    std::vector<const RobotJoint*> several;
    for (const std::size_t i : by) several.push_back(&(*joints)[i]);
    const std::string text =
        "link " + quoted(link) + " has several parents, by the joints " + namesOf(several);
    for (const std::size_t i : by) (*joints)[i].tree_problem = text;
  }
  std::vector<std::size_t> carrier;
  for (const RobotJoint& joint : *joints) {
    const auto found = carrying.find(joint.parent);
    carrier.push_back(found == carrying.end() ? kNone : found->second.front());
  }
  const std::vector<End> ends = endsOf(carrier);
  std::map<std::size_t, std::string> loops;  // by the joint that they were met at
  for (std::size_t i = 0; i < joints->size(); ++i) {
    if (!ends[i].is_circle || !(*joints)[i].tree_problem.empty()) continue;
    std::string& text = loops[ends[i].joint];
    if (text.empty()) text = loopText(*joints, carrier, ends[i].joint);
    (*joints)[i].tree_problem = text;
  }
}

void findMimicProblems(std::vector<RobotJoint>* joints) {
  std::map<std::string, std::size_t> by_name;
  for (std::size_t i = 0; i < joints->size(); ++i) by_name.emplace((*joints)[i].name, i);
  std::vector<std::size_t> followed;
  for (const RobotJoint& joint : *joints) {
    const auto found = joint.hasPosition() ? by_name.find(joint.mimics) : by_name.end();
    followed.push_back(found == by_name.end() ? kNone : found->second);
  }
  const std::vector<End> ends = endsOf(followed);
  for (std::size_t i = 0; i < joints->size(); ++i) {
    RobotJoint& joint = (*joints)[i];
    if (!joint.hasPosition() || joint.mimics.empty()) continue;
    const RobotJoint& last = (*joints)[ends[i].joint];
    std::string why;
    if (followed[i] == i) {
      why = "itself";
    } else if (ends[i].is_circle) {
      why = quoted(joint.mimics) + ", and that leads round in a circle";
    } else if (!last.hasPosition()) {
      why = quoted(joint.mimics) + ", and " + quoted(last.name) + " has no position";
    } else if (!last.mimics.empty()) {
      why = quoted(joint.mimics) + ", but there is no joint " + quoted(last.mimics);
    } else {
      continue;
    }
    joint.mimic_problem = "joint " + quoted(joint.name) + " mimics " + why;
  }
}

}  // namespace

void findJointProblems(std::vector<RobotJoint>* joints) {
  findTreeProblems(joints);
  findMimicProblems(joints);
}

}  // namespace deformable_contact_monitor
