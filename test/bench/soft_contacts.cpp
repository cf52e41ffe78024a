// Prints what Bullet's contact list of a soft body says beside the exact contacts, step by step.
//
// Usage: soft_contacts [CSV]. Four scenes, each with three lengths of steps. A row of the table
// sums up a run; the file gets a row for each step.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/cpu_detector.h"
#include "core/scene.h"
#include "tools/simulation/soft_world.h"

namespace deformable_contact_monitor {
namespace {

using Position = std::function<Eigen::Vector3d(double time_s)>;

constexpr float kFar = 0.02F;  // distances of listed vertices are measured up to here [m]

// A link that moves without turning. Its mesh is convex, so Bullet's hull is the mesh itself.
struct MovedLink {
  std::string name;
  TriangleMesh mesh;
  Position at;
};

struct SoftCase {
  std::string name;
  SoftShapeOptions shape;
  std::vector<MovedLink> links;
  double seconds;
};

// What one step came to; sums of these are a run.
struct Counts {
  std::size_t touching = 0;  // triangles of the object that touch a link
  std::size_t missed = 0;    // of these: Bullet lists none of their vertices
  std::size_t listed = 0;    // vertices that Bullet lists
  std::size_t apart = 0;     // of these: outside the links, and no triangle around them touches one
  std::size_t between = 0;   // triangles that touch within the step, but not at its ends
  std::size_t unseen = 0;    // of these: Bullet lists none of their vertices
  std::size_t folds = 0;     // pairs of the object's own triangles that touch
  std::vector<float> gaps_m;  // of those that are apart: their distance from the nearest link

  void add(const Counts& o) {
    touching += o.touching;
    missed += o.missed;
    listed += o.listed;
    apart += o.apart;
    between += o.between;
    unseen += o.unseen;
    folds += o.folds;
    gaps_m.insert(gaps_m.end(), o.gaps_m.begin(), o.gaps_m.end());
  }
};

TriangleMesh boxMesh(const Eigen::Vector3d& half) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      const double side = (corner >> axis & 1) != 0 ? half[axis] : -half[axis];
      mesh.vertices.push_back(static_cast<float>(side));
    }
  }
  mesh.triangles = std::vector<std::uint32_t>{0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                                              2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

TriangleMesh ballMesh(double radius_m) {
  SoftShapeOptions o;
  o.object = "volume";
  o.vertices = 400;
  const SoftShape shape = softShape(o);
  TriangleMesh mesh;
  for (const Eigen::Vector3d& node : shape.nodes) {
    const Eigen::Vector3d p = radius_m * node.normalized();
    for (int i = 0; i < 3; ++i) mesh.vertices.push_back(static_cast<float>(p[i]));
  }
  mesh.triangles.assign(shape.triangles.begin(), shape.triangles.end());
  return mesh;
}

// Returns whether the point, in the frame of a convex mesh whose triangles are oriented outwards or
// not, is inside it.
bool isInside(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  const auto vertex = [&mesh](std::size_t i) {
    const Vec3f v = mesh.vertex(mesh.triangles[i]);
    return Eigen::Vector3d(v.x, v.y, v.z);
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = vertex(t);
    const Eigen::Vector3d normal = (vertex(t + 1) - a).cross(vertex(t + 2) - a);
    // The origin is inside every link of the scenes here.
    if (normal.dot(p - a) * normal.dot(-a) < 0) return false;
  }
  return true;
}

// Runs a scene in steps of one length, and compares after each.
class Comparison {
 public:
  Comparison(const SoftCase& scene, double step_s) : case_(scene), step_s_(step_s) {
    options_.step_s = step_s;
    world_ = std::make_unique<SoftWorld>(softShape(scene.shape), options_);
    for (const MovedLink& link : scene.links) world_->addLink(link.name, link.mesh);
  }

  // Returns the sums. Writes a line for each step unless `csv` is null.
  Counts run(std::FILE* csv) {
    Counts sum;
    const int steps = static_cast<int>(std::lround(case_.seconds / step_s_));
    for (int step = 0; step < steps; ++step) {
      const double time_s = step * step_s_;
      const Advance advance = world_->advance(step_s_, [&](const std::string& name) {
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        for (const MovedLink& link : case_.links) {
          if (link.name == name) pose.translate(link.at(time_s));
        }
        return std::optional(pose);
      });
      if (!advance.problem.empty()) std::fprintf(stderr, "%s\n", advance.problem.c_str());
      const Counts now = compare(time_s, step > 0);
      sum.add(now);
      if (csv == nullptr) continue;
      std::fprintf(csv, "%s,%.6f,%.6f,%zu,%zu,%zu,%zu,%zu,%zu\n", case_.name.c_str(), step_s_,
                   time_s, now.touching, now.missed, now.listed, now.apart, now.between,
                   now.unseen);
    }
    return sum;
  }

 private:
  static RigidTransform poseOf(const MovedLink& link, double time_s) {
    RigidTransform pose;
    const Eigen::Vector3d at = link.at(time_s);
    for (int i = 0; i < 3; ++i) pose.translation[i] = at[i];
    return pose;
  }

  // Returns for each triangle of the object whether it is in a contact with a link.
  std::vector<bool> inContact(const Scene& scene, Motion motion, std::size_t triangles) {
    Options options;
    options.motion = motion;
    std::vector<bool> result(triangles);
    for (const TrianglePair& pair : detector_->detect(scene, options).contacts) {
      result[pair.triangle_a] = true;
    }
    return result;
  }

  // Returns the scene at this time: the object, whose motion began where it was before, and links.
  Scene sceneAt(double time_s, const TriangleMesh& mesh, bool has_earlier) const {
    Scene scene;
    scene.addBody("object", mesh);
    if (has_earlier) scene.setEarlier(0, {}, before_.vertices);
    for (const MovedLink& link : case_.links) {
      const BodyId id = scene.addBody(link.name, link.mesh);
      scene.setPose(id, poseOf(link, time_s));
      if (has_earlier) scene.setEarlier(id, poseOf(link, time_s - step_s_));
      scene.setPairEnabled(0, id, true);
    }
    return scene;
  }

  Counts compare(double time_s, bool has_earlier) {
    const TriangleMesh mesh = world_->mesh();
    const Scene scene = sceneAt(time_s, mesh, has_earlier);
    const std::size_t triangles = mesh.triangleCount();
    const std::vector<bool> touching = inContact(scene, Motion::kInstant, triangles);
    std::vector<bool> listed(mesh.vertexCount()), in_touch(mesh.vertexCount());
    for (const SoftContact& contact : world_->contacts()) listed[contact.node] = true;
    const auto isListed = [&](std::size_t t) {
      return listed[mesh.triangles[3 * t]] || listed[mesh.triangles[3 * t + 1]] ||
             listed[mesh.triangles[3 * t + 2]];
    };
    Counts counts;
    for (std::size_t t = 0; t < triangles; ++t) {
      if (!touching[t]) continue;
      ++counts.touching;
      counts.missed += isListed(t) ? 0 : 1;
      for (std::size_t i = 0; i < 3; ++i) in_touch[mesh.triangles[3 * t + i]] = true;
    }
    if (has_earlier) {
      const std::vector<bool> swept = inContact(scene, Motion::kSwept, triangles);
      for (std::size_t t = 0; t < triangles; ++t) {
        if (!swept[t] || touching[t] || touching_before_[t]) continue;
        ++counts.between;
        counts.unseen += isListed(t) ? 0 : 1;
      }
    }
    Scene alone;
    alone.addBody("object", mesh);
    alone.setPairEnabled(0, 0, true);
    counts.folds = detector_->detect(alone).contacts.size();
    countApart(scene, mesh, listed, in_touch, &counts);
    before_ = mesh;
    touching_before_ = touching;
    return counts;
  }

  // Counts listed vertices that are apart from all links. Distances are exact to float32.
  void countApart(const Scene& scene, const TriangleMesh& mesh, const std::vector<bool>& listed,
                  const std::vector<bool>& in_touch, Counts* counts) {
    TriangleMesh points;
    for (std::size_t i = 0; i < listed.size(); ++i) {
      counts->listed += listed[i] ? 1 : 0;
      if (!listed[i] || in_touch[i] || isInLink(scene, mesh.vertex(i))) continue;
      const auto point = static_cast<std::uint32_t>(points.vertexCount());
      for (std::size_t axis = 0; axis < 3; ++axis) {
        points.vertices.push_back(mesh.vertices[3 * i + axis]);
        points.triangles.push_back(point);
      }
    }
    counts->apart += points.vertexCount();
    if (points.triangles.empty()) return;
    Scene apart;
    apart.addBody("points", points);
    apart.setMargin(0, kFar);
    for (BodyId id = 1; id < scene.bodyCount(); ++id) {
      apart.addBody(scene.body(id).name, scene.body(id).mesh);
      apart.setPose(id, scene.body(id).pose);
      apart.setPairEnabled(0, id, true);
    }
    std::vector<float> distance(points.vertexCount(), kFar);
    const DetectionResult& near = detector_->detect(apart);
    for (std::size_t i = 0; i < near.contacts.size(); ++i) {
      float& least = distance[near.contacts[i].triangle_a];
      least = std::min(least, near.separationM(i));
    }
    counts->gaps_m = distance;
  }

  static bool isInLink(const Scene& scene, const Vec3f& p) {
    for (BodyId id = 1; id < scene.bodyCount(); ++id) {
      const Body& body = scene.body(id);
      const Eigen::Vector3d at(p.x - body.pose.translation[0], p.y - body.pose.translation[1],
                               p.z - body.pose.translation[2]);
      if (isInside(body.mesh, at)) return true;
    }
    return false;
  }

  const SoftCase& case_;
  const double step_s_;
  SoftWorldOptions options_;
  std::unique_ptr<SoftWorld> world_;
  std::unique_ptr<Detector> detector_ = makeCpuDetector();
  TriangleMesh before_;
  std::vector<bool> touching_before_;
};

// A cloth that a ball lifts from below, one that falls onto a table in folds, one that a finger
// strokes, and a volume that a plate presses onto a table.
std::vector<SoftCase> cases() {
  const auto still = [](const Eigen::Vector3d& at) { return [at](double) { return at; }; };
  SoftShapeOptions cloth;
  cloth.vertices = 900;
  cloth.offset = {0.5, 0, 1};
  SoftCase ball{"cloth over a ball", cloth, {}, 6};
  ball.links.push_back({"ball", ballMesh(0.15), [](double t) {
                          return Eigen::Vector3d(0, 0, 0.7 + 0.15 * std::sin(2 * t));
                        }});
  SoftCase folds{"cloth falls in folds on a table", cloth, {}, 6};
  folds.shape.size_m = 0.8;
  folds.shape.offset = {0.4, 0, 0.4};
  folds.links.push_back({"table", boxMesh({1, 1, 0.1}), still({0, 0, -0.1})});
  SoftCase finger{"a thin finger strokes a hanging cloth", cloth, {}, 6};
  finger.links.push_back({"finger", boxMesh({0.01, 0.01, 0.08}), [](double t) {
                            return Eigen::Vector3d(0.5 + 0.25 * std::sin(3 * t), 0.1, 0.5);
                          }});
  SoftShapeOptions volume;
  volume.object = "volume";
  volume.pinned = "none";
  volume.size_m = 0.3;
  volume.offset = {0, 0, 0.152};
  SoftCase pressed{"a volume is pressed onto a table", volume, {}, 6};
  pressed.links.push_back({"table", boxMesh({1, 1, 0.1}), still({0, 0, -0.1})});
  pressed.links.push_back({"plate", boxMesh({0.1, 0.1, 0.02}), [](double t) {
                             return Eigen::Vector3d(0, 0, 0.28 + 0.08 * std::cos(2 * t));
                           }});
  return {ball, folds, finger, pressed};
}

double percent(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : 100.0 * static_cast<double>(part) / static_cast<double>(whole);
}

void printRow(const SoftCase& scene, int hz, Counts sum) {
  std::sort(sum.gaps_m.begin(), sum.gaps_m.end());
  const bool any = !sum.gaps_m.empty();
  std::printf("| %s | 1/%d | %zu | %.1f %% | %zu | %.1f %% ", scene.name.c_str(), hz, sum.touching,
              percent(sum.missed, sum.touching), sum.listed, percent(sum.apart, sum.listed));
  std::printf("| %.2f, %.2f | %zu | %.1f %% | %zu |\n",
              any ? 1e3 * sum.gaps_m[sum.gaps_m.size() / 2] : 0.0,
              any ? 1e3 * sum.gaps_m.back() : 0.0, sum.between, percent(sum.unseen, sum.between),
              sum.folds);
  std::fflush(stdout);
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  std::FILE* csv = argc > 1 ? std::fopen(argv[1], "w") : nullptr;
  if (argc > 2 || (argc > 1 && csv == nullptr)) {
    std::fprintf(stderr, "usage: soft_contacts [CSV]\n");
    return 2;
  }
  if (csv != nullptr) {
    std::fprintf(csv, "scene,step_s,time_s,touching,missed,listed,apart,between,unseen\n");
  }
  std::printf("Bullet %d.%d\n", btGetVersion() / 100, btGetVersion() % 100);
  std::printf("| scene | step [s] | touching triangles | not listed | listed vertices | apart ");
  std::printf("| median, largest gap [mm] | only within a step | not listed | own pairs |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const dcm::SoftCase& scene : dcm::cases()) {
    for (const int hz : {240, 60, 30}) {
      dcm::printRow(scene, hz, dcm::Comparison(scene, 1.0 / hz).run(csv));
    }
  }
  if (csv != nullptr) std::fclose(csv);
  return 0;
}
