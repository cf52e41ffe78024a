#include "core/candidate_judge.h"

#include <algorithm>

namespace deformable_contact_monitor {

void SweepOutput::add(const SweepOutput& part) {
  contacts.insert(contacts.end(), part.contacts.begin(), part.contacts.end());
  interval_overlaps += part.interval_overlaps;
  candidates += part.candidates;
  exact += part.exact;
  undecided += part.undecided;
  sort_ms += part.sort_ms;
  sweep_ms += part.sweep_ms;
  narrow_ms += part.narrow_ms;
}

Triangle CandidateJudge::received(std::uint32_t t) const {
  const WorkingSet& set = input_.set;
  const TriangleMesh& mesh = input_.scene.body(set.body[t]).mesh;
  const std::uint32_t* corner = &mesh.triangles[3 * std::size_t{set.triangle[t]}];
  Triangle triangle;
  for (int k = 0; k < 3; ++k) {
    const float* v = &mesh.vertices[3 * std::size_t{corner[k]}];
    triangle.v[k] = {v[0], v[1], v[2]};
  }
  return triangle;
}

float CandidateJudge::marginOf(const Contender& a, const Contender& b) const {
  return std::max(input_.scene.body(a.body).margin_m, input_.scene.body(b.body).margin_m);
}

void CandidateJudge::judge(const Contender& a, const Contender& b) {
  SharedVertices shared;
  if (a.body == b.body) {
    shared = sharedVertices(a.lanes, b.lanes);
    if (shared.any && input_.set.as_received[a.body] == 0) {
      // Adjacency is that of the coordinates as received; posing may have made different ones
      // equal.
      shared = sharedVertices(received(a.triangle), received(b.triangle));
    }
  }
  if (shared.any) {
    judgeAdjacent(a, b, shared);
  } else {
    ++output_.candidates;
    judgeSeparate(a, b);
  }
}

void CandidateJudge::judge(const std::vector<Contender>& contenders, Hit* hits, std::size_t count) {
  neighbours_.resize(count);
  std::size_t neighbours = 0, separate = 0, undecided = 0;
  for (std::size_t h = 0; h < count; ++h) {
    const Hit hit = hits[h];
    const Contender &a = contenders[hit.a], &b = contenders[hit.b];
    const bool neighbour = (a.body == b.body) & shareVertex(a.lanes, b.lanes);
    neighbours_[neighbours] = hit;
    neighbours += neighbour;
    hits[separate] = hit;
    separate += !neighbour;
  }
  output_.candidates += separate;
  const bool margins =
      std::any_of(input_.slack.begin(), input_.slack.end(), [](float slack) { return slack > 0; });
  for (std::size_t h = 0; h < separate; ++h) {
    const Hit hit = hits[h];
    const Contender &a = contenders[hit.a], &b = contenders[hit.b];
    const bool apart = onOneSide(b.plane, a.lanes) | onOneSide(a.plane, b.lanes);
    hits[undecided] = hit;
    undecided += !apart | margins;
  }
  for (std::size_t h = 0; h < undecided; ++h) {
    judgeSeparate(contenders[hits[h].a], contenders[hits[h].b]);
  }
  const bool skip = input_.options.adjacent == AdjacentPairs::kSkip;
  for (std::size_t h = 0; h < neighbours; ++h) {
    const std::uint32_t body = contenders[neighbours_[h].a].body;
    if (skip && input_.set.as_received[body] != 0) continue;
    judge(contenders[neighbours_[h].a], contenders[neighbours_[h].b]);
  }
}

void CandidateJudge::judgeSeparate(const Contender& a, const Contender& b) {
  const float margin_m = marginOf(a, b);
  KnownSides sides;
  const bool apart = sidesOf(b.plane, a.lanes, sides.a) || sidesOf(a.plane, b.lanes, sides.b);
  if (apart && margin_m == 0) return;
  state_ = {input_.options.predicates};
  report(a, b,
         separateVerdict(input_.set.posed(a.triangle), input_.set.posed(b.triangle), sides,
                         margin_m, state_));
}

// Margins do not apply: neighbours in a mesh are always near.
void CandidateJudge::judgeAdjacent(const Contender& a, const Contender& b,
                                   const SharedVertices& shared) {
  if (input_.options.adjacent == AdjacentPairs::kSkip) return;
  ++output_.candidates;
  if (restOnOneSide(b.plane, a.lanes, shared.in_a) ||
      restOnOneSide(a.plane, b.lanes, shared.in_b)) {
    return;
  }
  state_ = {input_.options.predicates};
  report(
      a, b,
      {meetBeyondShared(input_.set.posed(a.triangle), input_.set.posed(b.triangle), shared, state_),
       0});
}

void CandidateJudge::report(const Contender& a, const Contender& b, const Verdict& verdict) {
  output_.exact += state_.exact > 0;
  if (!verdict.contact) return;
  output_.undecided += state_.undecided;
  output_.contacts.push_back(
      {std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle), verdict.separation_m});
}

}  // namespace deformable_contact_monitor
