// Vertices on a device, where no backend is that reads them: refused by name, and no more than
// that.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/cpu_detector.h"
#include "core/detector_pool.h"
#include "pair_sets.h"
#include "reference/reference_detectors.h"
#include "refusal.h"
#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

// Stands for an address on a device: nobody may read it.
const float* somewhere() { return reinterpret_cast<const float*>(std::uintptr_t{64}); }

class HostVerticesTest : public testing::Test {
 protected:
  HostVerticesTest() { scene_.setPairEnabled(0, 1, true); }

  void moveToDevice(BodyId id) {
    scene_.setDeviceVertices(id, somewhere(), scene_.body(id).mesh.vertexCount());
  }

  TriangleMesh cloth_ = clothGrid(4, 1, 0, 0.2F);
  Scene scene_ = pairScene(cloth_, clothGrid(4, 1, 0.05F, 0));
};

TEST_F(HostVerticesTest, ASceneKeepsThemUntilTheBodyHasOthers) {
  void* const stream = &cloth_;
  const auto before = scene_.body(0).vertices_revision;
  scene_.setDeviceVertices(0, somewhere(), cloth_.vertexCount(), stream);
  ASSERT_TRUE(scene_.body(0).device_vertices);
  EXPECT_EQ(scene_.body(0).device_vertices->xyz, somewhere());
  EXPECT_EQ(scene_.body(0).device_vertices->stream, stream);
  const auto first = scene_.body(0).vertices_revision;
  EXPECT_NE(first, before);
  scene_.setDeviceVertices(0, somewhere(), cloth_.vertexCount(), stream);
  EXPECT_NE(scene_.body(0).vertices_revision, first) << "the same place, written to again";
  EXPECT_FALSE(scene_.body(1).device_vertices);

  scene_.setVertices(0, cloth_.vertices.data(), cloth_.vertexCount());
  EXPECT_FALSE(scene_.body(0).device_vertices);
  moveToDevice(0);
  scene_.setMesh(0, cloth_);
  EXPECT_FALSE(scene_.body(0).device_vertices);
}

TEST_F(HostVerticesTest, ASceneRefusesWhatCannotBeThem) {
  EXPECT_EQ(refusal([&] { scene_.setDeviceVertices(1, somewhere(), 24); }),
            "b: 24 vertices, but its triangles are of a mesh with 25");
  EXPECT_EQ(refusal([&] { scene_.setDeviceVertices(1, nullptr, 25); }),
            "b: the pointer to its 25 vertices is null");
  EXPECT_EQ(refusal([&] { scene_.setVertices(1, nullptr, 25); }),
            "b: the pointer to its 25 vertices is null");
  EXPECT_NE(refusal([&] { scene_.setDeviceVertices(2, somewhere(), 25); }), "");
  EXPECT_FALSE(scene_.body(1).device_vertices);
  const BodyId empty = scene_.addBody("empty", {});
  scene_.setDeviceVertices(empty, nullptr, 0);
  EXPECT_FALSE(scene_.body(empty).device_vertices) << "nothing to read";
}

struct Named {
  const char* name;
  std::unique_ptr<Detector> detector;
};

TEST_F(HostVerticesTest, BackendsThatCannotReadThemSaySo) {
  std::vector<Named> all;
  all.push_back({"cpu", makeCpuDetector()});
  all.push_back({"brute_force", makeBruteForceDetector()});
#ifdef DCM_HAVE_FCL
  all.push_back({"fcl", makeFclDetector()});
#endif
  for (const Named& it : all) {
    scene_.setMesh(1, clothGrid(4, 1, 0.05F, 0));
    const auto expected = it.detector->detect(scene_).contacts;
    EXPECT_FALSE(expected.empty()) << it.name;
    moveToDevice(1);
    EXPECT_EQ(refusal([&] { it.detector->detect(scene_); }),
              std::string("b: its vertices are on a device, which backend \"") + it.name +
                  "\" cannot read");
    scene_.setPairEnabled(0, 1, false);
    EXPECT_TRUE(it.detector->detect(scene_).contacts.empty()) << it.name << ": takes no part";
    scene_.setPairEnabled(0, 1, true);
    scene_.setMesh(1, clothGrid(4, 1, 0.05F, 0));
    EXPECT_TRUE(samePairs(expected, it.detector->detect(scene_).contacts)) << it.name;
  }
}

// A rejected call is not a failure of the backend: the backend stays in use.
TEST_F(HostVerticesTest, AFallbackIsNotToldOfARefusal) {
  int told = 0;
  PoolSettings settings;
  settings.device = [] { return makeCpuDetector(); };
  settings.cpu = makeBruteForceDetector;
  settings.changed = [&told](const BackendState&) { ++told; };
  const auto detector = makeDetectorPool(settings);
  moveToDevice(0);
  EXPECT_NE(refusal([&] { detector->detect(scene_); }).find("\"cpu\""), std::string::npos);
  EXPECT_EQ(detector->backend(), "cpu");
  EXPECT_EQ(told, 0);
}

}  // namespace
}  // namespace deformable_contact_monitor
