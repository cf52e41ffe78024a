// The monitor's parameters. config/contact_monitor.yaml holds each with unit, default and range.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cstddef>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/options.h"
#include "core/triangle_mesh.h"
#include "cuda/cuda_detector.h"
#include "cuda/detector_choice.h"
#include "monitor/rules/pair_table.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

enum class RobotSourceKind { kUrdf, kTopic };

// What an object's meshes come as.
enum class MeshType { kDeformableMesh, kShapeMesh, kMarker, kPointCloud };

struct ObjectParameters {
  std::string name;
  std::string topic;  // empty: objects/<name>/mesh in the private namespace
  float margin_m = 0;
  bool required = true;  // no data is an error in the diagnostics, else a warning
  MeshType type = MeshType::kDeformableMesh;
  std::string frame_id{};                       // shape meshes: of their vertices
  std::shared_ptr<const TriangleMesh> faces{};  // point clouds: the mesh whose vertices they are
  bool shares_margin = false;                   // it has none of its own: margin_m is every body's
};

constexpr char kSrdfAuto[] = "auto", kSrdfNone[] = "none";

struct MonitorParameters {
  std::string reference_frame = "base_link";

  RobotSourceKind robot_source = RobotSourceKind::kUrdf;
  std::string robot_description = "robot_description";  // name of the parameter with the URDF
  // Where the rules between links are: kSrdfAuto (the parameter of the description's name and
  // "_semantic", if it is there), kSrdfNone, or a file: a path or URL.
  std::string srdf = kSrdfAuto;
  RobotGeometryOptions geometry;
  bool strict_geometry = false;  // a link without usable geometry is a reason not to start
  float margin_m = 0;            // of links; a pair counts at the larger of its two margins
  std::map<std::string, double> link_margin_m;

  std::vector<ObjectParameters> objects;

  PairClasses pair_classes;
  AllowedContacts allowed_contacts;

  BackendChoice backend = BackendChoice::kAuto;
  CudaSettings cuda;
  Options detector;                  // of one moment
  Motion motion = Motion::kInstant;  // swept: of the time since the previous cycle, too
  double swept_tolerance_m = 1e-4;   // of links' ways; 0: straight lines
  bool containment = false;          // what is within a closed surface is a contact

  double max_rate_hz = 100;   // of an object's cycles; 0: every mesh
  double robot_rate_hz = 30;  // of the robot's own cycles (robot_self)
  double max_cycle_s = 1;     // a cycle that takes longer ends early, and says so
  double budget_ms = 0;       // from the arrival of a mesh to its states; 0: none
  double tf_timeout_s = 0.05;
  double max_mesh_age_s = 0.5;
  double tolerated_rejects = 0;  // share of a body's triangles
  std::size_t max_contacts = 0;  // 0: all

  int debounce_on_cycles = 1;
  int debounce_off_cycles = 2;
  double since_survives_s = 0.2;  // so much UNKNOWN, as states' `since` counts

  double marker_rate_hz = 10;
  double marker_lifetime_s = 0.5;
  std::size_t max_marker_triangles = 20000;

  double diagnostic_min_rate_hz = 5;

  // Of one mesh, and of all that are kept of one object.
  std::size_t max_mesh_bytes = std::size_t{512} << 20U;
};

// Whether less than the exact contacts is asked for.
bool tradesAccuracy(const MonitorParameters& parameters);

// Of the link of that name [m].
double linkMarginM(const MonitorParameters& parameters, const std::string& link);

// Lists every problem, one a line.
struct ParameterError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// `tree`: the private namespace as the parameter server hands it out (invalid: nothing is set).
// Names that nothing reads go to `warnings`. Throws ParameterError, which lists those, too.
MonitorParameters parseParameters(const XmlRpc::XmlRpcValue& tree,
                                  std::vector<std::string>* warnings);

}  // namespace deformable_contact_monitor
