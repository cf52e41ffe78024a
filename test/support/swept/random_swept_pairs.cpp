// Seeded random pairs of triangles in two states on small integers, where ties are the rule.
#include "random_swept_pairs.h"

#include <algorithm>
#include <array>

namespace deformable_contact_monitor {
namespace {

class PairMaker {
 public:
  explicit PairMaker(std::mt19937& generator) : generator_(generator) {
    constexpr std::array<unsigned, 5> kSides{2, 3, 4, 6, 9};
    side_ = kSides[below(kSides.size())];
  }

  SweptPair make() {
    SweptPair pair{triangle(), triangle(), triangle(), triangle()};
    degenerate(&pair.a0, &pair.a1);
    degenerate(&pair.b0, &pair.b1);
    if (oneIn(5)) pair.a1 = pair.a0;
    if (oneIn(4)) pair.b1 = pair.b0;
    if (oneIn(5)) flatten(&pair);
    for (unsigned k = oneIn(2) ? below(4) : 0; k > 0; --k) {
      const unsigned i = below(3), j = below(3);
      pair.b0.v[j] = pair.a0.v[i];
      if (!oneIn(4)) pair.b1.v[j] = pair.a1.v[i];
    }
    return pair;
  }

 private:
  unsigned below(std::size_t n) { return static_cast<unsigned>(generator_() % n); }
  bool oneIn(unsigned n) { return below(n) == 0; }
  float coordinate() { return static_cast<float>(below(side_)); }

  Triangle triangle() {
    Triangle t;
    for (Vec3f& v : t.v) v = {coordinate(), coordinate(), coordinate()};
    return t;
  }

  void degenerate(Triangle* state0, Triangle* state1) {
    if (!oneIn(4)) return;
    const unsigned points = 1 + below(2);  // of the first vertices: a segment, or a point
    const unsigned states = 1 + below(3);
    for (unsigned i = points; i < 3; ++i) {
      if ((states & 1) != 0) state0->v[i] = state0->v[below(points)];
      if ((states & 2) != 0) state1->v[i] = state1->v[below(points)];
    }
  }

  // Into planes of constant z, the same for both triangles; z may differ between the states.
  void flatten(SweptPair* pair) {
    const float z0 = coordinate(), z1 = coordinate();
    for (int i = 0; i < 3; ++i) {
      pair->a0.v[i].z = pair->b0.v[i].z = z0;
      pair->a1.v[i].z = pair->b1.v[i].z = z1;
    }
  }

  std::mt19937& generator_;
  unsigned side_;
};

Vec3f between(const Vec3f& start, const Vec3f& end, int numerator, int denominator) {
  return start * static_cast<float>(denominator - numerator) + end * static_cast<float>(numerator);
}

}  // namespace

SweptPair randomSweptPair(std::mt19937& generator) { return PairMaker(generator).make(); }

Triangle at(const Triangle& state0, const Triangle& state1, int numerator, int denominator) {
  Triangle out;
  for (int i = 0; i < 3; ++i) {
    out.v[i] = between(state0.v[i], state1.v[i], numerator, denominator);
  }
  return out;
}

std::vector<Vec3f> sharedAt(const SweptPair& pair, int numerator, int denominator) {
  std::vector<Vec3f> out;
  for (int i = 0; i < 3; ++i) {
    const Vec3f &start = pair.a0.v[i], &end = pair.a1.v[i];
    for (int j = 0; j < 3; ++j) {
      if (start != pair.b0.v[j] || end != pair.b1.v[j]) continue;
      const Vec3f v = between(start, end, numerator, denominator);
      if (std::find(out.begin(), out.end(), v) == out.end()) out.push_back(v);
    }
  }
  return out;
}

}  // namespace deformable_contact_monitor
