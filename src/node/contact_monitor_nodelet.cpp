// The monitor as a nodelet: meshes of publishers in the same process come without a copy. A crash
// takes the whole manager down.
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "node/contact_monitor.h"

namespace deformable_contact_monitor {

// Callbacks come through a queue of its own. Of a nodelet with one on the manager's queues, the
// manager's threads hold the last reference when it is unloaded: it would outlive that, with all
// its topics and services.
class ContactMonitorNodelet : public nodelet::Nodelet {
 public:
  ~ContactMonitorNodelet() override { spinner_.stop(); }

 private:
  void onInit() override {
    try {
      ros::NodeHandle node(getNodeHandle()), private_node(getPrivateNodeHandle());
      node.setCallbackQueue(&queue_);
      private_node.setCallbackQueue(&queue_);
      monitor_ = std::make_unique<ContactMonitor>(node, private_node);
      spinner_.start();
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what());
      throw;
    }
  }

  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_{1, &queue_};
  std::unique_ptr<ContactMonitor> monitor_;
};

}  // namespace deformable_contact_monitor

PLUGINLIB_EXPORT_CLASS(deformable_contact_monitor::ContactMonitorNodelet, nodelet::Nodelet)
