// Runs the monitor as a nodelet, that is, as a plug-in of a nodelet manager. Publishers in the same
// process pass meshes by pointer, so they arrive without a copy. A crash ends the whole manager.
#include <nodelet/nodelet.h>
#include <ros/callback_queue.h>
#include <ros/spinner.h>

#include <memory>
#include <pluginlib/class_list_macros.hpp>

#include "node/contact_monitor.h"

namespace deformable_contact_monitor {

// Uses a callback queue and a thread of its own. On the manager's queues, the manager's threads
// would hold the last reference when the nodelet is unloaded, and it would live on with all its
// topics and services.
class ContactMonitorNodelet : public nodelet::Nodelet {
 public:
  ~ContactMonitorNodelet() override { spinner_.stop(); }

 private:
  // Is called once, by a thread of the manager. An exception tells the manager that loading failed.
  void onInit() override {
    try {
      ros::NodeHandle node(getNodeHandle()), private_node(getPrivateNodeHandle());
      node.setCallbackQueue(&queue_);
      private_node.setCallbackQueue(&queue_);
      monitor_ = std::make_unique<ContactMonitor>(node, private_node);
      spinner_.start();
    } catch (const std::exception& error) {
      NODELET_FATAL_STREAM(error.what() << "\n  see config/docs/console.md#it-does-not-start");
      throw;
    }
  }

  ros::CallbackQueue queue_;
  ros::AsyncSpinner spinner_{1, &queue_};
  std::unique_ptr<ContactMonitor> monitor_;
};

}  // namespace deformable_contact_monitor

PLUGINLIB_EXPORT_CLASS(deformable_contact_monitor::ContactMonitorNodelet, nodelet::Nodelet)
