// A small report to be converted: one link, one link that nobody touches, one cloth.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// Two unit right triangles in the plane z = 0, and a third one at z = 1.
inline TriangleMesh threeTriangles() {
  return {{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1},
          {0, 1, 2, 1, 3, 2, 4, 5, 6}};
}

// Bodies 0 "arm/hand" and 1 "base" (links), 2 "cloth"; the hand is 5 m along x, its triangles'
// normals point to +z. Hand and cloth have three contacts, base and cloth none, base and hand are
// allowed. It is the cloth's cycle, and 0.25 s after its stamp.
struct SampleReport {
  SampleReport() {
    for (const char* name : {"arm/hand", "base", "cloth"}) scene.addBody(name, threeTriangles());
    RigidTransform pose;
    pose.translation[0] = 5;
    scene.setPose(0, pose);
    report.header.stamp = ros::Time(100, 500);
    report.header.frame_id = "base_link";
    report.cycle = 7;
    report.bodies = {{"arm/hand", BodyKind::kLink, ros::Time(100, 500), 0, ""},
                     {"base", BodyKind::kLink, ros::Time(100, 500), 0, ""},
                     {"cloth", BodyKind::kDeformable, ros::Time(100, 500), 9, ""}};
    report.bodies[2].triggered = true;
    report.pairs = {{0, 1, true}, {0, 2, false}, {1, 2, false}};
    result.contacts = {{0, 0, 2, 0}, {0, 0, 2, 1}, {0, 1, 2, 1}};
    result.guaranteed = true;
    result.counters.triangles = 9;
    result.detect_ms = 1;
    result.round_trip_ms = 2.5;
    report.scene = &scene;
    report.result = owned_result;
    report.backend = "cpu";
    report.now = report.header.stamp + ros::Duration(0.25);
  }
  SampleReport(const SampleReport&) = delete;
  SampleReport& operator=(const SampleReport&) = delete;

  // Gives the report a containment, which tests may change afterwards.
  Containment& addContainment() {
    const auto containment = std::make_shared<Containment>();
    report.containment = containment;
    return *containment;
  }

  Scene scene;
  const std::shared_ptr<DetectionResult> owned_result = std::make_shared<DetectionResult>();
  DetectionResult& result = *owned_result;  // the report's, to be changed by tests
  CycleReport report;
};

}  // namespace deformable_contact_monitor
