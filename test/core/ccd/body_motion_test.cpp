// How far bodies are from straight lines: against motions that are known at every time.
#include "core/ccd/body_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "core/ccd/sub_step_scene.h"
#include "swept/screw_motions.h"

namespace deformable_contact_monitor {
namespace {

double distance(const Place& a, const Place& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                   (a[2] - b[2]) * (a[2] - b[2]));
}

Place between(const Place& a, const Place& b, double part) {
  return {a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]), a[2] + part * (b[2] - a[2])};
}

// The largest distance of a moving point from its straight line, of many times.
double sampledDeviation(const std::function<Place(double)>& at, double from, double to) {
  double most = 0;
  for (int k = 1; k < 64; ++k) {
    const double part = k / 64.0;
    most = std::max(most, distance(at(from + part * (to - from)), between(at(from), at(to), part)));
  }
  return most;
}

Body bodyOf(std::vector<float> vertices) {
  Body body;
  body.name = "link";
  body.mesh = {std::move(vertices), {0, 0, 0}};
  return body;
}

std::vector<float> floatsOf(const Place& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

Place placeOf(const std::vector<float>& v) { return {v[0], v[1], v[2]}; }

TEST(BodyMotion, IsTheScrewMotionAtAllTimes) {
  std::mt19937 random(1);
  for (int i = 0; i < 4000; ++i) {
    const ScrewMotion screw = randomScrewMotion(&random, 1, 3.14);
    const Body body = bodyOf({0.3F, -0.2F, 0.1F});
    const BodyPath path = screw.path(i % 3);
    const BodyMotion motion(body, path);
    const Place v = placeOf(body.mesh.vertices);
    for (const double at : {0.0, 0.1, 0.5, 0.77, 1.0}) {
      ASSERT_LT(distance(placeOf(motion.poseAt(at), v), placeOf(screw.at(at), v)), 1e-14);
    }
  }
}

TEST(BodyMotion, DeviatesByItsBoundAtMostAndNearlyByIt) {
  std::mt19937 random(2);
  double largest_share = 0;
  for (int i = 0; i < 4000; ++i) {
    const ScrewMotion screw = randomScrewMotion(&random, 1, i % 2 == 0 ? 0.1 : 2.5);
    Place v = randomUnit(&random);
    for (double& x : v) x *= uniform(&random, 0.01, 0.9);
    if (i % 4 == 0) {  // across the axis: there the bound is attained
      const double* r = screw.start.rotation;
      const Place& u = screw.axis;
      const Place in_body{r[0] * u[0] + r[3] * u[1] + r[6] * u[2],
                          r[1] * u[0] + r[4] * u[1] + r[7] * u[2],
                          r[2] * u[0] + r[5] * u[1] + r[8] * u[2]};
      v = {v[1] * in_body[2] - v[2] * in_body[1], v[2] * in_body[0] - v[0] * in_body[2],
           v[0] * in_body[1] - v[1] * in_body[0]};
    }
    const Body body = bodyOf(floatsOf(v));
    v = placeOf(body.mesh.vertices);
    const BodyPath path = screw.path();
    const BodyMotion motion(body, path);
    const double from = uniform(&random, 0, 0.5), to = uniform(&random, 0.6, 1);
    const double bound = motion.deviation(from, to);
    const double sampled =
        sampledDeviation([&](double at) { return placeOf(screw.at(at), v); }, from, to);
    ASSERT_LE(sampled, bound) << i;
    largest_share = std::max(largest_share, sampled / bound);
  }
  EXPECT_GT(largest_share, 0.9999);
}

// Over samples where the way bends.
TEST(BodyMotion, CornersCount) {
  std::mt19937 random(3);
  double sum_of_shares = 0;
  for (int i = 0; i < 1000; ++i) {
    BodyPath path{{0, randomScrewMotion(&random, 0.5, 1).start}};
    std::vector<ScrewMotion> pieces;
    const int count = 2 + i % 4;
    for (int k = 0; k < count; ++k) {
      ScrewMotion piece = randomScrewMotion(&random, 0.5, 0.2);
      piece.start = path.back().pose;
      pieces.push_back(piece);
      path.push_back({(k + 1.0) / count, piece.at(1)});
    }
    const Body body = bodyOf(floatsOf(randomUnit(&random)));
    const Place v = placeOf(body.mesh.vertices);
    const BodyMotion motion(body, path);
    const auto at = [&](double part) {
      const int k = std::min(static_cast<int>(part * count), count - 1);
      return placeOf(pieces[static_cast<std::size_t>(k)].at(part * count - k), v);
    };
    const double from = uniform(&random, 0, 0.3), to = uniform(&random, 0.7, 1);
    const double bound = motion.deviation(from, to), sampled = sampledDeviation(at, from, to);
    ASSERT_LE(sampled, bound) << i;
    sum_of_shares += sampled / bound;
  }
  EXPECT_GT(sum_of_shares / 1000, 0.4);
}

// A cloth in a frame that turns.
TEST(BodyMotion, WhatDeformsInAFrameThatTurns) {
  std::mt19937 random(4);
  double largest_share = 0;
  for (int i = 0; i < 1000; ++i) {
    const ScrewMotion screw = randomScrewMotion(&random, 1, 1);
    Body body = bodyOf(floatsOf(randomUnit(&random)));
    const Place v1 = placeOf(body.mesh.vertices);
    Place v0 = randomUnit(&random);
    for (std::size_t k = 0; k < 3; ++k) v0[k] = v1[k] + 0.2 * v0[k];
    body.earlier = EarlierState{screw.at(0), floatsOf(v0)};
    v0 = placeOf(body.earlier->vertices);
    const BodyPath path = screw.path();
    const BodyMotion motion(body, path);
    const auto at = [&](double part) { return placeOf(screw.at(part), between(v0, v1, part)); };
    const double bound = motion.deviation(0.2, 0.8), sampled = sampledDeviation(at, 0.2, 0.8);
    ASSERT_LE(sampled, bound) << i;
    largest_share = std::max(largest_share, sampled / bound);
    const std::vector<float> middle = motion.verticesAt(0.5);
    ASSERT_LT(distance(placeOf(middle), between(v0, v1, 0.5)), 1e-7);
    ASSERT_EQ(motion.verticesAt(0), body.earlier->vertices);
    ASSERT_EQ(motion.verticesAt(1), body.mesh.vertices);
  }
  EXPECT_GT(largest_share, 0.9);
}

TEST(BodyMotion, RoundingToFloatsIsWithinItsBound) {
  std::mt19937 random(5);
  double largest_share = 0;
  for (int i = 0; i < 20000; ++i) {
    const ScrewMotion screw = randomScrewMotion(&random, i % 2 == 0 ? 1 : 100, 1);
    const Body body = bodyOf(floatsOf(randomUnit(&random)));
    const BodyPath path = screw.path();
    const BodyMotion motion(body, path);
    const Place exact = placeOf(motion.poseAt(0.3), placeOf(body.mesh.vertices));
    const double off = distance(exact, placeOf(floatsOf(exact)));
    ASSERT_LE(off, motion.rounding());
    largest_share = std::max(largest_share, off / motion.rounding());
  }
  EXPECT_GT(largest_share, 0.5);
}

// A robot at rest, whose transforms are off by some bits, and one that slides evenly.
TEST(BodyMotion, WhatRoundingHidesIsNoBend) {
  std::mt19937 random(6);
  for (int i = 0; i < 300; ++i) {
    ScrewMotion screw = randomScrewMotion(&random, 1, 1e-6);
    const Body body = bodyOf(floatsOf(randomUnit(&random)));
    BodyPath path = screw.path(3);
    for (PoseSample& sample : path) {
      for (double& r : sample.pose.rotation) r *= 1 + uniform(&random, -1e-15, 1e-15);
    }
    EXPECT_FALSE(BodyMotion(body, path).rotates());
    screw.angle = 0.01;
    path = screw.path();
    EXPECT_TRUE(BodyMotion(body, path).rotates());
    screw.angle = 0;
    path = screw.path(1);
    EXPECT_FALSE(BodyMotion(body, path).rotates());
    path[1].pose.translation[2] += 1e-3;
    EXPECT_TRUE(BodyMotion(body, path).rotates());
  }
}

TEST(StepCuts, EachPieceIsWithinTheToleranceAndFewAreNeeded) {
  std::mt19937 random(7);
  for (int i = 0; i < 500; ++i) {
    const ScrewMotion screw = randomScrewMotion(&random, 1, 0.3);
    const Body body = bodyOf(floatsOf(randomUnit(&random)));
    const BodyPath path = screw.path(i % 40);
    const BodyMotion motion(body, path);
    const auto deviation = [&](double from, double to) { return motion.deviation(from, to); };
    std::vector<double> bends;
    for (const PoseSample& sample : path) bends.push_back(sample.at);
    const double tolerance = std::pow(10, uniform(&random, -5.5, -2));
    const std::vector<double> cuts = cutInterval(bends, deviation, tolerance, 1000);
    ASSERT_EQ(cuts.front(), 0);
    ASSERT_EQ(cuts.back(), 1);
    for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
      ASSERT_LT(cuts[k], cuts[k + 1]);
      ASSERT_LE(deviation(cuts[k], cuts[k + 1]), tolerance * (1 + 1e-9));
    }
    // The number of cuts of one arc; samples between cost no more than 2.4 times as many.
    const double needed = std::ceil(screw.angle * std::sqrt(1 / (8 * tolerance)));
    ASSERT_LE(static_cast<double>(cuts.size() - 1), i % 40 == 0 ? needed + 1 : 2.4 * needed + 1);
  }
}

TEST(StepCuts, NeverMoreThanWereAskedFor) {
  const auto arc = [](double from, double to) { return (to - from) * (to - from); };
  std::vector<double> bends;
  for (int i = 0; i <= 1000; ++i) bends.push_back(i / 1000.0);
  for (const std::vector<double>& at : {std::vector<double>{0, 1}, bends}) {
    for (const double tolerance : {1e-3, 1e-9, 1e-30, 5e-324}) {
      const std::vector<double> cuts = cutInterval(at, arc, tolerance, 64);
      EXPECT_LE(cuts.size(), 65U);
      EXPECT_GT(cuts.size(), 25U);
      EXPECT_EQ(cuts.back(), 1);
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
