// In which time an object can be played beside recorded frames.
#include "tools/bags/bag_contents.h"

#include <gtest/gtest.h>

namespace deformable_contact_monitor {
namespace {

BagContents::Span span(double first, double last) { return {ros::Time(first), ros::Time(last)}; }

TEST(BagContents, AnObjectIsPlayedWhileAllFramesAreThere) {
  BagContents contents;
  EXPECT_TRUE(contents.settled().isZero());
  EXPECT_TRUE(contents.ended().isZero());
  contents.moving["hand"] = span(100, 200);
  contents.moving["caster"] = span(101.5, 198.25);
  EXPECT_EQ(contents.settled(), ros::Time(101.5));
  EXPECT_EQ(contents.ended(), ros::Time(198.25));
}

TEST(BagContents, WhatComesLateOrStopsEarlyIsNotWaitedFor) {
  BagContents contents;
  contents.moving["hand"] = span(100, 200);
  contents.moving["late"] = span(130, 200);
  contents.moving["gone"] = span(100, 130);
  EXPECT_EQ(contents.settled(), ros::Time(100));
  EXPECT_EQ(contents.ended(), ros::Time(200));
}

TEST(BagContents, AFrameWithoutATimeIsNotWaitedFor) {
  BagContents contents;
  contents.moving["hand"] = span(100, 200);
  contents.moving["odd"] = {};
  EXPECT_EQ(contents.settled(), ros::Time(100));
  EXPECT_EQ(contents.ended(), ros::Time(200));
}

TEST(BagContents, ASpanIsOfStampsInAnyOrder) {
  BagContents::Span all;
  for (const double stamp : {5.0, 3.0, 9.0, 4.0}) all.add(ros::Time(stamp));
  EXPECT_EQ(all.first, ros::Time(3));
  EXPECT_EQ(all.last, ros::Time(9));
}

}  // namespace
}  // namespace deformable_contact_monitor
