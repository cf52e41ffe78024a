// Watches whether an object's meshes come, and whether each of them has a cycle.
#pragma once

#include <diagnostic_updater/DiagnosticStatusWrapper.h>
#include <ros/time.h>

#include <cstdint>
#include <string>

#include "core/steady_time.h"
#include "monitor/input/mesh_input.h"

namespace deformable_contact_monitor {

// Tells what is known of an object's meshes at the time of a description.
struct MeshSituation {
  MeshCounters meshes;
  std::string rivals;         // of several publishers whose meshes differ; empty: there are none
  ros::Time ros_time;         // zero: no clock
  bool is_simulated = false;  // ROS time comes from /clock
  bool is_enabled = true;     // a disabled monitor drops every mesh, which is no fault
  double max_rate_hz = 0;     // most cycles per second; 0: no limit
};

// The status `mesh:<object>`. Reads no clock and is not safe for use by several threads.
class MeshWatch {
 public:
  // `required`: no mesh is an error, and not only a warning. Meshes at less than `min_rate_hz` are
  // a warning, and so are meshes that are farther apart than `max_age_s` [s].
  MeshWatch(bool required, double max_age_s, double min_rate_hz, SteadyTime now);

  // Takes what is anomalous about the newest mesh; empty: nothing.
  void setAnomaly(const std::string& anomaly) { anomaly_ = anomaly; }
  const std::string& anomaly() const { return anomaly_; }

  // Describes the meshes since the last description. Of several problems the most serious one is
  // the summary. Rates are by ROS time, and where that is simulated over a second of it, but no
  // longer than 5 s of real time. Warns if meshes were dropped beyond what max_rate_hz asks for.
  void describe(diagnostic_updater::DiagnosticStatusWrapper& status, const MeshSituation& situation,
                SteadyTime now);

  // Returns the time [s] that a cycle may take on average before meshes are dropped; 0: unknown.
  double periodS() const { return period_s_; }

 private:
  void measure(const MeshSituation& situation, SteadyTime now);

  const bool required_;
  const double max_age_s_, min_rate_hz_;
  std::string anomaly_;
  std::uint64_t received_ = 0, dropped_ = 0;  // when the last measurement ended
  SteadyTime when_;
  ros::Time ros_when_;
  bool is_measured_ = false;
  double rate_hz_ = 0, period_s_ = 0;
  std::string drops_;  // says that meshes were dropped; empty: none, or as asked for
};

}  // namespace deformable_contact_monitor
