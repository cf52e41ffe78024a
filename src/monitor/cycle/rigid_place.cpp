// Finds out where rigid objects are. A link that carries one keeps it where it was in the link's
// frame when it was attached.
#include "monitor/cycle/rigid_place.h"

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "monitor/time_difference.h"

namespace deformable_contact_monitor {
namespace {

// Returns the pose of the place in the reference frame. Throws std::invalid_argument.
RigidTransform poseAt(const FramePlace& place, const ros::Time& stamp, const std::string& object,
                      const MonitorParameters& parameters, const TransformLookup& lookup) {
  if (place.frame == parameters.reference_frame) return place.frame_from_body;
  const PoseAnswer answer = lookup.lookup({{place.frame, stamp}}).front();
  if (!answer.problem.empty()) throw std::invalid_argument(object + ": " + answer.problem);
  return compose(answer.pose, place.frame_from_body);
}

}  // namespace

RigidTransform compose(const RigidTransform& outer, const RigidTransform& inner) {
  if (inner.isIdentity()) return outer;
  RigidTransform both;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* const r = &outer.rotation[3 * row];
    for (std::size_t column = 0; column < 3; ++column) {
      const double* const c = &inner.rotation[column];
      both.rotation[3 * row + column] = r[0] * c[0] + r[1] * c[3] + r[2] * c[6];
    }
    const double* const t = inner.translation;
    both.translation[row] = r[0] * t[0] + r[1] * t[1] + r[2] * t[2] + outer.translation[row];
  }
  return both;
}

RigidTransform inverse(const RigidTransform& transform) {
  RigidTransform inverted;
  const double* const t = transform.translation;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* const c = &transform.rotation[row];
    for (std::size_t column = 0; column < 3; ++column) {
      inverted.rotation[3 * row + column] = c[3 * column];
    }
    inverted.translation[row] = -(c[0] * t[0] + c[3] * t[1] + c[6] * t[2]);
  }
  return inverted;
}

const RigidParameters* findRigid(const MonitorParameters& parameters, const std::string& name) {
  const auto& rigids = parameters.rigids;
  const auto found = std::find_if(rigids.begin(), rigids.end(),
                                  [&](const RigidParameters& rigid) { return rigid.name == name; });
  return found == rigids.end() ? nullptr : &*found;
}

FramePlace placeOf(const RigidParameters& rigid, const AttachedObjects& attached,
                   const MonitorParameters& parameters) {
  const auto found = attached.find(rigid.name);
  if (found == attached.end() || found->second.grip == nullptr) return {rigid.frame};
  const RigidGrip& grip = *found->second.grip;
  return {parameters.frameOf(grip.link), grip.link_from_object};
}

std::shared_ptr<const RigidGrip> findGrip(const GripQuestion& question,
                                          const MonitorParameters& parameters,
                                          const TransformLookup& lookup) {
  const std::string& name = question.rigid.name;
  if (question.radius_m != 0) {
    throw std::invalid_argument("a radius is not supported for '" + name +
                                "', which is rigid: hold all of it, with radius 0");
  }
  const FramePlace object = placeOf(question.rigid, question.attached, parameters);
  const FramePlace link{parameters.frameOf(question.link)};
  std::vector<std::string> frames;
  for (const FramePlace& place : {object, link}) {
    if (place.frame != parameters.reference_frame) frames.push_back(place.frame);
  }
  const ros::Time stamp =
      lookup.newestCommon(frames, parameters.max_mesh_age_s, question.now).value_or(ros::Time());
  const double age_s = secondsBetween(question.now, stamp);
  if (!stamp.isZero() && !question.now.isZero() && age_s > parameters.max_mesh_age_s) {
    throw std::invalid_argument(name + ": the newest transforms of it and of " + question.link +
                                " are " + std::to_string(age_s) +
                                " s old, and max_mesh_age_s less");
  }
  const RigidTransform link_pose = poseAt(link, stamp, question.link, parameters, lookup);
  const RigidTransform pose = poseAt(object, stamp, name, parameters, lookup);
  return std::make_shared<const RigidGrip>(
      RigidGrip{question.link, compose(inverse(link_pose), pose)});
}

}  // namespace deformable_contact_monitor
