// What one detection cycle hands to everything that is published from it.
#pragma once

#include <ros/time.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

enum class BodyKind : std::uint8_t { kLink = 0, kDeformable = 1 };

// How the monitor treats a pair of bodies. Pairs of classes that are off do not appear.
struct MonitoredPair {
  BodyId a = 0, b = 0;   // a <= b; a == b: self contact
  bool allowed = false;  // ALLOWED: not computed
};

struct BodyStatus {
  std::string name;
  BodyKind kind = BodyKind::kLink;
  ros::Time stamp;                // of the data used; zero: none
  std::uint32_t topology_id = 0;  // links: 0
  std::string unknown_because;    // empty: the body took part in this cycle
};

struct CycleReport {
  std_msgs::Header header;  // stamp T of the triggering mesh, frame_id = reference_frame
  std::uint64_t cycle = 0;
  std::vector<BodyStatus> bodies;  // indexed by BodyId: links in URDF order, then objects
  std::vector<MonitoredPair> pairs;
  // Of this cycle's bodies, in the scene frame; null when no detection ran (every pair UNKNOWN).
  const Scene* scene = nullptr;
  const DetectionResult* result = nullptr;
  Options options;
  std::string backend;
  double age_s = 0;  // now minus header.stamp when the report was made
};

}  // namespace deformable_contact_monitor
