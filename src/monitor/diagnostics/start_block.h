// The block of lines that the node shows once at its start: what it watches, how, and what is still
// missing. All functions are pure.
#pragma once

#include <string>
#include <vector>

#include "monitor/input/transform_buffer.h"
#include "monitor/rules/parameters.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// Holds the facts that only the node knows at its start.
struct StartFacts {
  const RobotGeometry* robot = nullptr;  // null: no link meshes have come yet
  std::vector<std::string> topics;       // of MonitorParameters::objects, resolved, in their order
  std::string backend;                   // that the detector runs on: "cpu" or "cuda"
  std::string backend_problem;           // why it is not CUDA; empty: nobody wanted CUDA, or it is
  std::vector<std::string> missing;      // a line each
};

// Returns the block, without a line break at its end. Each line is about one thing: the robot, an
// object, pairs, margins, the backend, what is not at its default, what is missing. The last line
// names the page that explains the block.
std::string describeStart(const MonitorParameters& parameters, const StartFacts& facts);

// Returns what the block says of each robot: a line break, then the line.
std::string describeRobots(const RobotGeometry& robot);

// Returns a line about the links that TF does not connect to reference_frame, and one about the
// rigid objects, each with the reason for the first of them. `robot` may be null.
std::vector<std::string> missingTransforms(const MonitorParameters& parameters,
                                           const RobotGeometry* robot,
                                           const TransformBuffer& transforms);

}  // namespace deformable_contact_monitor
