#include "core/cpu/fuzzy_clustering.h"

#include <algorithm>
#include <cmath>

#include "core/common/parallel.h"

namespace deformable_contact_monitor {
namespace {

// The inner loops run over all prototypes for one point. They are written in fixed lanes, which the
// compiler turns into vector instructions without being allowed to reorder a sum.
constexpr std::size_t kLanes = 8;
// Number of points between two checks of the limit.
constexpr std::size_t kPoints = 32;

// Powers for the default fuzzifier, 2: no calls of pow().
struct SquarePowers {  // m = 2, the default
  float weight(float ratio) const { return ratio; }
  float power(float u) const { return u * u; }
};

// Powers for every other one. Tiny weights and memberships count as 0: they would move nothing, and
// their powers may be subnormal, which costs a processor hundreds of cycles at each use.
struct NormalPowers {
  FuzzyPowers powers;
  float least_ratio = std::pow(kLeast, powers.m - 1), least_u = std::pow(kLeast, 1 / powers.m);

  float weight(float ratio) const { return ratio < least_ratio ? 0 : powers.weight(ratio); }
  float power(float u) const { return u < least_u ? 0 : powers.power(u); }

  static constexpr float kLeast = 1e-20F;
};

// Prototypes as arrays, padded to full lanes with far points, whose weights stay 0.
struct Lanes {
  std::vector<float> x, y, z;
  std::size_t count;  // of prototypes, without the padding

  explicit Lanes(const std::vector<Vec3f>& prototypes) : count(prototypes.size()) {
    const std::size_t padded = (prototypes.size() + kLanes - 1) / kLanes * kLanes;
    x.assign(padded, kFar);
    y.assign(padded, kFar);
    z.assign(padded, kFar);
    for (std::size_t j = 0; j < prototypes.size(); ++j) {
      x[j] = prototypes[j].x;
      y[j] = prototypes[j].y;
      z[j] = prototypes[j].z;
    }
  }
  std::size_t size() const { return x.size(); }

  static constexpr float kFar = 1e18F;  // its square is finite
};

// The sums u^m and u^m (x - p) of each prototype, and scratch space for one point.
struct Sums {
  std::vector<float> weight, x, y, z, d2, w;
  double objective = 0;

  explicit Sums(std::size_t size) : weight(size), x(size), y(size), z(size), d2(size), w(size) {}
};

// Computes the squared distances from a point to all prototypes, and returns the least.
float fillDistances(const Lanes& p, const Vec3f& point, std::vector<float>& d2) {
  float least[kLanes];
  std::fill_n(least, kLanes, INFINITY);
  for (std::size_t j = 0; j < p.size(); j += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) {
      const float dx = point.x - p.x[j + l], dy = point.y - p.y[j + l], dz = point.z - p.z[j + l];
      const float d = dx * dx + dy * dy + dz * dz;
      d2[j + l] = d;
      least[l] = d < least[l] ? d : least[l];
    }
  }
  return *std::min_element(least, least + kLanes);
}

// Computes the weights w of `count` prototypes from the squared distances d2. They are not
// normalised: the weight of the nearest prototype is 1. Returns their sum. The padding is left out,
// because weights of far points would be subnormal, which costs a processor hundreds of cycles.
template <class Powers>
float fillWeights(const Powers& powers, float min2, std::size_t count, const std::vector<float>& d2,
                  std::vector<float>& w) {
  float sum[kLanes] = {};
  if (min2 == 0) {  // on one or more prototypes: it belongs to them alone
    for (std::size_t j = 0; j < d2.size(); ++j) w[j] = d2[j] == 0 ? 1.0F : 0.0F;
    return static_cast<float>(std::count(d2.begin(), d2.end(), 0.0F));
  }
  const float* __restrict from = d2.data();
  float* __restrict to = w.data();
  for (std::size_t j = 0; j < count; ++j) to[j] = powers.weight(min2 / from[j]);
  for (std::size_t j = 0; j < d2.size(); j += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) sum[l] += to[j + l];
  }
  float total = 0;
  for (const float s : sum) total += s;
  return total;
}

// Adds one point to the sums of all prototypes, weighted by its memberships.
template <class Powers>
void accumulate(const Powers& powers, const Lanes& p, const Vec3f& point, Sums& sums) {
  const float min2 = fillDistances(p, point, sums.d2);
  const float normalise = 1 / fillWeights(powers, min2, p.count, sums.d2, sums.w);
  // Without __restrict the compiler would have to expect that the arrays overlap.
  const float* __restrict px = p.x.data();
  const float* __restrict py = p.y.data();
  const float* __restrict pz = p.z.data();
  float* __restrict um = sums.w.data();
  float* __restrict weight = sums.weight.data();
  float* __restrict x = sums.x.data();
  float* __restrict y = sums.y.data();
  float* __restrict z = sums.z.data();
  for (std::size_t k = 0; k < p.size(); ++k) {
    um[k] = powers.power(um[k] * normalise);
    weight[k] += um[k];
    x[k] += um[k] * (point.x - px[k]);
    y[k] += um[k] * (point.y - py[k]);
    z[k] += um[k] * (point.z - pz[k]);
  }
  float objective[kLanes] = {};
  for (std::size_t k = 0; k < p.size(); k += kLanes) {
    for (std::size_t l = 0; l < kLanes; ++l) objective[l] += um[k + l] * sums.d2[k + l];
  }
  for (const float o : objective) sums.objective += o;
}

// Adds all points, in blocks with sums of their own, so that sums do not depend on threads.
template <class Powers>
void accumulateAll(const Powers& powers, const Lanes& p, const std::vector<Vec3f>& points,
                   std::size_t block_size, const CycleLimit& limit, std::vector<Sums>& partial) {
  parallelBlocks(limit, points.size(), block_size,
                 [&](std::size_t block, std::size_t begin, std::size_t end) {
                   PacedLimit pace(limit, kPoints);
                   for (std::size_t i = begin; i < end && !pace.over(); ++i) {
                     accumulate(powers, p, points[i], partial[block]);
                   }
                 });
}

}  // namespace

void FuzzyClustering::initialise(const std::vector<Vec3f>& points, std::size_t count) {
  prototypes_.resize(std::min(count, points.size()));
  for (std::size_t j = 0; j < prototypes_.size(); ++j) {
    prototypes_[j] = points[seedOf(j, prototypes_.size(), points.size())];
  }
  const Lanes lanes(prototypes_);
  std::vector<float> d2(lanes.size());
  std::vector<Vec3d> sums(prototypes_.size());
  std::vector<std::size_t> members(prototypes_.size());
  PacedLimit pace(limit_, kPoints);
  for (const Vec3f& p : points) {
    if (pace.over()) return;
    const float min2 = fillDistances(lanes, p, d2);
    const auto nearest =
        static_cast<std::size_t>(std::find(d2.begin(), d2.end(), min2) - d2.begin());
    sums[nearest] = sums[nearest] + toDouble(p);
    ++members[nearest];
  }
  for (std::size_t j = 0; j < prototypes_.size(); ++j) {
    if (members[j] == 0) continue;
    prototypes_[j] = toFloat(sums[j] * (1.0 / static_cast<double>(members[j])));
  }
}

double FuzzyClustering::iterate(const std::vector<Vec3f>& points) {
  constexpr std::size_t kBlock = 128;
  const Lanes lanes(prototypes_);
  std::vector<Sums> partial(blockCount(points.size(), kBlock), Sums(lanes.size()));
  if (powers_.m == 2) {
    accumulateAll(SquarePowers(), lanes, points, kBlock, limit_, partial);
  } else {
    accumulateAll(NormalPowers{powers_}, lanes, points, kBlock, limit_, partial);
  }
  if (limit_.wasOver()) return 0;
  double objective = 0;
  for (const Sums& sums : partial) objective += sums.objective;
  for (std::size_t j = 0; j < prototypes_.size(); ++j) {
    double weight = 0, x = 0, y = 0, z = 0;
    for (const Sums& sums : partial) {
      weight += sums.weight[j];
      x += sums.x[j];
      y += sums.y[j];
      z += sums.z[j];
    }
    if (!(weight > 0)) continue;
    const Vec3f step{static_cast<float>(x / weight), static_cast<float>(y / weight),
                     static_cast<float>(z / weight)};
    if (isFinite(step)) prototypes_[j] = prototypes_[j] + step;
  }
  return objective;
}

std::vector<float> FuzzyClustering::memberships(const Vec3f& point) const {
  const Lanes lanes(prototypes_);
  std::vector<float> d2(lanes.size()), w(lanes.size());
  const float min2 = fillDistances(lanes, point, d2);
  const float normalise = 1 / fillWeights(powers_, min2, lanes.count, d2, w);
  w.resize(prototypes_.size());
  for (float& u : w) u *= normalise;
  return w;
}

}  // namespace deformable_contact_monitor
