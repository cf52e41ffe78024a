// Prints how often verdicts on hard pairs of triangles are wrong, class by class: this package's
// predicates on the host and, where there is one, on a CUDA device, FCL's and a plain float32
// Moeller test, against CGAL's exact predicates.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "batch_verdicts.h"
#include "cgal_oracle.h"
#include "cuda/device/cuda_error.h"
#include "moller.h"
#include "scenes.h"
#include "tools/common/run_tool.h"
#ifdef DCM_HAVE_FCL
#include "pair_verdict.h"
#include "reference/reference_detectors.h"
#endif

namespace deformable_contact_monitor {
namespace {

constexpr int kPairs = 4000;

// Coordinates are multiples of 2^-20 m of a few decimetres: sums of some, and eighths of
// differences, are exact in float32.
class Dice {
 public:
  int within(int low, int high) {
    return low + static_cast<int>(random_() % static_cast<unsigned>(high - low + 1));
  }
  float metres(int most) { return static_cast<float>(within(-most, most)) * 0x1p-20F; }
  Vec3f point(int most) { return {metres(most), metres(most), metres(most)}; }
  Triangle triangle(int most) { return {{point(most), point(most), point(most)}}; }
  float eighths() { return static_cast<float>(within(0, 4)) / 8; }

 private:
  std::mt19937 random_{1};
};

struct Pair {
  Triangle a, b;
};

constexpr int kDecimetre = 0x20000;  // an eighth of a metre, in steps; a multiple of 8

Triangle steps(Triangle t) {  // whole multiples of 8 steps, so that eighths stay on the grid
  for (Vec3f& v : t.v) {
    v = {std::round(v.x * 0x1p17F) * 0x1p-17F, std::round(v.y * 0x1p17F) * 0x1p-17F,
         std::round(v.z * 0x1p17F) * 0x1p-17F};
  }
  return t;
}

Vec3f onFace(const Triangle& t, float s, float r) {
  return t.v[0] + (t.v[1] - t.v[0]) * s + (t.v[2] - t.v[0]) * r;
}

Pair vertexOnFace(Dice* dice) {
  const Triangle a = steps(dice->triangle(kDecimetre));
  const Vec3f p = onFace(a, dice->eighths(), dice->eighths());
  // The others on one side, so that only the vertex touches.
  const Vec3f u = a.v[1] - a.v[0], w = a.v[2] - a.v[0];
  Vec3f n{u.y * w.z - u.z * w.y, u.z * w.x - u.x * w.z, u.x * w.y - u.y * w.x};
  n = n * (1 / std::sqrt(dot(n, n) + 1e-30F));
  Triangle b{{p, p + n * 0.05F + dice->point(9000), p + n * 0.05F + dice->point(9000)}};
  return {a, b};
}

Pair vertexOnEdge(Dice* dice) {
  Pair pair = vertexOnFace(dice);
  const Vec3f shift = onFace(pair.a, dice->eighths(), 0) - pair.b.v[0];
  for (Vec3f& v : pair.b.v) v = v + shift;
  return pair;
}

Pair aMicrometreOff(Dice* dice) {
  Pair pair = vertexOnFace(dice);
  const Vec3f d = (pair.b.v[1] - pair.b.v[0]) * 1e-5F;  // about a micrometre off the face
  for (Vec3f& v : pair.b.v) v = v + d;
  return pair;
}

Pair coplanar(Dice* dice) {
  const Triangle plane = steps(dice->triangle(kDecimetre));
  Pair pair;
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = onFace(plane, dice->eighths(), dice->eighths());
  }
  return pair;
}

Pair millimetres(Dice* dice) {
  const auto place = dice->point(kDecimetre);
  Pair pair{dice->triangle(700), dice->triangle(700)};
  for (Triangle* t : {&pair.a, &pair.b}) {
    for (Vec3f& v : t->v) v = v + place;
  }
  return pair;
}

Pair parallelMillimetres(Dice* dice) {
  Pair pair = millimetres(dice);
  pair.b = pair.a;
  const Vec3f up{0, 0, 0x1p-20F * static_cast<float>(dice->within(1, 500))};
  for (Vec3f& v : pair.b.v) v = v + up;
  return pair;
}

Pair general(Dice* dice) { return {dice->triangle(kDecimetre), dice->triangle(kDecimetre)}; }

using Pairs = std::vector<Pair>;
using Verdicts = std::vector<bool>;

struct Method {
  std::string name;
  std::function<Verdicts(const Pairs&)> judge;
};

Verdicts oneByOne(const Pairs& pairs,
                  const std::function<bool(const Triangle&, const Triangle&)>& intersects) {
  Verdicts verdicts;
  verdicts.reserve(pairs.size());
  for (const Pair& pair : pairs) verdicts.push_back(intersects(pair.a, pair.b));
  return verdicts;
}

Verdicts onHost(const Pairs& pairs, Predicates mode) {
  return oneByOne(pairs, [mode](const Triangle& a, const Triangle& b) {
    PredicateState state;
    state.mode = mode;
    return pairVerdict(a, b, false, AdjacentPairs::kSkip, 0, state).contact;
  });
}

Verdicts onDevice(const Pairs& pairs, Predicates mode) {
  std::vector<VerdictQuestion> questions;
  for (const Pair& pair : pairs) questions.push_back({pair.a, pair.b, false});
  Verdicts verdicts;
  for (const BatchVerdict& verdict : batchVerdicts(questions, AdjacentPairs::kSkip, mode, 0)) {
    verdicts.push_back(verdict.contact == 1);
  }
  return verdicts;
}

bool hasDevice() {
  try {
    batchVerdicts({{}}, AdjacentPairs::kSkip, Predicates::kExact, 0);
    return true;
  } catch (const CudaError& error) {
    std::fprintf(stderr, "without CUDA: %s\n", error.what());
    return false;
  }
}

// Exact, then conservative, first on the host and then on the device, if there is one.
std::vector<Method> allMethods() {
  std::vector<Method> methods;
  const bool with_device = hasDevice();
  for (const Predicates mode : {Predicates::kExact, Predicates::kConservative}) {
    methods.push_back({toString(mode), [mode](const Pairs& p) { return onHost(p, mode); }});
    if (!with_device) continue;
    methods.push_back({std::string(toString(mode)) + ", cuda",
                       [mode](const Pairs& p) { return onDevice(p, mode); }});
  }
#ifdef DCM_HAVE_FCL
  const std::shared_ptr<Detector> fcl = makeFclDetector();
  methods.push_back({"FCL", [fcl](const Pairs& pairs) {
                       return oneByOne(pairs, [&fcl](const Triangle& a, const Triangle& b) {
                         const Scene scene = pairScene(meshOf({a}), meshOf({b}));
                         return !fcl->detect(scene, Options()).contacts.empty();
                       });
                     }});
#endif
  methods.push_back(
      {"Moeller float32", [](const Pairs& pairs) { return oneByOne(pairs, mollerIntersects); }});
  return methods;
}

// The table's row; whether what must not err did not.
bool printRow(const char* name, const Pairs& pairs, const std::vector<Method>& methods) {
  const Verdicts truth = oneByOne(pairs, [](const Triangle& a, const Triangle& b) {
    return meetBeyondByConstruction({a.v[0], a.v[1], a.v[2]}, {b.v[0], b.v[1], b.v[2]}, {});
  });
  const auto contacts = std::count(truth.begin(), truth.end(), true);
  std::printf("| %s | %.1f %% |", name, 100.0 * static_cast<double>(contacts) / kPairs);
  bool as_promised = true;
  for (const Method& method : methods) {
    const Verdicts found = method.judge(pairs);
    int missed = 0, added = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      missed += truth[i] && !found[i] ? 1 : 0;
      added += !truth[i] && found[i] ? 1 : 0;
    }
    std::printf(" %.2f / %.2f |", 100.0 * missed / kPairs, 100.0 * added / kPairs);
    const bool exact = method.name.rfind("exact", 0) == 0;
    const bool conservative = method.name.rfind("conservative", 0) == 0;
    as_promised &= (missed == 0 || !(exact || conservative)) && (added == 0 || !exact);
  }
  std::printf("\n");
  return as_promised;
}

int run() {
  const std::vector<Method> methods = allMethods();
  const std::vector<std::pair<const char*, Pair (*)(Dice*)>> classes = {
      {"general position", general},          {"vertex on face", vertexOnFace},
      {"vertex on edge", vertexOnEdge},       {"coplanar", coplanar},
      {"1 um off a face", aMicrometreOff},    {"1 mm triangles", millimetres},
      {"1 mm, parallel", parallelMillimetres}};
  std::printf("| %d pairs each, missed / false contacts [%%] | contacts |", kPairs);
  for (const Method& method : methods) std::printf(" %s |", method.name.c_str());
  std::printf("\n|---|---|");
  for (std::size_t i = 0; i < methods.size(); ++i) std::printf("---|");
  std::printf("\n");
  for (const auto& [name, make] : classes) {
    Dice dice;
    Pairs pairs;
    pairs.reserve(kPairs);
    for (int i = 0; i < kPairs; ++i) pairs.push_back(make(&dice));
    if (!printRow(name, pairs, methods)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main() {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("verdict_table", dcm::run);
}
