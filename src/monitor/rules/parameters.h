// Declares the monitor's parameters and reads them from the ROS parameter server's tree.
//
// config/contact_monitor.yaml documents every parameter: its meaning, unit, range and default. The
// comments here only say what differs between a parameter and its field.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/backend_choice.h"
#include "core/options.h"
#include "monitor/rules/contact_rules.h"
#include "monitor/rules/part_parameters.h"
#include "monitor/rules/rigid_parameters.h"
#include "monitor/rules/tetrahedra.h"
#include "robot/robot_geometry.h"

namespace deformable_contact_monitor {

// The source of the robot's link meshes: the URDF, or messages on a topic.
enum class RobotSourceKind { kUrdf, kTopic };

// The message types in which an object's meshes can arrive. A polyline is the type of four of them,
// which its key `message` tells apart, in this order.
enum class MeshType {
  kDeformableMesh,
  kShapeMesh,
  kMarker,
  kPointCloud,
  kMarkerArray,
  kTetrahedra,
  kPolygonMesh,
  kPoints,
  kPolyline,  // the points of a cloud
  kPolylinePoses,
  kPolylinePath,
  kPolylineMarker
};
constexpr std::size_t kMeshTypes = 12;

// The namespace and the id of a marker.
using MarkerName = std::pair<std::string, std::int32_t>;

// How the pixels of a depth camera become triangles (monitor/input/depth_surface.h).
struct DepthRule {
  double max_depth_jump = 0.05;
  double min_seen = 0.01;  // least share of the pixels that have a depth
};

// One entry of the parameter `objects`.
struct ObjectParameters {
  std::string name;
  std::string topic;     // empty: objects/<name>/mesh in the private namespace
  float margin_m = 0;    // the object's own margin, or the general one
  bool required = true;  // false: missing data are a warning in the diagnostics, not an error
  MeshType type = MeshType::kDeformableMesh;
  std::string frame_id{};     // kShapeMesh only: frame of the vertices
  double stamp_offset_s = 0;  // what is added to the stamps of its messages
  // kPointCloud and kTetrahedra only: the triangles between the points. Null: the cloud is an image
  // of a depth camera.
  std::shared_ptr<const PointTriangles> faces{};
  DepthRule depth{};                    // kPointCloud without faces only
  MarkerName marker{};                  // kMarkerArray only: the marker that is the object
  bool shares_margin = false;           // has no margin of its own
  std::vector<PartParameters> parts{};  // its named parts
  float radius_m = 0;  // the object is all points at most this far from its triangles
};

// Returns the object as a body that has no mesh yet.
BodyStatus bodyOf(const ObjectParameters& object);
// Returns the parts with their names and margins; nobody knows their triangles yet.
BodyParts partsOf(const std::vector<PartParameters>& given);

constexpr char kSrdfAuto[] = "auto", kSrdfNone[] = "none";  // of RobotParameters::srdf

// One entry of the parameter `robots`, or the robot of `robot_description`.
struct RobotParameters {
  std::string description;       // name of the parameter with its URDF
  std::string link_prefix;       // frame_prefix: precedes its links' names, and so their frames
  std::string srdf = kSrdfAuto;  // kSrdfAuto, kSrdfNone, or a path or URL
};

// All parameters with their defaults. Names and units are those of the parameters.
struct MonitorParameters {
  std::string reference_frame = "base_link";

  RobotSourceKind robot_source = RobotSourceKind::kUrdf;
  std::string robot_description = "robot_description";
  std::string frame_prefix;
  std::string srdf = kSrdfAuto;         // kSrdfAuto, kSrdfNone, or a path or URL
  std::vector<RobotParameters> robots;  // empty: the robot of robot_description
  RobotGeometryOptions geometry;
  bool strict_geometry = false;
  float margin_m = 0;  // of bodies without a margin of their own
  std::map<std::string, double> link_margin_m;

  std::vector<ObjectParameters> objects;  // those of `objects` that messages deform
  std::vector<RigidParameters> rigids;    // those of type rigid

  PairClasses pair_classes;
  AllowedContacts allowed_contacts;

  BackendChoice backend = BackendChoice::kAuto;
  CudaSettings cuda;                 // device, devices, memory_limit_mib
  Options detector;                  // of the detection at the stamp, hence Motion::kInstant
  Motion motion = Motion::kInstant;  // kSwept adds the time since the previous cycle
  double swept_tolerance_m = 1e-4;
  bool containment = false;

  double max_rate_hz = 100;
  double robot_rate_hz = 30;
  double max_cycle_s = 1;
  double budget_ms = 0;
  double tf_timeout_s = 0.05;
  double max_mesh_age_s = 0.5;
  double tolerated_rejects = 0;
  std::size_t max_contacts = 0;

  int debounce_on_cycles = 1;
  int debounce_off_cycles = 2;
  double since_survives_s = 0.2;

  double marker_rate_hz = 10;
  double marker_lifetime_s = 0.5;
  std::size_t max_marker_triangles = 20000;

  double diagnostic_min_rate_hz = 5;

  std::size_t max_mesh_bytes = std::size_t{512} << 20U;  // max_mesh_mib

  std::vector<std::string> changed;  // what is not at its default, each as "name: value"

  // Returns `robots`, or the robot of robot_description, whose links' names get no prefix.
  std::vector<RobotParameters> allRobots() const;

  // Returns how long the transforms of a frame may fail to come [s] before no pose is taken from
  // between them. Where they always come so seldom, meshes are UNKNOWN most of the time anyway.
  double maxTransformGapS() const { return max_mesh_age_s + tf_timeout_s; }

  // Returns the TF frame of a link.
  std::string frameOf(const std::string& link) const { return frame_prefix + link; }
};

// Returns whether a tolerance or a budget is set, so that results may be less than exact.
bool tradesAccuracy(const MonitorParameters& parameters);

// Returns the margin [m] of the link with that name.
double linkMarginM(const MonitorParameters& parameters, const std::string& link);

// Lists every problem of a parameter tree, one per line.
struct ParameterError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Reads all parameters. `tree` is the private namespace as the parameter server returns it; an
// invalid value means that nothing is set. Adds one line to `warnings` for each name that is not
// known. Throws ParameterError, whose text contains these warnings too.
MonitorParameters parseParameters(const XmlRpc::XmlRpcValue& tree,
                                  std::vector<std::string>* warnings);

// Replaces the margins of links and objects that are texts such as 1e-3 by numbers, because
// programs that read margins from the parameter server (reader/monitor_margins.h) would take such a
// text for no margin. Returns the names of the parameters in `tree` that have changed. `tree` must
// be one that parseParameters() takes.
std::vector<std::string> writeMarginsAsNumbers(XmlRpc::XmlRpcValue* tree);

// Throws ParameterError if two objects have one topic. `topic_of` returns an object's absolute
// topic.
void requireOwnTopics(const std::vector<ObjectParameters>& objects,
                      const std::function<std::string(const ObjectParameters&)>& topic_of);

// The parameters that may change while the monitor runs (dynamic_reconfigure).
struct LiveParameters {
  double margin_m = 0;  // of bodies without a margin of their own
  bool near_pairs = false;
  double max_rate_hz = 100, robot_rate_hz = 30, marker_rate_hz = 10;
  PairClasses pair_classes;
  Predicates predicates = Predicates::kExact;
  double overlap = 1;
  int clusters = 0, iterations = 1, refresh_period = 1;
};

// Returns the values with which the monitor starts. Values stored as float32 become the shortest
// decimal number that is the same float32: 0.01 and not 0.00999999978, because they are written
// back to the parameter server.
LiveParameters startValues(const MonitorParameters& parameters);

// Returns the largest rates [Hz] of the cycles of `objects` objects, in their order, then of the
// robot's own cycles.
std::vector<double> maxRatesHz(const LiveParameters& live, std::size_t objects);

// Copies the detector's options among the live parameters to `options`.
void setOptions(const LiveParameters& live, Options* options);

}  // namespace deformable_contact_monitor
