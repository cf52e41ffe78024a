// What instant and swept motion find in a sequence of frames, at all of them and at some.
#include "tools/measure_trade/motion_steps.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

bool isSameMesh(const Body& a, const Body& b) {
  return a.topology_revision == b.topology_revision ||
         (a.mesh.vertices.size() == b.mesh.vertices.size() && a.mesh.triangles == b.mesh.triangles);
}

// The later frame's scene, with bodies coming from where they were in the earlier one. What has no
// step is off in it.
Scene sceneOfStep(const Scene& from, const Scene& to, std::vector<BodyPair>* bodies) {
  Scene scene = to;
  std::vector<bool> has_step;
  for (BodyId id = 0; id < to.bodyCount(); ++id) {
    const Body &before = from.body(id), &now = to.body(id);
    has_step.push_back(isSameMesh(before, now));
    if (!has_step.back()) continue;
    const bool stiff = before.vertices_revision == now.vertices_revision;
    scene.setEarlier(id, before.pose, stiff ? HostList<float>() : before.mesh.vertices);
  }
  for (const BodyPair& pair : to.enabledPairs()) {
    if (has_step[pair.first] && has_step[pair.second] &&
        from.pairEnabled(pair.first, pair.second)) {
      bodies->push_back(pair);
    } else {
      scene.setPairEnabled(pair.first, pair.second, false);
    }
  }
  return scene;
}

const DetectionResult& wholeResult(Detector* detector, const Scene& scene, const Options& options,
                                   const std::string& label) {
  const DetectionResult& result = detector->detect(scene, options);
  if (result.cut_off || result.left_out > 0) {
    throw std::runtime_error(
        label + ": not all contacts were found: " +
        (result.cut_off ? result.cut_off_because : "no memory for their list"));
  }
  return result;
}

// Steps between frames of one kind, by a detector of their own.
class Stepper {
 public:
  Stepper(const MakeDetector& make, const Options& options) : options_(options), detector_(make()) {
    options_.motion = Motion::kSwept;
    options_.first_times = true;
  }

  // The first frame begins no step.
  void take(std::size_t frame, const std::string& label, const Scene& scene) {
    if (taken_) {
      MotionStep step;
      step.from = frame_;
      step.to = frame;
      const Scene between = sceneOfStep(scene_, scene, &step.bodies);
      const DetectionResult& result = wholeResult(detector_.get(), between, options_, label);
      step.contacts = result.contacts;
      step.first = result.first_times;
      step.round_trip_ms = result.round_trip_ms;
      steps.push_back(std::move(step));
    }
    taken_ = true;
    frame_ = frame;
    scene_ = scene;
  }

  std::vector<MotionStep> steps;

 private:
  Options options_;
  std::unique_ptr<Detector> detector_;
  bool taken_ = false;
  std::size_t frame_ = 0;
  Scene scene_;
};

}  // namespace

std::vector<std::size_t> keptFrames(std::size_t frames, std::size_t every) {
  std::vector<std::size_t> kept;
  for (std::size_t frame = 0; frame < frames; frame += every) kept.push_back(frame);
  if (kept.back() + 1 != frames) kept.push_back(frames - 1);
  return kept;
}

MotionResults findMotions(FrameSource* frames, std::size_t every, const Options& options,
                          const MakeDetector& make, const SayProgress& progress) {
  MotionResults found;
  found.every = every;
  const std::unique_ptr<Detector> detector = make();
  Stepper all(make, options), kept(make, options);
  frames->rewind();
  while (frames->next()) {
    const std::size_t frame = found.labels.size();
    const std::string label = frames->label();
    const Scene& scene = frames->scene();
    progress("instant and swept contacts of " + label);
    const DetectionResult& result = wholeResult(detector.get(), scene, options, label);
    found.labels.push_back(label);
    found.instant.push_back(result.contacts);
    found.instant_ms.push_back(result.round_trip_ms);
    found.rejected += result.counters.rejected;
    all.take(frame, label, scene);
    if (frame > 0) {
      found.pairs_without_step += scene.enabledPairs().size() - all.steps.back().bodies.size();
    }
    if (frame % every == 0) kept.take(frame, label, scene);
  }
  const std::size_t count = found.labels.size();
  if (count <= every) {
    throw std::runtime_error("there are " + std::to_string(count) + " frames, and --every " +
                             std::to_string(every) + " needs more than that many");
  }
  if ((count - 1) % every != 0) kept.take(count - 1, found.labels.back(), frames->scene());
  found.steps = std::move(all.steps);
  found.kept_steps = std::move(kept.steps);
  return found;
}

}  // namespace deformable_contact_monitor
