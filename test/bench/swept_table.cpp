// Prints, for meshes in two states, what the filters of swept contacts leave of a body's pairs with
// itself, how long each takes, and the verdicts. One thread.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "core/cpu/moving_pair_filter.h"
#include "core/mesh_file.h"
#include "core/predicates/swept_exact.h"
#include "moving_meshes.h"

namespace deformable_contact_monitor {
namespace {

struct Candidate {
  const MovingTriangle *a, *b;
  SharedVertices shared;
};

// Returns processor time.
double millisecondsSince(std::clock_t start) {
  return 1000.0 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

void printEach(const char* what, std::size_t count, double ms) {
  std::printf("%s: %zu features, %.1f ms, %.3f us each\n", what, count, ms,
              count == 0 ? 0 : 1000 * ms / static_cast<double>(count));
}

// Leaves those that `settled` is false for, and prints a row.
template <class Settled>
void filter(const char* name, std::vector<Candidate>& pairs, const Settled& settled) {
  const std::clock_t start = std::clock();
  std::vector<Candidate> left;
  for (const Candidate& pair : pairs) {
    if (!settled(*pair.a, *pair.b)) left.push_back(pair);
  }
  const double ms = millisecondsSince(start);
  std::printf("%-28s settled %9zu, left %9zu, %8.1f ms\n", name, pairs.size() - left.size(),
              left.size(), ms);
  pairs.swap(left);
}

void printVerdicts(const char* name, const std::vector<Candidate>& pairs, AdjacentPairs adjacent,
                   bool wants_time, Predicates mode) {
  PredicateState state;
  state.mode = mode;
  std::size_t contacts = 0, undecided = 0, exact = 0;
  const std::clock_t start = std::clock();
  for (const Candidate& pair : pairs) {
    state.undecided = false;
    state.exact = 0;
    const SweptVerdict verdict =
        sweptVerdict(*pair.a, *pair.b, pair.shared, adjacent, wants_time, state);
    contacts += verdict.part == PartVerdict::kMeet ? 1 : 0;
    undecided += state.undecided ? 1 : 0;
    exact += state.exact > 0 ? 1 : 0;
  }
  std::printf("%-40s %8zu contacts, %6zu undecided, %6zu exact, %8.1f ms\n", name, contacts,
              undecided, exact, millisecondsSince(start));
}

bool meetsAt(const Triangle& a, const Triangle& b) {
  PredicateState state;
  return trianglesIntersect(a, b, state);
}

// Pairs that share nothing, in the order of the research note's table.
void printFilters(std::vector<Candidate> pairs) {
  filter("moving boxes", pairs, [](const MovingTriangle& a, const MovingTriangle& b) {
    return areApart(boxOf(a), boxOf(b));
  });
  filter("moving planes", pairs, [](const MovingTriangle& a, const MovingTriangle& b) {
    return MovingSides<double>(MovingPlane<double>(a), b).areApart() ||
           MovingSides<double>(MovingPlane<double>(b), a).areApart();
  });
  filter("fixed directions", pairs, [](const MovingTriangle& a, const MovingTriangle& b) {
    return FixedDirections<double>(a, b).areApart();
  });
  filter("contact at t = 0", pairs,
         [](const MovingTriangle& a, const MovingTriangle& b) { return meetsAt(a.from, b.from); });
  filter("contact at t = 1", pairs,
         [](const MovingTriangle& a, const MovingTriangle& b) { return meetsAt(a.to, b.to); });
  std::vector<Feature> features;
  const std::clock_t start = std::clock();
  for (const Candidate& pair : pairs) {
    for (int i = 0; i < kFeatures; ++i) {
      const Feature feature = featureOf(*pair.a, *pair.b, i);
      if (!areApart(feature)) features.push_back(feature);
    }
  }
  std::printf("features' boxes: left %zu of %zu, %.1f ms\n", features.size(),
              pairs.size() * kFeatures, millisecondsSince(start));
  std::vector<std::pair<Feature, Cubic<double>>> left;
  const std::clock_t signs = std::clock();
  for (const Feature& feature : features) {
    const Cubic<double> d = coplanarity<double>(feature);
    if (d.sign() == 0) left.emplace_back(feature, d);
  }
  std::printf("features' signs: left %zu, %.1f ms\n", left.size(), millisecondsSince(signs));
  std::vector<Feature> open;
  std::size_t met = 0, with_integers = 0;
  const std::clock_t halving = std::clock();
  for (const auto& [feature, d] : left) {
    const FeatureVerdict verdict = halvedVerdict(feature, d, false, 1.0F);
    met += verdict.part == PartVerdict::kMeet ? 1 : 0;
    if (verdict.part == PartVerdict::kOpen) open.push_back(feature);
  }
  printEach("halving", left.size(), millisecondsSince(halving));
  const std::clock_t integers = std::clock();
  for (const Feature& feature : open) {
    with_integers += integerSigns(feature) == IntegerSigns::kNoRootWithin ? 1 : 0;
  }
  printEach("integer signs", open.size(), millisecondsSince(integers));
  const std::clock_t exact = std::clock();
  for (const Feature& feature : open) met += exactFeatureTime(feature, false).happens() ? 1 : 0;
  printEach("exact", open.size(), millisecondsSince(exact));
  std::printf("%zu features meet; integer signs alone settle %zu\n", met, with_integers);
}

// Runs what the CPU backend does: the filters in vector lanes, then verdicts on the remaining
// pairs.
void printScreen(const std::vector<Candidate>& pairs, bool wants_time) {
  std::vector<MovingTriangles> meet;
  for (const Candidate& pair : pairs) {
    if (!areApart(boxOf(*pair.a), boxOf(*pair.b))) meet.push_back({pair.a, pair.b});
  }
  constexpr std::size_t kPart = 1 << 14;
  std::vector<Candidate> open;
  std::size_t meeting = 0;
  MovingPairFilter filter;
  const std::clock_t start = std::clock();
  for (std::size_t begin = 0; begin < meet.size(); begin += kPart) {
    const std::size_t end = std::min(meet.size(), begin + kPart);
    const std::vector<MovingTriangles> part(&meet[begin], &meet[begin] + (end - begin));
    filter.filter(part, wants_time);
    meeting += filter.meeting().size();
    for (const std::uint32_t i : filter.open()) open.push_back({part[i].a, part[i].b, {}});
  }
  std::printf("in lanes%s: of %zu pairs %zu in contact, %zu open, %.1f ms\n",
              wants_time ? ", with times" : "", meet.size(), meeting, open.size(),
              millisecondsSince(start));
  printVerdicts("  verdicts on these", open, AdjacentPairs::kSkip, wants_time, Predicates::kExact);
}

int run(const char* from, const char* to) {
  const std::vector<MovingTriangle> triangles =
      movingTriangles(readMeshFile(from), readMeshFile(to));
  const std::clock_t start = std::clock();
  std::vector<Candidate> disjoint, sharing;
  for (const auto& [i, j] : sweptBoxPairs(triangles)) {
    const SharedVertices shared = sharedTrajectories(triangles[i], triangles[j]);
    (shared.any ? sharing : disjoint).push_back({&triangles[i], &triangles[j], shared});
  }
  std::printf("swept box pairs: %zu share nothing, %zu share vertices, %.1f ms\n", disjoint.size(),
              sharing.size(), millisecondsSince(start));
  const AdjacentPairs beyond = AdjacentPairs::kBeyondShared;
  printVerdicts("verdicts, sharing nothing", disjoint, beyond, false, Predicates::kExact);
  printVerdicts("with times", disjoint, beyond, true, Predicates::kExact);
  printVerdicts("conservative", disjoint, beyond, false, Predicates::kConservative);
  printVerdicts("verdicts, beyond shared vertices", sharing, beyond, false, Predicates::kExact);
  printVerdicts("with times", sharing, beyond, true, Predicates::kExact);
  printVerdicts("conservative", sharing, beyond, false, Predicates::kConservative);
  for (const bool wants_time : {false, true}) printScreen(disjoint, wants_time);
  printFilters(std::move(disjoint));
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: swept_table MESH0 MESH1\n");
    return 2;
  }
  return deformable_contact_monitor::run(argv[1], argv[2]);
}
