// Where rigid objects are: in a TF frame of their own, or in that of the link that carries them.
#pragma once

#include <ros/time.h>

#include <memory>
#include <string>

#include "core/rigid_transform.h"
#include "monitor/cycle_report.h"
#include "monitor/input/transform_lookup.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// A TF frame, and where a body is in it.
struct FramePlace {
  std::string frame;
  RigidTransform frame_from_body{};

  bool operator==(const FramePlace& o) const {
    return frame == o.frame && frame_from_body == o.frame_from_body;
  }
};

// Returns the transform that applies `inner` first, then `outer`; exactly `outer` if `inner` is the
// identity.
RigidTransform compose(const RigidTransform& outer, const RigidTransform& inner);
// Returns the inverse of a transform whose rotation is orthonormal.
RigidTransform inverse(const RigidTransform& transform);

// Returns the rigid object of that name; null if there is none.
const RigidParameters* findRigid(const MonitorParameters& parameters, const std::string& name);

// Returns where a rigid object is: carried by a link if one has it in `attached`, else in the frame
// of its own.
FramePlace placeOf(const RigidParameters& rigid, const AttachedObjects& attached,
                   const MonitorParameters& parameters);

// What ~attach_object asks about a rigid object.
struct GripQuestion {
  const RigidParameters& rigid;
  std::string link;                 // that will carry it
  const AttachedObjects& attached;  // who carries it now
  float radius_m = 0;               // of the request
  ros::Time now;                    // zero: no clock
};

// Returns where the object is in the link's frame, at the newest stamp at which both are known.
// Throws std::invalid_argument, naming the object, if the radius is not 0, if a pose is not known,
// or if that stamp is more than max_mesh_age_s old.
std::shared_ptr<const RigidGrip> findGrip(const GripQuestion& question,
                                          const MonitorParameters& parameters,
                                          const TransformLookup& lookup);

}  // namespace deformable_contact_monitor
