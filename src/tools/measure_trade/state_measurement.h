// Measures what a state of a robot costs by the number of states in a batch, beside other ways to
// decide it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "core/state_checker.h"

namespace deformable_contact_monitor {

// Bodies, and states of some of them, as StateBatch has them.
struct SceneStates {
  Scene scene;
  std::vector<BodyId> moved;
  std::vector<RigidTransform> poses;

  std::size_t count() const { return moved.empty() ? 0 : poses.size() / moved.size(); }
  // Returns a batch of `size` states from the state `first` on.
  StateBatch batch(std::size_t first, std::size_t size) const {
    return {moved, size, poses.data() + first * moved.size()};
  }
};

// What is measured of one way to decide states.
struct StateWay {
  std::string name;  // such as "cpu"
  std::unique_ptr<StateChecker> checker;
  bool nearest = false;  // ask for the nearest pair, too
  int threads = 1;
};

// A way with a size of its batches.
struct StateMeasurement {
  std::string way;
  bool nearest = false;
  int threads = 1;
  std::size_t batch = 0;          // states
  std::vector<double> us;         // time of a state [us], of each batch that was measured
  std::size_t states = 0;         // that were decided with the exact decision known
  std::size_t false_free = 0;     // touch, but this way says they do not
  std::size_t false_blocked = 0;  // do not touch, but this way says they do
};

// Measures a way with batches of this size, all states `passes` times; before that, once
// unmeasured. `touches` has whether each state touches. Times are those that the checker tells.
StateMeasurement measureStates(const SceneStates& states, const std::vector<bool>& touches,
                               std::size_t batch, int passes, StateWay* way);

// Returns whether each state touches, exactly.
std::vector<bool> exactTouches(const SceneStates& states);

// Returns all ways that are compared: our backends with both questions, FCL where it is there, and
// spheres. Throws std::runtime_error if a backend cannot be used.
std::vector<StateWay> stateWays(const std::vector<std::string>& backends, int threads);

// Returns the sizes of batches that are measured of so many states: 1, 10, 100, ...
std::vector<std::size_t> batchSizes(const StateWay& way, std::size_t states);

// Returns a table (CSV) of measurements, a row for each.
std::string statesCsv(const std::vector<StateMeasurement>& all);
// Returns the same with the command, the machine and the scene (JSON).
std::string statesJson(const std::string& command, const SceneStates& states,
                       const std::vector<bool>& touches, const std::vector<StateMeasurement>& all);
// Returns the same as a text for people.
std::string statesText(const std::vector<StateMeasurement>& all);

// What --states measures on. The mesh is in the frame of the robot's root link.
struct RobotStateFiles {
  std::string urdf;       // its joints are anywhere within their limits, each state by itself
  std::string mesh;       // body 0
  float margin_m = 0.1F;  // of the mesh
};

// Reads the files, and poses the links' collision meshes for `count` random states. Pairs of the
// mesh and links are enabled. Throws std::runtime_error or std::invalid_argument, one line, if a
// file cannot be read or no joint moves a link with a mesh, and always in a build without ROS.
SceneStates makeRobotStates(const RobotStateFiles& files, std::size_t count, std::uint32_t seed);

// Other ways to decide states of a robot, which ours are compared with.

// Returns a checker that uses FCL (the Flexible Collision Library), one thread: a bounding volume
// hierarchy of each body is built once and kept, and each pair of bodies is collided up to the
// first contact. It knows only whether a state touches, of bodies whose triangles are all finite
// and whose poses are rigid, without parts and radii. Its triangle test works in floating point.
// Null in a build without FCL.
std::unique_ptr<StateChecker> makeFclStateChecker();

// How large the spheres of a link are.
enum class SphereSize {
  kCovering,  // they cover the link
  kMean,      // as far from its centre as the sphere's vertices on average
};

// Returns a checker that takes spheres in place of the moved bodies, as planners usually do: so
// many for each, around groups of its triangles. Whether a sphere touches the other bodies'
// triangles is decided exactly, on one thread.
std::unique_ptr<StateChecker> makeSphereStateChecker(std::size_t spheres_per_body, SphereSize size);

}  // namespace deformable_contact_monitor
