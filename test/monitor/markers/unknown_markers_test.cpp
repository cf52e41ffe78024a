// Tests how objects that are UNKNOWN are drawn.
#include <gtest/gtest.h>

#include <cmath>

#include "marker_checks.h"
#include "monitor/markers/contact_markers.h"
#include "sample_report.h"

namespace deformable_contact_monitor {
namespace {

const Marker& markerOf(const MarkerArray& array, const std::string& ns) {
  for (const Marker& marker : array.markers) {
    if (marker.ns == ns && marker.action == Marker::ADD) return marker;
  }
  throw std::runtime_error("no marker " + ns);
}

TEST(UnknownMarkersTest, TheLastMeshStaysInGreyWithTheReasonOverIt) {
  SampleReport sample;
  MarkerOptions options;
  options.lifetime_s = 0.5;
  ContactMarkers markers(options);
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"all", "arm/hand/cloth", "cloth"}));

  sample.report.bodies[2].unknown_because = "no mesh";
  sample.report.result = nullptr;
  const MarkerArray array = markers.make(sample.report);
  expectValid(array);
  EXPECT_EQ(actions(array), (Actions{"-arm/hand/cloth", "cloth", "unknown"}));
  const Marker &surface = markerOf(array, "cloth"), &text = markerOf(array, "unknown");
  EXPECT_EQ(surface.points.size(), 9U) << "whole, with what was in contact";
  EXPECT_EQ(surface.color.r, surface.color.g);
  EXPECT_EQ(surface.color.g, surface.color.b);
  EXPECT_EQ(surface.lifetime, ros::Duration(kUnknownLifetimeS));
  EXPECT_EQ(text.lifetime, surface.lifetime);
  EXPECT_EQ(text.text, "cloth is UNKNOWN: no mesh");
  EXPECT_EQ(text.type, Marker::TEXT_VIEW_FACING);

  sample.report.bodies[2].unknown_because = "";
  sample.report.result = sample.owned_result;
  EXPECT_EQ(actions(markers.make(sample.report)), (Actions{"-unknown", "arm/hand/cloth", "cloth"}));
}

// All pairs of such an object are UNKNOWN, unless so many rejected triangles are tolerated.
TEST(UnknownMarkersTest, HiddenTrianglesAreAReason) {
  for (const double tolerated : {0.0, 0.5}) {
    SampleReport sample;
    sample.report.bodies[2].rejected = 1;
    MarkerOptions options;
    options.rules.tolerated_rejects = tolerated;
    const MarkerArray array = ContactMarkers(options).make(sample.report);
    const Marker& surface = markerOf(array, "cloth");
    EXPECT_EQ(surface.color.r == surface.color.b, tolerated == 0);
    if (tolerated > 0) {
      EXPECT_THROW(markerOf(array, "unknown"), std::runtime_error);
    } else {
      EXPECT_EQ(markerOf(array, "unknown").text,
                "cloth is UNKNOWN where it does not touch: 1 of 3 triangles have a vertex that is "
                "not finite (tolerated_rejects)");
    }
  }
}

// Returns the luminance of a color with components in [0, 1], as WCAG 2 defines it.
double luminance(double r, double g, double b) {
  const auto linear = [](double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

// WCAG 2 asks for a contrast of 3 of large texts. The grounds are rviz's own and that of demo.rviz.
TEST(UnknownMarkersTest, TheReasonIsLegibleOnDarkAndLightGround) {
  SampleReport sample;
  sample.report.bodies[2].unknown_because = "no mesh";
  sample.report.result = nullptr;
  ContactMarkers markers{MarkerOptions()};
  const MarkerArray array = markers.make(sample.report);
  const std_msgs::ColorRGBA& color = markerOf(array, "unknown").color;
  EXPECT_EQ(color.a, 1);
  const double text = luminance(color.r, color.g, color.b);
  const double dark = luminance(48 / 255.0, 48 / 255.0, 48 / 255.0);
  const double light = luminance(226 / 255.0, 229 / 255.0, 233 / 255.0);
  EXPECT_GE((text + 0.05) / (dark + 0.05), 3);
  EXPECT_GE((light + 0.05) / (text + 0.05), 3);
}

TEST(UnknownMarkersTest, WhereNoMeshEverCameNothingIsDrawn) {
  SampleReport sample;
  sample.scene.setMesh(2, TriangleMesh());
  sample.report.result = nullptr;
  sample.report.bodies[2].unknown_because = "no mesh yet";
  ContactMarkers markers{MarkerOptions()};
  EXPECT_EQ(actions(markers.make(sample.report)), Actions{"all"});
}

TEST(UnknownMarkersTest, OfOthersNothingChanges) {
  SampleReport sample;
  ContactMarkers markers{MarkerOptions()};
  markers.make(sample.report);
  sample.report.result = nullptr;
  sample.report.bodies[2].triggered = false;
  sample.report.bodies[2].unknown_because = "no mesh";
  EXPECT_EQ(actions(markers.make(sample.report)), Actions());
}

}  // namespace
}  // namespace deformable_contact_monitor
