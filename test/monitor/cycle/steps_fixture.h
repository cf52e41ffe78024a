// A detection loop with continuous collision detection, and the time intervals of its latest cycle
// as text.
#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "loop_fixture.h"
#include "reference/reference_detectors.h"

namespace deformable_contact_monitor {

inline std::shared_ptr<const RobotGeometry> robotOf(std::size_t links) {
  const auto robot = std::make_shared<RobotGeometry>();
  for (std::size_t i = 0; i < links; ++i) {
    robot->links.push_back({"link" + std::to_string(i),
                            "test",
                            {{0.25F, 0.25F, -1, 0.5F, 0.25F, -1, 0.25F, 0.5F, -1}, {0, 1, 2}},
                            ""});
  }
  return robot;
}

class StepsTest : public LoopTest {
 protected:
  StepsTest() {
    parameters_.motion = Motion::kSwept;
    // Detectors look at the real clock, which must not overtake this one.
    steady_time_ = std::chrono::steady_clock::now() + std::chrono::hours(1);
    make_detector_ = [] { return makeBruteForceDetector(); };
    said_.at_result = [this](const CycleReport& report) {
      names_.clear();
      for (const BodyStatus& body : report.bodies) names_.push_back(body.name);
      stamp_touches_ = report.result != nullptr && !report.result->contacts.empty();
      found_.clear();
      for (const SweepReport& sweep : report.sweeps) {
        if (sweep.result == nullptr) continue;
        for (const TrianglePair& pair : sweep.result->detection.contacts) {
          found_.push_back(names_[pair.body_a] + "/" + names_[pair.body_b]);
        }
      }
    };
  }

  void useRobot(std::size_t links) {
    const auto robot = robotOf(links);
    robot_source_ = [robot] { return robot; };
  }

  // Returns "50 of cloth: cloth/cable (cable: why it is skipped)" for each interval of the latest
  // cycle. The first number is the stamp of its beginning; 0: it has none.
  Lines steps() const {
    Lines lines;
    for (const SweepReport& sweep : said_.sweeps) {
      std::ostringstream line;
      line << sweep.from.toSec() << " of";
      for (const BodyId id : sweep.triggered) line << " " << names_[id];
      line << ":";
      for (const MonitoredPair& pair : sweep.pairs) {
        line << " " << names_[pair.a] << "/" << names_[pair.b];
      }
      for (BodyId id = 0; id < sweep.bodies.size(); ++id) {
        if (sweep.bodies[id].skipped.empty()) continue;
        line << " (" << names_[id] << ": " << sweep.bodies[id].skipped << ")";
      }
      lines.push_back(line.str());
    }
    return lines;
  }

  // Returns an object's height at the beginning of the only interval [m]; NaN: it has not changed.
  float earlierZ(std::size_t object) const {
    const StepBody& body = said_.sweeps.at(0).bodies[names_.size() - 2 + object];
    return body.mesh == nullptr ? std::nanf("") : body.mesh->vertices[2];
  }

  std::vector<std::string> names_;
  std::vector<std::string> found_;  // by the steps of the latest cycle: bodies of triangle pairs
  bool stamp_touches_ = false;      // some pair of it at its stamp
};

}  // namespace deformable_contact_monitor
