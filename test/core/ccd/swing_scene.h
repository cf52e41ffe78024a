// A finger that swings through a cloth, and what belongs to a pair of bodies.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/substeps.h"
#include "pair_sets.h"
#include "scenes.h"
#include "test/core/ccd/swept_suite.h"

namespace deformable_contact_monitor {

inline RigidTransform turnedAboutZ(double angle, double z = 0) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {{c, -s, 0, s, c, 0, 0, 0, 1}, {0, 0, z}};
}

inline RigidTransform movedBy(double x, double y, double z) {
  return {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {x, y, z}};
}

// A finger of two triangles, 5 cm high, 0.8 m from the axis that it turns about.
inline TriangleMesh finger() {
  return meshOf({{{{0.8F, 0, 0}, {0.85F, 0, 0}, {0.8F, 0, 0.05F}}},
                 {{{0.85F, 0, 0}, {0.85F, 0, 0.05F}, {0.8F, 0, 0.05F}}}});
}

// The finger swings through a cloth that hangs across its way and moves a little; a box beside it
// slides. Pairs: finger and cloth, box and cloth, cloth and itself.
struct Swing {
  Scene scene;
  BodyId link, cloth, box;
  std::vector<BodyPath> paths;

  Swing() {
    link = scene.addBody("finger", finger());
    TriangleMesh sheet = clothGrid(12, 0.6F, 0, 0.004F);
    for (std::size_t i = 0; i < sheet.vertices.size(); i += 3) {  // into x z, at y = 4 cm
      const Vec3f v = sheet.vertex(i / 3);
      sheet.vertices[i] = v.x + 0.5F;
      sheet.vertices[i + 1] = v.z + 0.04F;
      sheet.vertices[i + 2] = v.y - 0.3F;
    }
    std::vector<float> earlier = sheet.vertices;
    for (std::size_t i = 1; i < earlier.size(); i += 3) earlier[i] -= 0.003F;
    cloth = scene.addBody("cloth", sheet);
    scene.setEarlier(cloth, RigidTransform(), earlier);
    box = scene.addBody("box", meshOf({{{{0.6F, 0, 0}, {0.65F, 0, 0}, {0.6F, 0, 0.1F}}}}));
    scene.setPose(box, movedBy(0, 0.05, 0));
    scene.setEarlier(box, RigidTransform());
    scene.setPose(link, turnedAboutZ(0.1));
    scene.setEarlier(link, RigidTransform());
    paths = {{{0, RigidTransform()}, {1, turnedAboutZ(0.1)}}, {}, {}};
    scene.setPairEnabled(link, cloth, true);
    scene.setPairEnabled(box, cloth, true);
    scene.setPairEnabled(cloth, cloth, true);
  }
};

inline Options timed() {
  Options options;
  options.motion = Motion::kSwept;
  options.first_times = true;
  return options;
}

class SubSteps : public DetectorSuite {
 protected:
  std::unique_ptr<Detector> brute_ = makeBruteForceDetector();
  SubStepDetector steps_{*detector_};
};

inline ::testing::AssertionResult sameTimes(const DetectionResult& expected,
                                            const DetectionResult& actual) {
  if (expected.first_times.size() != actual.first_times.size()) {
    return ::testing::AssertionFailure()
           << expected.first_times.size() << " and " << actual.first_times.size() << " times";
  }
  for (std::size_t i = 0; i < expected.first_times.size(); ++i) {
    if (expected.first_times[i].low != actual.first_times[i].low ||
        expected.first_times[i].high != actual.first_times[i].high) {
      return ::testing::AssertionFailure() << "times of " << expected.contacts[i] << " differ";
    }
  }
  return ::testing::AssertionSuccess();
}

// Those of a pair of bodies, and what belongs to them.
inline DetectionResult pairOf(const DetectionResult& all, BodyId a, BodyId b) {
  DetectionResult some;
  for (std::size_t i = 0; i < all.contacts.size(); ++i) {
    if (all.contacts[i].body_a != a || all.contacts[i].body_b != b) continue;
    some.contacts.push_back(all.contacts[i]);
    some.first_times.push_back(all.first_times[i]);
    if (!all.within_pad.empty()) some.within_pad.push_back(all.within_pad[i]);
  }
  return some;
}

}  // namespace deformable_contact_monitor
