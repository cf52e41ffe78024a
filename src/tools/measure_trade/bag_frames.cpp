// The frames of recorded bags.
#include "tools/measure_trade/bag_frames.h"

#include <console_bridge/console.h>
#include <ros/time.h>

#include <stdexcept>
#include <utility>

#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_setup.h"
#include "tools/bags/stamp_text.h"

namespace deformable_contact_monitor {
namespace {

// What of a scene changes from cycle to cycle.
struct Frame {
  struct Surface {
    BodyId body = 0;
    std::vector<float> vertices;
    std::shared_ptr<const HostList<std::uint32_t>> triangles;
  };
  struct Pair {
    BodyId a = 0, b = 0;
    bool enabled = false;
  };

  std::string label;
  std::vector<RigidTransform> poses;  // of all bodies
  std::vector<Surface> surfaces;      // of the deforming ones
  std::vector<Pair> pairs;
};

class BagFrames : public FrameSource {
 public:
  explicit BagFrames(const PairClasses& classes) : pair_classes_(namesOf(classes)) {}

  void add(const CycleReport& cycle) {
    if (frames_.empty()) start(cycle);
    const Scene& scene = *cycle.scene;
    Frame frame;
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
  }
  bool isEmpty() const { return frames_.empty(); }

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
  void rewind() override { next_ = 0; }
  const Scene& scene() const override { return scene_; }
  bool isDeformable(BodyId body) const override { return deformable_.at(body); }
  std::vector<std::string> pairClasses() const override { return pair_classes_; }
  std::string label() const override { return next_ == 0 ? "" : frames_[next_ - 1].label; }

 private:
  void start(const CycleReport& cycle) {
    scene_ = *cycle.scene;
    for (const BodyStatus& body : cycle.bodies) {
      deformable_.push_back(body.kind == BodyKind::kDeformable);
    }
    triangles_.resize(deformable_.size());
    shown_.resize(deformable_.size());
  }

  std::shared_ptr<const HostList<std::uint32_t>> sharedTriangles(BodyId id,
                                                                 const TriangleMesh& mesh) {
    auto& known = triangles_[id];
    if (!known || *known != mesh.triangles) {
      known = std::make_shared<const HostList<std::uint32_t>>(mesh.triangles);
    }
    return known;
  }

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
  Scene scene_;
  std::vector<bool> deformable_;
  std::vector<Frame> frames_;
  std::vector<std::shared_ptr<const HostList<std::uint32_t>>> triangles_;  // newest, by body
  std::vector<std::shared_ptr<const HostList<std::uint32_t>>> shown_;      // in scene_, by body
  std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<FrameSource> makeBagFrames(const BagFiles& files,
                                           const std::function<void(const std::string&)>& progress,
                                           const std::function<void(const std::string&)>& warn) {
  const MonitorParameters configured = readBagParameters(files, warn);
  BagReader reader(files.bags, neededMessages(configured));
  ros::Time::init();
  console_bridge::noOutputHandler();  // tf2 would print a line for each bad transform
  progress("reading the bags");
  BagContents contents = scanBags(&reader, [](std::uint64_t) {});
  const BagSetup setup = setUpBags(files, configured, SceneObject(), &contents, warn);
  BagCycles cycles(setup.parameters, contents, setup.robot, nullptr);
  auto frames = std::make_unique<BagFrames>(setup.parameters.pair_classes);
  const std::string problem = cycles.run(&reader, [&](CycleReport* cycle) {
    frames->add(*cycle);
    progress("reading the bags, cycle " + std::to_string(cycle->cycle));
  });
  if (!problem.empty()) throw std::runtime_error("damaged: " + problem);
  if (frames->isEmpty()) throw std::runtime_error("the bags have no cycle to measure");
  return frames;
}

}  // namespace deformable_contact_monitor
