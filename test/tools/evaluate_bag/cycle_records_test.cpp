// That what a detection found comes back from a record to the bit, and that no nonsense does.
#include "tools/evaluate_bag/cycle_records.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "scenes.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// Every number and text is another one, and no list has the length of another by chance.
class CycleRecords : public testing::Test {
 protected:
  CycleRecords() : scene_(pairScene(clothGrid(4, 1, 0, 0), clothGrid(4, 1, 0, 0))) {
    found_ = result(5);
    found_.separations_m = {0, 1e-9F, 0.1F, 1.F / 3, std::numeric_limits<float>::denorm_min()};
    found_.distances.resize(2);
    found_.distances[0].body_b = found_.distances[1].body_b = 1;
    found_.distances[0].low_m = 1.F / 3;
    found_.distances[1].high_m = 1e-9F;
    found_.distances[1].witness = {0, 3, 1, 4};
    found_.distances[1].point_a = {0.1F, 0.2F, 0.3F};
    found_.distances[1].point_b = {1e-30F, -1, 7};
    found_.distances[1].is_listed = true;
    found_.distances[1].contact_count = 5;
    containment_.parts = {{0, 1, 7, Vec3d()}, {1, 0, 3, Vec3d()}};
    containment_.cut_off_because = "stopped";
    step_.detection = result(3);
    step_.detection.first_times = {{0, 0}, {0.1F, 0.2F}, {1 - 0x1p-24F, 1}};
    step_.detection.within_pad = {0, 1, 0};
    step_.sub_steps = 9;
    step_.pad_m = 1.F / 7;
    step_.outlying = {1};
    cycle_ = report();
    cycle_.result = &found_;
    cycle_.containment = &containment_;
    cycle_.sweeps[0].result = &step_;
    cycle_.sweeps[0].compute_s = 1. / 3;
    cycle_.sweeps[0].bodies[1].rejected = 4;
    cycle_.sweeps[1].problem = "the device is gone";
    cycle_.sweeps[1].compute_s = 1e-7;
  }

  // Without results.
  CycleReport report() const {
    CycleReport cycle;
    cycle.scene = &scene_;
    cycle.bodies = {{"hand", BodyKind::kLink, ros::Time(1), 0, ""},
                    {"cloth", BodyKind::kDeformable, ros::Time(1), 0, "", true}};
    cycle.sweeps.resize(2);
    for (SweepReport& sweep : cycle.sweeps) sweep.bodies.resize(2);
    return cycle;
  }

  DetectionResult result(std::uint32_t contacts) {
    DetectionResult result;
    for (std::uint32_t i = 0; i < contacts; ++i) result.contacts.emplace_back(0, i, 1, i + 2);
    result.left_out = ++count_;
    result.cut_off = true;
    result.cut_off_because = "memory_limit_mib";
    result.guaranteed = true;
    result.counters.triangles = ++count_;
    result.counters.rejected = ++count_;
    result.counters.undecided = (std::uint64_t{1} << 53) + ++count_;
    result.stages_ms = {{"transform", 0.1}, {"narrow_phase", 1. / 3}};
    result.detect_ms = 0.7 + count_;
    result.round_trip_ms = 1e-300;
    return result;
  }

  static void expectSame(const DetectionResult& a, const DetectionResult& b) {
    EXPECT_EQ(a.contacts, b.contacts);
    EXPECT_EQ(a.separations_m, b.separations_m);
    EXPECT_EQ(a.within_pad, b.within_pad);
    ASSERT_EQ(a.first_times.size(), b.first_times.size());
    for (std::size_t i = 0; i < a.first_times.size(); ++i) {
      EXPECT_EQ(a.first_times[i].low, b.first_times[i].low);
      EXPECT_EQ(a.first_times[i].high, b.first_times[i].high);
    }
    ASSERT_EQ(a.distances.size(), b.distances.size());
    for (std::size_t i = 0; i < a.distances.size(); ++i) {
      const BodyDistance &x = a.distances[i], &y = b.distances[i];
      EXPECT_EQ(x.body_a, y.body_a);
      EXPECT_EQ(x.body_b, y.body_b);
      EXPECT_EQ(x.low_m, y.low_m);
      EXPECT_EQ(x.high_m, y.high_m);
      EXPECT_EQ(x.witness.triangle_a, y.witness.triangle_a);
      EXPECT_EQ(x.witness.triangle_b, y.witness.triangle_b);
      EXPECT_EQ(x.point_a, y.point_a);
      EXPECT_EQ(x.point_b, y.point_b);
      EXPECT_EQ(x.is_listed, y.is_listed);
      EXPECT_EQ(x.contact_count, y.contact_count);
    }
    EXPECT_EQ(a.left_out, b.left_out);
    EXPECT_EQ(a.cut_off, b.cut_off);
    EXPECT_EQ(a.cut_off_because, b.cut_off_because);
    EXPECT_EQ(a.guaranteed, b.guaranteed);
    EXPECT_EQ(a.counters.triangles, b.counters.triangles);
    EXPECT_EQ(a.counters.rejected, b.counters.rejected);
    EXPECT_EQ(a.counters.undecided, b.counters.undecided);
    EXPECT_EQ(a.stages_ms, b.stages_ms);
    EXPECT_EQ(a.detect_ms, b.detect_ms);
    EXPECT_EQ(a.round_trip_ms, b.round_trip_ms);
  }

  // As it comes from a file.
  Json record() const { return Json::parse(toRecord(cycle_).dump()); }

  const Scene scene_;
  std::uint64_t count_ = 0;
  DetectionResult found_;
  Containment containment_;
  StepResult step_;
  CycleReport cycle_;
};

TEST_F(CycleRecords, ComeBackToTheBit) {
  RecordedCycle recorded;
  CycleReport read = report();
  recorded.read(record(), &read);
  ASSERT_NE(read.result, nullptr);
  expectSame(*read.result, found_);
  ASSERT_NE(read.containment, nullptr);
  ASSERT_EQ(read.containment->parts.size(), 2U);
  EXPECT_EQ(read.containment->parts[1].inner, 1U);
  EXPECT_EQ(read.containment->parts[1].outer, 0U);
  EXPECT_EQ(read.containment->parts[1].triangle, 3U);
  EXPECT_EQ(read.containment->cut_off_because, "stopped");
  ASSERT_NE(read.sweeps[0].result, nullptr);
  expectSame(read.sweeps[0].result->detection, step_.detection);
  EXPECT_EQ(read.sweeps[0].result->sub_steps, 9);
  EXPECT_EQ(read.sweeps[0].result->pad_m, step_.pad_m);
  EXPECT_EQ(read.sweeps[0].result->outlying, step_.outlying);
  EXPECT_EQ(read.sweeps[0].compute_s, 1. / 3);
  EXPECT_EQ(read.sweeps[0].bodies[0].rejected, 0U);
  EXPECT_EQ(read.sweeps[0].bodies[1].rejected, 4U);
  EXPECT_EQ(read.sweeps[1].result, nullptr);
  EXPECT_EQ(read.sweeps[1].problem, "the device is gone");
}

TEST_F(CycleRecords, LeaveNothingOfTheCycleBefore) {
  RecordedCycle recorded;
  CycleReport read = report();
  recorded.read(record(), &read);
  found_ = DetectionResult();
  cycle_.containment = nullptr;
  cycle_.sweeps[0].result = nullptr;
  read = report();
  recorded.read(record(), &read);
  expectSame(*read.result, DetectionResult());
  EXPECT_EQ(read.containment, nullptr);
  EXPECT_EQ(read.sweeps[0].result, nullptr);
}

// Each key once left out, and each value once replaced.
TEST_F(CycleRecords, RefuseNonsense) {
  const Json good = record();
  const auto expect_refused = [this](const Json& bad, const std::string& what) {
    RecordedCycle recorded;
    CycleReport read = report();
    EXPECT_THROW(recorded.read(bad, &read), std::exception) << what;
  };
  for (const char* path : {"/result", "/result/distances/1", "/steps/0/result"}) {
    for (const auto& entry : good.at(Json::json_pointer(path)).items()) {
      Json bad = good;
      bad.at(Json::json_pointer(path)).erase(entry.key());
      expect_refused(bad, path + ("/" + entry.key()) + " left out");
      bad.at(Json::json_pointer(path))[entry.key()] = Json::object({{"a", "b"}});
      expect_refused(bad, path + ("/" + entry.key()) + " replaced");
    }
  }
  for (const auto& [path, value] :
       std::vector<std::pair<const char*, Json>>{{"/result/contacts", {0, 1, 1}},
                                                 {"/result/contacts", {0, 1, 2, 1}},
                                                 {"/result/contacts", {0, 1, 1, 1000000}},
                                                 {"/result/separations_m", {0.5}},
                                                 {"/result/distances/0/bodies", {0, 2}},
                                                 {"/result/distances/0/bodies", {1, 0}},
                                                 {"/result/distances/0/points", {1, 2, 3}},
                                                 {"/steps/0/result/first_times", {0.5, 0.5}},
                                                 {"/steps/0/result/first_times", Json::array()},
                                                 {"/steps/0/result/within_pad", {1}},
                                                 {"/steps", Json::array()},
                                                 {"/steps/1/rejected", {0}},
                                                 {"/steps/1/from_ns", 5},
                                                 {"/containment/parts", {{0, 1}}}}) {
    Json bad = good;
    bad.at(Json::json_pointer(path)) = value;
    expect_refused(bad, path);
  }
}

TEST_F(CycleRecords, AScenesChecksumIsOfWhatContactsDependOn) {
  std::set<std::uint32_t> sums;
  const auto add = [&](const char* what) {
    EXPECT_TRUE(sums.insert(sceneChecksum(cycle_)).second) << what;
  };
  Scene scene = scene_;
  cycle_.scene = &scene;
  add("as it was");
  RigidTransform pose;
  pose.translation[1] = 1e-12;
  scene.setPose(0, pose);
  add("a pose");
  scene.setMargin(1, 0.1F);
  add("a margin");
  std::vector<float> vertices = scene.body(1).mesh.vertices;
  vertices[4] += 1e-3F;
  scene.setVertices(1, vertices.data(), vertices.size() / 3);
  add("a vertex");
  scene.setPairEnabled(1, 1, !scene.pairEnabled(1, 1));
  add("a pair");
  TriangleMesh mesh = scene.body(1).mesh;
  mesh.triangles.resize(mesh.triangles.size() - 3);
  scene.setMesh(1, mesh);
  add("a triangle");
}

}  // namespace
}  // namespace deformable_contact_monitor
