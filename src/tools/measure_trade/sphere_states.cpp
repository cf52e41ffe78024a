#include <algorithm>
#include <vector>

#include "tools/measure_trade/state_measurement.h"

namespace deformable_contact_monitor {
namespace {

struct Sphere {
  Vec3f centre;  // body frame
  float radius_m;
};

// Returns the middle of a triangle's corners.
Vec3d middleOf(const TriangleMesh& mesh, std::size_t triangle) {
  Vec3d sum;
  for (std::size_t k = 0; k < 3; ++k) {
    sum = sum + toDouble(mesh.vertex(mesh.triangles[3 * triangle + k])) * (1.0 / 3);
  }
  return sum;
}

std::size_t nearestOf(const std::vector<Vec3d>& centres, const Vec3d& point) {
  const auto nearer = [&point](const Vec3d& a, const Vec3d& b) {
    return dot(a - point, a - point) < dot(b - point, b - point);
  };
  return static_cast<std::size_t>(std::min_element(centres.begin(), centres.end(), nearer) -
                                  centres.begin());
}

// Returns centres of groups of the triangles, by k-means from centres that are far apart.
std::vector<Vec3d> centresOf(const std::vector<Vec3d>& middles, std::size_t count) {
  std::vector<Vec3d> centres{middles.front()};
  while (centres.size() < count) {
    const auto farther = [&centres](const Vec3d& a, const Vec3d& b) {
      const Vec3d to_a = a - centres[nearestOf(centres, a)],
                  to_b = b - centres[nearestOf(centres, b)];
      return dot(to_a, to_a) < dot(to_b, to_b);
    };
    centres.push_back(*std::max_element(middles.begin(), middles.end(), farther));
  }
  for (int round = 0; round < 20; ++round) {
    std::vector<Vec3d> sums(centres.size());
    std::vector<double> counts(centres.size());
    for (const Vec3d& middle : middles) {
      const std::size_t nearest = nearestOf(centres, middle);
      sums[nearest] = sums[nearest] + middle;
      ++counts[nearest];
    }
    for (std::size_t i = 0; i < centres.size(); ++i) {
      if (counts[i] > 0) centres[i] = sums[i] * (1 / counts[i]);
    }
  }
  return centres;
}

std::vector<Sphere> spheresOf(const TriangleMesh& mesh, std::size_t count, SphereSize size) {
  std::vector<Vec3d> middles;
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) middles.push_back(middleOf(mesh, t));
  if (middles.empty()) return {};
  const std::vector<Vec3d> centres = centresOf(middles, std::min(count, middles.size()));
  std::vector<double> most(centres.size()), sum(centres.size()), points(centres.size());
  for (std::size_t t = 0; t < middles.size(); ++t) {
    const std::size_t i = nearestOf(centres, middles[t]);
    for (std::size_t k = 0; k < 3; ++k) {
      const double away = length(toDouble(mesh.vertex(mesh.triangles[3 * t + k])) - centres[i]);
      most[i] = std::max(most[i], away);
      sum[i] += away;
      ++points[i];
    }
  }
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    if (points[i] == 0) continue;
    const double radius_m = size == SphereSize::kCovering ? most[i] : sum[i] / points[i];
    spheres.push_back({toFloat(centres[i]), static_cast<float>(radius_m)});
  }
  return spheres;
}

// Makes a scene with a body for each sphere, and asks our checker.
class SphereStateChecker : public StateChecker {
 public:
  SphereStateChecker(std::size_t spheres_per_body, SphereSize size)
      : spheres_per_body_(spheres_per_body), size_(size) {}
  std::string backend() const override {
    return size_ == SphereSize::kCovering ? "spheres_covering" : "spheres_mean";
  }
  void reset() override { checker_->reset(); }

  const StateResults& check(const Scene& scene, const StateBatch& batch,
                            const StateOptions& options) override {
    Scene spheres = scene;
    std::vector<RigidTransform> poses;
    StateBatch of_spheres;
    std::vector<std::size_t> place;  // of each sphere's body among the moved ones
    for (std::size_t i = 0; i < batch.moved.size(); ++i) {
      for (const Sphere& sphere :
           spheresOf(scene.body(batch.moved[i]).mesh, spheres_per_body_, size_)) {
        addSphere(scene, batch, batch.moved[i], sphere, &spheres);
        of_spheres.moved.push_back(static_cast<BodyId>(spheres.bodyCount() - 1));
        place.push_back(i);
      }
    }
    for (const BodyId id : batch.moved) {
      for (BodyId other = 0; other < scene.bodyCount(); ++other) {
        spheres.setPairEnabled(id, other, false);
      }
    }
    for (std::size_t state = 0; state < batch.count; ++state) {
      for (const std::size_t i : place) {
        poses.push_back(batch.poses[state * batch.moved.size() + i]);
      }
    }
    of_spheres.count = batch.count;
    of_spheres.poses = poses.data();
    StateOptions one_thread = options;
    one_thread.threads = 1;
    return checker_->check(spheres, of_spheres, one_thread);
  }

 private:
  static void addSphere(const Scene& scene, const StateBatch& batch, BodyId of,
                        const Sphere& sphere, Scene* spheres) {
    const Vec3f& c = sphere.centre;
    const BodyId id = spheres->addBody(scene.body(of).name, {{c.x, c.y, c.z}, {0, 0, 0}});
    spheres->setRadius(id, sphere.radius_m);
    for (BodyId other = 0; other < scene.bodyCount(); ++other) {
      const bool moves =
          std::find(batch.moved.begin(), batch.moved.end(), other) != batch.moved.end();
      if (!moves && scene.pairEnabled(of, other)) spheres->setPairEnabled(other, id, true);
    }
  }

  std::size_t spheres_per_body_;
  SphereSize size_;
  std::unique_ptr<StateChecker> checker_ = makeCpuStateChecker();
};

}  // namespace

std::unique_ptr<StateChecker> makeSphereStateChecker(std::size_t spheres_per_body,
                                                     SphereSize size) {
  return std::make_unique<SphereStateChecker>(spheres_per_body, size);
}

}  // namespace deformable_contact_monitor
