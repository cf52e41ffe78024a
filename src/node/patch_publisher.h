// Publishes the patches of a cycle's contacts.
#pragma once

#include <ros/node_handle.h>

#include <vector>

#include "core/analysis/contact_patches.h"
#include "core/analysis/patch_tracker.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// One thread at a time.
class PatchPublisher {
 public:
  explicit PatchPublisher(ros::NodeHandle private_node);

  // Whether somebody listens: then the next cycle's contacts need geometry.
  bool isAskedFor() const { return publisher_.getNumSubscribers() > 0; }

  // ~contact_patches while somebody listens, also without a patch. Not where no detection ran, nor
  // where its contacts have no geometry, because it was asked for too late: that would look like no
  // contact. With a tolerance, none of pairs of bodies whose contacts are not all listed.
  void publish(const CycleReport& report);

  // Of the last report; null where none were made of it.
  const std::vector<Patch>* newest() const { return is_made_ ? &patches_ : nullptr; }

  // Ids are given anew.
  void forget() { tracker_.forget(); }

 private:
  const ros::Publisher publisher_;
  PatchFinder finder_;
  PatchTracker tracker_;
  std::vector<Patch> patches_;
  bool is_made_ = false;
};

}  // namespace deformable_contact_monitor
