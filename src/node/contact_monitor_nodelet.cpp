// The monitor as a nodelet: meshes of publishers in the same process come without a copy. A crash
// takes the whole manager down.
#include <nodelet/nodelet.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "node/contact_monitor.h"

namespace deformable_contact_monitor {

class ContactMonitorNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      monitor_ = std::make_unique<ContactMonitor>(getNodeHandle(), getPrivateNodeHandle());
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  std::unique_ptr<ContactMonitor> monitor_;
};

}  // namespace deformable_contact_monitor

PLUGINLIB_EXPORT_CLASS(deformable_contact_monitor::ContactMonitorNodelet, nodelet::Nodelet)
