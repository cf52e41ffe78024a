// Makes scenes from mesh files. bag_frames.cpp makes those from bags, in a build with ROS.
//
// The scene keeps its bodies from frame to frame, so that a detector starts warm as in the node.
#include "tools/measure_trade/frame_source.h"

#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {
namespace {

constexpr BodyId kDeforming = 0;

// Keeps all states in memory, and sets the deforming body to each in turn.
class MeshFrames : public FrameSource {
 public:
  MeshFrames(const MeshFrameFiles& files, const std::function<void(const std::string&)>& progress) {
    for (const std::string& file : files.states) {
      progress("reading " + file);
      MeshFileReport report;
      TriangleMesh mesh = readMeshFile(file, &report);
      // The triangles of polygons are those of the first state with these faces.
      if (report.fans == fans_) mesh.triangles = states_.back().triangles;
      fans_ = std::move(report.fans);
      addState(file, std::move(mesh), files.split);
    }
    addBody(files.states.front(), states_.front());
    scene_.setPairEnabled(kDeforming, kDeforming, files.self);
    if (!files.against.empty()) pair_classes_.push_back("robot_deformable");
    if (files.self) pair_classes_.push_back("deformable_self");
    for (const std::string& file : files.against) {
      progress("reading " + file);
      scene_.setPairEnabled(kDeforming, addBody(file, readMeshFile(file)), true);
    }
  }

  // Setting only the vertices keeps what the detector knows of unchanged triangles.
  bool next() override {
    if (next_ == states_.size()) return false;
    const TriangleMesh& state = states_[next_];
    const TriangleMesh& now = scene_.body(kDeforming).mesh;
    if (state.triangles == now.triangles && state.vertices.size() == now.vertices.size()) {
      scene_.setVertices(kDeforming, state.vertices.data(), state.vertexCount());
    } else {
      scene_.setMesh(kDeforming, state);
    }
    ++next_;
    return true;
  }
  bool isDeformable(BodyId body) const override { return body == kDeforming; }
  std::string label() const override { return next_ == 0 ? "" : labels_[next_ - 1]; }
  std::vector<std::string> pairClasses() const override { return pair_classes_; }

 private:
  // Adds a state, and before it the frames in between if the path is to be split.
  void addState(const std::string& file, TriangleMesh mesh, int split) {
    if (!states_.empty() && states_.back().triangles == mesh.triangles &&
        states_.back().vertices.size() == mesh.vertices.size()) {
      const std::string begin = labels_.back() + " + ";
      const TriangleMesh from = states_.back();
      for (int part = 1; part < split; ++part) {
        TriangleMesh between = from;
        for (std::size_t i = 0; i < from.vertices.size(); ++i) {
          const double a = from.vertices[i], b = mesh.vertices[i];
          between.vertices[i] = static_cast<float>(a + (b - a) * part / split);
        }
        states_.push_back(std::move(between));
        std::string label = begin;
        label.append(std::to_string(part)).append("/").append(std::to_string(split));
        labels_.push_back(std::move(label));
      }
    }
    states_.push_back(std::move(mesh));
    labels_.push_back(file);
  }

  // Adds a body that is named by its file.
  BodyId addBody(const std::string& file, TriangleMesh mesh) {
    const std::string name = std::filesystem::path(file).stem().string();
    const auto [other, is_new] = file_of_name_.emplace(name, file);
    if (!is_new) {
      throw std::invalid_argument(file + ": would be called " + name + ", as " + other->second +
                                  " is");
    }
    return scene_.addBody(name, std::move(mesh));
  }

  std::vector<std::string> labels_;  // of states_
  std::vector<std::string> pair_classes_;
  std::vector<TriangleMesh> states_;
  HostList<std::uint32_t> fans_;  // MeshFileReport::fans of the last state
  std::map<std::string, std::string> file_of_name_;
};

}  // namespace

std::unique_ptr<FrameSource> makeMeshFrames(
    const MeshFrameFiles& files, const std::function<void(const std::string&)>& progress) {
  return std::make_unique<MeshFrames>(files, progress);
}

#ifndef DCM_HAVE_BAGS
std::unique_ptr<FrameSource> makeBagFrames(
    const BagFiles& files, std::size_t /*most_frames*/,
    const std::function<void(const std::string&)>& /*progress*/,
    const std::function<void(const std::string&)>& /*warn*/) {
  throw std::runtime_error(files.bags.front() +
                           ": this build reads no bags: it was made without ROS");
}
#endif

}  // namespace deformable_contact_monitor
