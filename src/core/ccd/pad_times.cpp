// The pads are those of the detection, so each triangle pair that comes within them earlier was
// seen by the detector too. The search for the time is that of predicates/swept_pad.h.
#include "core/ccd/pad_times.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/parallel.h"
#include "core/common/posed_body.h"
#include "core/predicates/swept_pad.h"
#include "core/rules/margins.h"

namespace deformable_contact_monitor {
namespace {

MovingTriangle movingTriangle(const Body& body, std::uint32_t t) {
  return {PosedBody::earlier(body).triangle(t), PosedBody(body).triangle(t)};
}

// Returns when the triangles of a contact may come within the pad, at most `low`.
float earliest(const Scene& scene, const TrianglePair& pair, float pad_m, float low) {
  const Body &a = scene.body(pair.body_a), &b = scene.body(pair.body_b);
  if (a.device_vertices || b.device_vertices) return 0;
  const PadVerdict verdict =
      withinPad(movingTriangle(a, pair.triangle_a), movingTriangle(b, pair.triangle_b), pad_m);
  return verdict.may_touch ? std::min(low, verdict.first_low) : low;
}

}  // namespace

void includePads(const Scene& scene, const Options& options, DetectionResult* result) {
  if (!scene.anyPad()) return;
  std::vector<std::size_t> later;  // contacts that have pads and do not begin with the interval
  const auto padOf = [&scene](const TrianglePair& pair) {
    return pairPad(scene.body(pair.body_a).pad_m, scene.body(pair.body_b).pad_m);
  };
  for (std::size_t i = 0; i < result->first_times.size(); ++i) {
    const TrianglePair& pair = result->contacts[i];
    if (pair.body_a == pair.body_b || result->within_pad[i] != 0) continue;
    if (result->first_times[i].low > 0 && padOf(pair) > 0) later.push_back(i);
  }
  const CycleLimit limit(options.limits);
  const auto move = [&](std::size_t i) {
    float& low = result->first_times[i].low;
    low = limit.over() ? 0 : earliest(scene, result->contacts[i], padOf(result->contacts[i]), low);
  };
  constexpr std::size_t kFew = 64, kBlock = 16;  // a contact takes some 10 us
  if (later.size() <= kFew || options.threads == 1) {
    for (const std::size_t i : later) move(i);
    return;
  }
  tbb::task_arena arena(options.threads == 0 ? tbb::task_arena::automatic : options.threads);
  arena.execute([&] {
    parallelBlocks(later.size(), kBlock, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) move(later[k]);
    });
  });
}

}  // namespace deformable_contact_monitor
