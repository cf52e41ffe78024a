// Tests of the marker that is chosen from an array.
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "adapter_checks.h"
#include "monitor/input/mesh_adapters.h"

namespace deformable_contact_monitor {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

const MarkerName kName{"cloth", 2};

Marker deleting(std::int32_t action, std::int32_t id) {
  Marker marker;
  marker.ns = "cloth";
  marker.id = id;
  marker.action = action;
  return marker;
}

TEST(MarkerArrayAdapter, TheMarkerOfTheNameIsAsIfItHadATopicOfItsOwn) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    MarkerArray array = asMarkerArray(randomMesh(&random));
    Marker& chosen = array.markers[2];
    chosen.scale.x = 2;
    chosen.pose.position.y = 0.25;
    MarkerArrayAdapter adapter(kName);
    MarkerAdapter alone;
    for (int repeated = 0; repeated < 2; ++repeated) {
      const IncomingMesh found = adapter.adapt(array, kReceived);
      const IncomingMesh expected = alone.adapt(chosen, kReceived);
      EXPECT_EQ(bitsOf(found.message->vertices), bitsOf(expected.message->vertices));
      EXPECT_EQ(found.message->triangles, expected.message->triangles);
      EXPECT_EQ(found.message->topology_id, expected.message->topology_id);
      EXPECT_EQ(found.message->header, expected.message->header);
      EXPECT_FALSE(found.stamped_on_receipt);
    }
  }
}

TEST(MarkerArrayAdapter, NamespaceAndIdBothCount) {
  MarkerArray array = asMarkerArray(square());
  array.markers[0].ns = "rope";
  array.markers[0].id = 2;
  EXPECT_EQ(refusalOf(MarkerArrayAdapter(kName), array), "");
  EXPECT_EQ(refusalOf(MarkerArrayAdapter({"rope", 2}), array),
            "the marker's type is 8, not TRIANGLE_LIST (11)");
  expectIn("no marker 'rope'/1, but 'rope'/2, 'cloth'/1, 'cloth'/2",
           refusalOf(MarkerArrayAdapter({"rope", 1}), array));
}

TEST(MarkerArrayAdapter, WithoutAStampItIsStampedOnReceipt) {
  MarkerArray array = asMarkerArray(square());
  array.markers[2].header.stamp = ros::Time();
  const IncomingMesh mesh = MarkerArrayAdapter(kName).adapt(array, kReceived);
  EXPECT_TRUE(mesh.stamped_on_receipt);
  EXPECT_EQ(mesh.message->header.stamp, kReceived);
  expectIn("/clock is silent", refusalOf(MarkerArrayAdapter(kName), array, ros::Time()));
}

// Many publishers send only the markers that changed.
TEST(MarkerArrayAdapter, AnArrayWithoutTheMarkerSaysNothingOnceItWasSeen) {
  MarkerArray array = asMarkerArray(square()), others = array;
  others.markers.pop_back();
  MarkerArrayAdapter adapter(kName);
  expectIn("the array has no marker 'cloth'/2, but 'cloth'/0, 'cloth'/1",
           refusalOf(adapter, others));
  expectIn("the array has no marker 'cloth'/2, but is empty", refusalOf(adapter, MarkerArray()));
  EXPECT_NE(adapter.adapt(array, kReceived).message, nullptr);
  EXPECT_EQ(adapter.adapt(others, kReceived).message, nullptr);
  EXPECT_EQ(adapter.adapt(MarkerArray(), kReceived).message, nullptr);
}

TEST(MarkerArrayAdapter, NamesAreCutAndCounted) {
  MarkerArray array;
  for (std::int32_t id = 0; id < 9; ++id) array.markers.push_back(deleting(Marker::ADD, id));
  array.markers[0].ns = std::string(100000, 'n');
  const std::string why = refusalOf(MarkerArrayAdapter({"", 7}), array);
  expectIn("'cloth'/3, ...", why);
  EXPECT_LT(why.size(), 200U);
}

TEST(MarkerArrayAdapter, TheLastActionOfAnArrayCounts) {
  for (const Marker& deletes : {deleting(Marker::DELETE, 2), deleting(Marker::DELETEALL, 0)}) {
    MarkerArrayAdapter adapter(kName);
    MarkerArray array = asMarkerArray(square());
    array.markers.insert(array.markers.begin(), deletes);
    EXPECT_FALSE(adapter.adapt(array, kReceived).is_deletion) << "it is drawn anew";
    array.markers.push_back(deletes);
    const IncomingMesh deleted = adapter.adapt(array, kReceived);
    EXPECT_TRUE(deleted.is_deletion);
    expectIn("deleted", deleted.problem);
    EXPECT_TRUE(deleted.message->vertices.empty());
    array.markers = {deletes};
    EXPECT_TRUE(adapter.adapt(array, kReceived).is_deletion);
    array.markers = {deleting(Marker::DELETE, 1)};
    EXPECT_EQ(adapter.adapt(array, kReceived).message, nullptr) << "that is another marker";
  }
}

TEST(MarkerArrayAdapter, ANewNumberOfPointsIsANewTopology) {
  MarkerArrayAdapter adapter(kName);
  Accepting input;
  TriangleMesh one = square();
  one.triangles.resize(3);
  const auto accept = [&](const TriangleMesh& mesh) {
    return input.accept(adapter.adapt(asMarkerArray(mesh), kReceived));
  };
  const auto first = accept(square());
  EXPECT_EQ(accept(square()), first);
  EXPECT_EQ(accept(one)->triangles, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(accept(square())->id, first->id);
}

}  // namespace
}  // namespace deformable_contact_monitor
