// Meshes of a publisher in the same process, as of another nodelet: they come without a copy.
#include <gtest/gtest.h>
#include <ros/ros.h>

#include <boost/make_shared.hpp>
#include <chrono>
#include <string>
#include <vector>

#include "monitor/input/mesh_subscription.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMaxBytes = 1000;

class SameProcess : public ::testing::Test {
 protected:
  SameProcess() {
    for (std::vector<IncomingMesh>* received : {&first_, &second_}) {
      ros::SubscribeOptions options =
          meshSubscription("/cloth", ObjectParameters(), kMaxBytes,
                           [received](const IncomingMesh& mesh) { received->push_back(mesh); });
      subscribers_.push_back(node_.subscribe(options));
    }
    spinUntil([this] { return publisher_.getNumSubscribers() > 0; });
  }

  void spinUntil(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!condition()) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      ros::spinOnce();
      ros::WallDuration(0.01).sleep();
    }
  }

  void publish(const DeformableMesh::ConstPtr& message) {
    first_.clear();
    second_.clear();
    publisher_.publish(message);
    spinUntil([this] { return !first_.empty() && !second_.empty(); });
  }

  ros::NodeHandle node_;
  ros::Publisher publisher_ = node_.advertise<DeformableMesh>("/cloth", 1);
  std::vector<ros::Subscriber> subscribers_;
  std::vector<IncomingMesh> first_, second_;
};

TEST_F(SameProcess, AMeshComesWithoutACopyToEachSubscriber) {
  auto message = boost::make_shared<DeformableMesh>();
  message->vertices.resize(9);
  publish(message);
  for (const IncomingMesh& received : {first_.at(0), second_.at(0)}) {
    EXPECT_EQ(received.message, message);
    EXPECT_EQ(received.problem, "");
  }
}

// Otherwise a mesh without triangles would not have those that its publisher sent before.
TEST_F(SameProcess, AllMeshesOfAPublisherHaveOneConnection) {
  publish(boost::make_shared<DeformableMesh>());
  const IncomingMesh before = first_.at(0);
  publish(boost::make_shared<DeformableMesh>());
  EXPECT_EQ(first_.at(0).connection, before.connection);
}

TEST_F(SameProcess, ALargeOneIsRefusedAndNotKept) {
  auto message = boost::make_shared<DeformableMesh>();
  message->header.stamp = ros::Time(50);
  message->vertices.resize(kMaxBytes);
  publish(message);
  for (const IncomingMesh& received : {first_.at(0), second_.at(0)}) {
    EXPECT_NE(received.message, message);
    EXPECT_EQ(received.message->header.stamp, ros::Time(50));
    EXPECT_NE(received.problem.find("max_mesh_mib"), std::string::npos) << received.problem;
  }
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "same_process_test");
  return RUN_ALL_TESTS();
}
