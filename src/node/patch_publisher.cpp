// Publishes the patches of a cycle's contacts.
#include "node/patch_publisher.h"

#include <deformable_contact_monitor/ContactPatches.h>

#include <boost/make_shared.hpp>

#include "node/patch_messages.h"

namespace deformable_contact_monitor {

PatchPublisher::PatchPublisher(ros::NodeHandle private_node)
    : publisher_(private_node.advertise<ContactPatches>("contact_patches", 2)) {}

void PatchPublisher::publish(const CycleReport& report) {
  is_made_ = false;
  if (!isAskedFor() || report.result == nullptr) return;
  const DetectionResult& result = *report.result;
  if (result.geometry.size() != result.contacts.size()) return;
  patches_ = finder_.find(*report.scene, result);
  tracker_.assign(*report.scene, &patches_);
  is_made_ = true;
  publisher_.publish(boost::make_shared<const ContactPatches>(toContactPatches(report, patches_)));
}

}  // namespace deformable_contact_monitor
