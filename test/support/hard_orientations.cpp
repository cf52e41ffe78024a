#include "hard_orientations.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/predicates/float32_filters.h"
#include "core/predicates/orientation.h"

namespace deformable_contact_monitor {
namespace {

constexpr int kSteps = 20000;

class Climber {
 public:
  Climber(unsigned seed, FirstPoint first) : random_(seed), first_(first) {}

  HardOrientation climb() {
    HardOrientation best = start();
    for (int step = 0; step < kSteps; ++step) {
      HardOrientation next = best;
      change(next);
      next.off_by = offBy(next.p);
      if (next.off_by >= best.off_by) best = next;
    }
    return best;
  }

 private:
  unsigned below(unsigned end) { return static_cast<unsigned>(random_() % end); }
  float within1() {
    return static_cast<float>(static_cast<int>(below((1U << 24) + 1)) - (1 << 23)) / (1 << 23);
  }

  HardOrientation start() {
    HardOrientation from;
    for (int i = first_ == FirstPoint::kAtOrigin ? 1 : 0; i < 3; ++i) {
      from.p[i] = {within1(), within1(), within1()};
    }
    const float s = within1(), r = within1();
    const Vec3f& o = from.p[0];
    from.p[3] = o + (from.p[1] - o) * s + (from.p[2] - o) * r;
    from.off_by = offBy(from.p);
    return from;
  }

  // One coordinate, by a step of any size.
  void change(HardOrientation& points) {
    const unsigned i = first_ == FirstPoint::kAtOrigin ? 1 + below(3) : below(4);
    float* const coordinates[] = {&points.p[i].x, &points.p[i].y, &points.p[i].z};
    float& changed = *coordinates[below(3)];
    const int power = -static_cast<int>(below(25));
    changed += std::ldexp(within1(), power);
  }

  // Negative where the sign is right.
  static double offBy(const Vec3f (&p)[4]) {
    float value, error;
    PlaneFilter(Triangle{{p[0], p[1], p[2]}}).distance(p[3].x, p[3].y, p[3].z, value, error);
    double terms;  // double is exact enough here
    const double truth = orient3dDouble(p[0], p[1], p[2], p[3], terms);
    const double off = terms > 0 ? std::ldexp(value / terms, 24) : 0;
    return truth > 0 ? -off : truth < 0 ? off : std::fabs(off);
  }

  std::mt19937 random_;
  FirstPoint first_;
};

}  // namespace

std::vector<HardOrientation> hardOrientations(unsigned seed, int climbs, FirstPoint first) {
  Climber climber(seed, first);
  std::vector<HardOrientation> hard;
  while (static_cast<int>(hard.size()) < climbs) hard.push_back(climber.climb());
  return hard;
}

std::vector<TrianglesPair> pairsOn(const std::vector<HardOrientation>& hard, int each) {
  GridDice dice(1);
  std::vector<TrianglesPair> pairs;
  for (const HardOrientation& points : hard) {
    for (int i = 0; i < each; ++i) {
      const Vec3f a = dice.point(1 << 10) * 0x1p-10F, b = dice.point(1 << 10) * 0x1p-10F;
      pairs.push_back({{{points.p[0], points.p[1], a}}, {{points.p[2], points.p[3], b}}});
    }
  }
  return pairs;
}

double worstOf(const std::vector<HardOrientation>& hard) {
  double worst = 0;
  for (const HardOrientation& points : hard) worst = std::max(worst, points.off_by);
  return worst;
}

}  // namespace deformable_contact_monitor
