// Keeps the frames of recorded bags in memory.
//
// The cycles come from BagCycles, so the frames are those that evaluate_bag evaluates. A frame
// holds only what changes from cycle to cycle; next() writes it into one scene, as the node would.
#include <console_bridge/console.h>
#include <ros/time.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "monitor/diagnostics/robot_checks.h"
#include "monitor/time_difference.h"
#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_robots.h"
#include "tools/bags/bag_setup.h"
#include "tools/measure_trade/frame_source.h"

namespace deformable_contact_monitor {
namespace {

// Everything of a scene that changes from cycle to cycle.
struct Frame {
  // A deforming body's vertices [m], and its triangles, which frames share.
  struct Surface {
    BodyId body = 0;
    std::vector<float> vertices;
    std::shared_ptr<const HostList<std::uint32_t>> triangles;
  };
  // A monitored pair of bodies, which may be disabled in this frame.
  struct Pair {
    BodyId a = 0, b = 0;
    bool enabled = false;
  };

  std::string label;
  std::vector<RigidTransform> poses;  // of all bodies
  std::vector<bool> has_path;         // of all bodies, from the cycle before
  std::vector<Surface> surfaces;      // of the deforming ones
  std::vector<Pair> pairs;
};

// Plays the kept frames. Frames share the triangles of a body as long as these do not change,
// because they would need twice the memory of the vertices.
class BagFrames : public FrameSource {
 public:
  BagFrames(const PairClasses& classes, std::size_t most_frames, double max_age_s)
      : pair_classes_(namesOf(classes)), most_frames_(most_frames), max_age_s_(max_age_s) {}

  // Copies what the cycle's scene changes. Call it for each cycle, in order.
  void add(const CycleReport& cycle) {
    std::vector<bool> has_path = follow(cycle);
    if (cycles_++ % every_ != 0) return;
    if (frames_.empty()) start(cycle);
    const Scene& scene = *cycle.scene;
    Frame frame;
    frame.has_path = std::move(has_path);
    frame.label = stampText(cycle.header.stamp);
    for (BodyId id = 0; id < scene.bodyCount(); ++id) {
      const Body& body = scene.body(id);
      frame.poses.push_back(body.pose);
      if (deformable_[id]) {
        frame.surfaces.push_back({id, body.mesh.vertices, sharedTriangles(id, body.mesh)});
      }
    }
    for (const MonitoredPair& pair : cycle.pairs) {
      frame.pairs.push_back({pair.a, pair.b, scene.pairEnabled(pair.a, pair.b)});
    }
    frames_.push_back(std::move(frame));
    if (most_frames_ > 0 && frames_.size() > most_frames_) keepEverySecond();
  }
  // No body has a path to the next cycle.
  void forget() { last_.clear(); }
  bool isEmpty() const { return frames_.empty(); }

  // Returns which of the cycles are frames, in words; empty: all are.
  std::string sampleText() const {
    if (every_ == 1) return "";
    return std::to_string(frames_.size()) + " of " + std::to_string(cycles_) +
           " cycles are measured, one in " + std::to_string(every_) + " (--frames 0: all)";
  }

  bool next() override {
    if (next_ == frames_.size()) return false;
    const Frame& frame = frames_[next_++];
    for (BodyId id = 0; id < frame.poses.size(); ++id) scene_.setPose(id, frame.poses[id]);
    for (const Frame::Surface& surface : frame.surfaces) show(surface);
    for (const Frame::Pair& pair : frame.pairs) {
      scene_.setPairEnabled(pair.a, pair.b, pair.enabled);
    }
    return true;
  }
  bool isDeformable(BodyId body) const override { return deformable_.at(body); }
  bool hasPath(BodyId body) const override { return frames_[next_ - 1].has_path.at(body); }
  std::vector<std::string> pairClasses() const override { return pair_classes_; }
  std::string label() const override { return next_ == 0 ? "" : frames_[next_ - 1].label; }

 private:
  // Copies the first cycle's scene: later frames only change poses, vertices and pairs.
  void start(const CycleReport& cycle) {
    scene_ = *cycle.scene;
    for (const BodyStatus& body : cycle.bodies) {
      deformable_.push_back(body.kind == BodyKind::kDeformable);
    }
    triangles_.resize(deformable_.size());
    shown_.resize(deformable_.size());
  }

  // Returns which bodies were known in the cycle before, at most as long before as a mesh holds.
  std::vector<bool> follow(const CycleReport& cycle) {
    std::vector<bool> has_path;
    last_.resize(cycle.bodies.size());
    for (std::size_t i = 0; i < cycle.bodies.size(); ++i) {
      const BodyStatus& body = cycle.bodies[i];
      const ros::Time& stamp = body.stamp.isZero() ? cycle.header.stamp : body.stamp;
      const double since_s = secondsBetween(stamp, last_[i]);
      const bool is_known = body.unknown_because.empty();
      has_path.push_back(is_known && !last_[i].isZero() && since_s >= 0 && since_s <= max_age_s_);
      last_[i] = is_known ? stamp : ros::Time();
    }
    return has_path;
  }

  void keepEverySecond() {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < frames_.size(); i += 2) std::swap(frames_[kept++], frames_[i]);
    frames_.resize(kept);
    every_ *= 2;
  }

  // Returns the triangles of the previous frame if they are the same.
  std::shared_ptr<const HostList<std::uint32_t>> sharedTriangles(BodyId id,
                                                                 const TriangleMesh& mesh) {
    auto& known = triangles_[id];
    if (!known || *known != mesh.triangles) {
      known = std::make_shared<const HostList<std::uint32_t>>(mesh.triangles);
    }
    return known;
  }

  // Sets a deforming body's mesh. setVertices() keeps what the detector knows of the triangles.
  void show(const Frame::Surface& surface) {
    const std::size_t count = surface.vertices.size() / 3;
    if (shown_[surface.body] == surface.triangles &&
        scene_.body(surface.body).mesh.vertexCount() == count) {
      scene_.setVertices(surface.body, surface.vertices.data(), count);
    } else {
      scene_.setMesh(surface.body, {surface.vertices, *surface.triangles});
      shown_[surface.body] = surface.triangles;
    }
  }

  std::vector<std::string> pair_classes_;
  std::size_t most_frames_;  // 0: no limit
  double max_age_s_;
  std::vector<ros::Time> last_;         // stamps in the last cycle, by body; zero: UNKNOWN
  std::size_t cycles_ = 0, every_ = 1;  // of the cycles that came, one in every_ is a frame
  std::vector<bool> deformable_;
  std::vector<Frame> frames_;
  std::vector<std::shared_ptr<const HostList<std::uint32_t>>> triangles_;  // newest, by body
  std::vector<std::shared_ptr<const HostList<std::uint32_t>>> shown_;      // in scene_, by body
};

}  // namespace

std::unique_ptr<FrameSource> makeBagFrames(const BagFiles& files, std::size_t most_frames,
                                           const std::function<void(const std::string&)>& progress,
                                           const std::function<void(const std::string&)>& warn) {
  // The reader forks, so it is made before anything starts threads, which progress() may do.
  const MonitorParameters configured = readBagParameters(files, warn);
  BagReader reader(files.bags, neededMessages(configured, files));
  ros::Time::init();
  console_bridge::noOutputHandler();  // tf2 would print a line for each bad transform
  progress("reading the bags");
  BagContents contents = scanBags(&reader, files, configured, [](std::uint64_t) {});
  if (!contents.problem.empty()) throw std::runtime_error("damaged: " + contents.problem);
  const BagSetup setup = setUpBags(files, configured, SceneObject(), &contents, warn);
  BagCycles cycles(setup.parameters, contents, setup.robots, nullptr);
  auto frames = std::make_unique<BagFrames>(setup.parameters.pair_classes, most_frames,
                                            setup.parameters.max_mesh_age_s);
  bool has_changed = false;
  std::size_t count = 0, unknown = 0;
  const std::string problem = cycles.run(&reader, [&](CycleReport* cycle) {
    if (!cycles.forgets().empty()) frames->forget();
    // All frames are of one scene, whose links do not change. Without shapes nothing is looked for.
    if (isWithoutShapes(setup.robots[cycles.robot()].value)) return;
    if (cycles.robot() != firstWithShapes(setup.robots)) {
      if (!has_changed) {
        warn("the robot changes at " + stampText(cycle->header.stamp) +
             "; cycles with another than the first one are left out");
      }
      has_changed = true;
      return;
    }
    frames->add(*cycle);
    ++count;
    unknown += std::any_of(cycle->bodies.begin(), cycle->bodies.end(),
                           [](const BodyStatus& body) { return !body.unknown_because.empty(); });
    progress("reading the bags, cycle " + std::to_string(cycle->cycle));
  });
  if (!problem.empty()) throw std::runtime_error("damaged: " + problem);
  if (frames->isEmpty()) throw std::runtime_error("the bags have no cycle to measure");
  if (contents.damaged() > 0) {
    warn(std::to_string(contents.damaged()) + " messages are damaged, and left out");
  }
  if (unknown > 0) {
    warn("in " + std::to_string(unknown) + " of " + std::to_string(count) +
         " cycles a body is UNKNOWN, and nothing is looked for on it, so they take less time; "
         "evaluate_bag says why");
  }
  if (!frames->sampleText().empty()) warn(frames->sampleText());
  return frames;
}

}  // namespace deformable_contact_monitor
