#include "core/cpu/judge.h"

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

float CandidateJudge::marginOf(const Contender& a, const Contender& b) const {
  return std::max(input_.scene.body(a.body).margin_m, input_.scene.body(b.body).margin_m);
}

void CandidateJudge::judge(const Contender& a, const Contender& b) {
  if (sharedBits(a.vertex_id, b.vertex_id) != 0) {
    judgeAdjacent(a, b);
  } else {
    judgeSeparate(a, b);
  }
}

void CandidateJudge::judge(const std::vector<Contender>& contenders, Hit* hits, std::size_t count) {
  neighbours_.resize(count);
  std::size_t neighbours = 0, separate = 0, undecided = 0;
  for (std::size_t h = 0; h < count; ++h) {
    const Hit hit = hits[h];
    const Contender &a = contenders[hit.a], &b = contenders[hit.b];
    const bool neighbour = sharedBits(a.vertex_id, b.vertex_id) != 0;
    neighbours_[neighbours] = hit;
    neighbours += neighbour;
    hits[separate] = hit;
    separate += !neighbour;
  }
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
  for (std::size_t h = 0; h < neighbours; ++h) {
    judgeAdjacent(contenders[neighbours_[h].a], contenders[neighbours_[h].b]);
  }
}

void CandidateJudge::judgeSeparate(const Contender& a, const Contender& b) {
  const float margin_m = marginOf(a, b);
  KnownSides sides;
  const bool apart = sidesOf(b.plane, a.lanes, sides.a) || sidesOf(a.plane, b.lanes, sides.b);
  if (apart && margin_m == 0) return;
  ++output_.candidates;
  state_ = {input_.options.predicates};
  report(a, b,
         separateVerdict(input_.set.posed(a.triangle), input_.set.posed(b.triangle), sides,
                         margin_m, state_));
}

// Margins do not apply: neighbours in a mesh are always near.
void CandidateJudge::judgeAdjacent(const Contender& a, const Contender& b) {
  if (input_.options.adjacent == AdjacentPairs::kSkip) return;
  const int in_a = sharedBits(a.vertex_id, b.vertex_id);
  const int in_b = sharedBits(b.vertex_id, a.vertex_id);
  if (restOnOneSide(b.plane, a.lanes, in_a) || restOnOneSide(a.plane, b.lanes, in_b)) return;
  ++output_.candidates;
  SharedVertices shared;
  shared.any = true;
  for (int i = 0; i < 3; ++i) {
    shared.in_a[i] = (in_a >> i & 1) != 0;
    shared.in_b[i] = (in_b >> i & 1) != 0;
  }
  state_ = {input_.options.predicates};
  report(
      a, b,
      adjacentVerdict(input_.set.posed(a.triangle), input_.set.posed(b.triangle), shared, state_));
}

void CandidateJudge::report(const Contender& a, const Contender& b, const Verdict& verdict) {
  output_.exact += state_.exact > 0;
  if (!verdict.contact) return;
  output_.undecided += state_.undecided;
  output_.contacts.push_back(
      {std::min(a.triangle, b.triangle), std::max(a.triangle, b.triangle), verdict.separation_m});
}

}  // namespace deformable_contact_monitor
