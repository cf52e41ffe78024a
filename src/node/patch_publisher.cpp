// Publishes the patches of a cycle's contacts.
#include "node/patch_publisher.h"

#include <deformable_contact_monitor/ContactPatches.h>

#include <algorithm>
#include <boost/make_shared.hpp>

#include "monitor/messages/patch_messages.h"
#include "monitor/state/pair_distance.h"

namespace deformable_contact_monitor {

PatchPublisher::PatchPublisher(ros::NodeHandle private_node)
    : publisher_(private_node.advertise<ContactPatches>("contact_patches", 2)) {}

void PatchPublisher::publish(const CycleReport& report) {
  is_made_ = false;
  if (!isAskedFor() || report.result == nullptr) return;
  const DetectionResult& result = *report.result;
  if (result.geometry.size() != result.contacts.size()) return;
  patches_ = finder_.find(*report.scene, result);
  // Of what was seen on the way, some would look like all.
  const auto is_part = [&report](const Patch& patch) {
    const auto distance = distanceOf(report, {patch.body_a, patch.body_b, false}, 0);
    return distance && !distance->bounds->is_listed;
  };
  patches_.erase(std::remove_if(patches_.begin(), patches_.end(), is_part), patches_.end());
  tracker_.assign(*report.scene, &patches_);
  is_made_ = true;
  publisher_.publish(boost::make_shared<const ContactPatches>(toContactPatches(report, patches_)));
}

}  // namespace deformable_contact_monitor
