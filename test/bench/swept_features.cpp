// Prints, for meshes in two states, what a verdict on a vertex and a face, or on two edges, costs,
// of a body with itself: of all whose swept boxes overlap and that share no vertex, or of every
// n-th of them. Ours, and Tight-Inclusion's if it was built with it. One thread.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/common/stopwatch.h"
#include "core/mesh_file.h"
#include "core/predicates/swept_exact.h"
#include "moving_features.h"
#ifdef DCM_HAVE_TIGHT_INCLUSION
#include "tight_inclusion.h"
#endif

namespace deformable_contact_monitor {
namespace {

bool meets(const Feature& feature) {
  const Cubic<double> d = coplanarity<double>(feature);
  if (d.sign() != 0) return false;
  const FeatureVerdict verdict = halvedVerdict(feature, d, false, 1.0F);
  if (verdict.part != PartVerdict::kOpen) return verdict.part == PartVerdict::kMeet;
  return meetsExactly(feature);
}

using Corners = std::vector<std::uint32_t>;

// Parts of a mesh in two states: vertices, edges or faces.
struct Parts {
  std::vector<Corners> corners;
  std::vector<Aabb> boxes;
};

Parts partsOf(const TriangleMesh& from, const TriangleMesh& to, const std::set<Corners>& all) {
  Parts parts{{all.begin(), all.end()}, {}};
  for (const Corners& corners : parts.corners) {
    Aabb box;
    for (const std::uint32_t v : corners) {
      box.include(from.vertex(v));
      box.include(to.vertex(v));
    }
    parts.boxes.push_back(box);
  }
  return parts;
}

bool shareAny(const Corners& a, const Corners& b) {
  return std::any_of(a.begin(), a.end(),
                     [&b](std::uint32_t v) { return std::find(b.begin(), b.end(), v) != b.end(); });
}

// Calls use(a, b) for parts with overlapping boxes that share no vertex; of the same parts each two
// once.
template <class Use>
void forEachCandidate(const Parts& a, const Parts& b, const Use& use) {
  std::vector<std::pair<float, std::size_t>> order;
  float widest = 0;
  for (std::size_t j = 0; j < b.boxes.size(); ++j) {
    order.emplace_back(b.boxes[j].min.x, j);
    widest = std::max(widest, b.boxes[j].max.x - b.boxes[j].min.x);
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 0; i < a.boxes.size(); ++i) {
    const float low = a.boxes[i].min.x - 2 * widest, high = a.boxes[i].max.x;
    for (auto j = std::lower_bound(order.begin(), order.end(), std::make_pair(low, std::size_t{0}));
         j != order.end() && j->first <= high; ++j) {
      if ((&a == &b && j->second <= i) || !intersects(a.boxes[i], b.boxes[j->second])) continue;
      if (!shareAny(a.corners[i], b.corners[j->second])) use(a.corners[i], b.corners[j->second]);
    }
  }
}

std::vector<Feature> candidateFeatures(const TriangleMesh& from, const TriangleMesh& to) {
  std::set<Corners> vertices, edges, faces;
  for (std::size_t t = 0; t < from.triangles.size(); t += 3) {
    const std::uint32_t* const v = &from.triangles[t];
    faces.insert({v[0], v[1], v[2]});
    for (int k = 0; k < 3; ++k) {
      vertices.insert({v[k]});
      edges.insert({std::min(v[k], v[(k + 1) % 3]), std::max(v[k], v[(k + 1) % 3])});
    }
  }
  const auto point = [&from, &to](std::uint32_t v) -> MovingPoint {
    return {from.vertex(v), to.vertex(v)};
  };
  const Parts of_vertices = partsOf(from, to, vertices), of_edges = partsOf(from, to, edges),
              of_faces = partsOf(from, to, faces);
  std::vector<Feature> features;
  forEachCandidate(of_vertices, of_faces, [&](const Corners& a, const Corners& b) {
    features.push_back(
        {FeatureKind::kVertexFace, {point(b[0]), point(b[1]), point(b[2]), point(a[0])}});
  });
  forEachCandidate(of_edges, of_edges, [&](const Corners& a, const Corners& b) {
    features.push_back(
        {FeatureKind::kEdgeEdge, {point(a[0]), point(a[1]), point(b[0]), point(b[1])}});
  });
  return features;
}

// Prints a row; returns the verdicts.
template <class Meets>
std::vector<bool> measure(const char* name, const std::vector<Feature>& features,
                          const std::vector<bool>* truth, const Meets& verdict) {
  std::vector<bool> verdicts;
  std::vector<double> us;
  std::size_t hits = 0, falsely = 0, missed = 0;
  double sum = 0;
  for (const Feature& feature : features) {
    const Stopwatch watch;
    verdicts.push_back(verdict(feature));
    us.push_back(1000 * watch.elapsedMs());
    sum += us.back();
    hits += verdicts.back() ? 1 : 0;
    if (truth == nullptr) continue;
    falsely += verdicts.back() && !(*truth)[us.size() - 1] ? 1 : 0;
    missed += !verdicts.back() && (*truth)[us.size() - 1] ? 1 : 0;
  }
  std::sort(us.begin(), us.end());
  std::printf("| %s | %zu | %zu | %zu | %zu | %.3f | %.3f | %.1f |\n", name, features.size(), hits,
              falsely, missed, sum / static_cast<double>(us.size()), us[us.size() / 2], us.back());
  return verdicts;
}

void compare(const char* name, const std::vector<Feature>& features) {
  if (features.empty()) return;
  // The definition, by the exact step alone.
  std::vector<bool> truth;
  for (const Feature& feature : features) {
    truth.push_back(meetsAtStart(feature) || (coplanarity<double>(feature).sign() == 0 &&
                                              exactFeatureTime(feature, false).happens()));
  }
  std::printf("| %s | queries | hits | false | missed | mean us | median us | worst us |\n", name);
  std::printf("|---|---|---|---|---|---|---|---|\n");
  measure("clock alone", features, nullptr, [](const Feature&) { return false; });
  measure("ours", features, &truth, meets);
#ifdef DCM_HAVE_TIGHT_INCLUSION
  const std::vector<bool> theirs =
      measure("Tight-Inclusion", features, &truth, meetsByTightInclusion);
  std::vector<Feature> positive;
  std::vector<bool> positive_truth;
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (!theirs[i]) continue;
    positive.push_back(features[i]);
    positive_truth.push_back(truth[i]);
  }
  measure("its hits: ours", positive, &positive_truth, meets);
  measure("its hits: itself", positive, &positive_truth, meetsByTightInclusion);
#endif
}

int run(const char* from, const char* to, std::size_t each) {
  const std::vector<Feature> all = candidateFeatures(readMeshFile(from), readMeshFile(to));
  std::vector<Feature> some, open;
  for (std::size_t i = 0; i < all.size(); i += each) {
    some.push_back(all[i]);
    if (!areApart(all[i]) && coplanarity<double>(all[i]).sign() == 0) open.push_back(all[i]);
  }
  compare("features with overlapping swept boxes", some);
  compare("those that boxes and signs leave open", open);
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fprintf(stderr, "usage: swept_features MESH0 MESH1 [EACH]\n");
    return 2;
  }
  const long each = argc == 4 ? std::atol(argv[3]) : 1;
  return deformable_contact_monitor::run(argv[1], argv[2],
                                         static_cast<std::size_t>(std::max(each, 1L)));
}
