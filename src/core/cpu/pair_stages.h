// Declares the data that the CPU's stages from `sort` on exchange, and the two of these stages that
// keep no state between cycles: `oversized` and `narrow_phase`.
//
// Every thread reads one CycleInput and writes to a CycleOutput of its own; the outputs are joined
// at the end of a stage. Results do not depend on the number of threads, because work is divided by
// the scene alone and contacts are sorted afterwards.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/common/scene_queries.h"
#include "core/common/stages.h"
#include "core/cpu/assign.h"
#include "core/cpu/contact_list.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/options.h"
#include "core/predicates/narrow_phase.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Everything that these stages read. Earlier stages filled it; any number of threads may read it at
// the same time.
template <class Primitive>
struct CycleInput {
  const Scene& scene;
  const WorkingSet& set;
  const SizeSplit& split;
  const ClusterAssignment<Primitive>& assignment;
  const BodyGroups& groups;
  const std::vector<float>& slack;  // per body [scaled]
  const Options& options;
  const CycleLimit& limit = noLimit();
  ContactRoom* room = nullptr;  // bounds the memory of contacts; null: no bound
};

// A pair of triangles of the working set that boxes and filters could not decide, with what they
// found out about it.
template <class Primitive>
struct Candidate {
  TriangleIndex a, b;
  PairFacts facts;
};

template <>
struct Candidate<MovingTriangle> {
  TriangleIndex a, b;
  SharedVertices shared;
  bool meet;  // certain contact; if first times are wanted, one at the start
};

// The outcome of filtering many pairs: the candidates that the narrow phase has to decide.
template <class Primitive>
struct FilteredPairs {
  std::vector<Candidate<Primitive>> candidates;

  void clear() { candidates.clear(); }
};

template <>
struct FilteredPairs<Triangle> {
  std::vector<Candidate<Triangle>> candidates;
  // Pairs that float32 arithmetic has decided with certainty: contacts (`meeting`), and the number
  // of pairs that are no contacts (`apart`). The narrow phase counts both as candidates.
  std::vector<std::array<TriangleIndex, 2>> meeting;
  std::uint64_t apart = 0;

  void clear() {
    candidates.clear();
    meeting.clear();
    apart = 0;
  }
};

// The results of these stages. Each thread adds to one of its own.
template <class Primitive>
struct alignas(kOwnLines) CycleOutput {
  ContactList<Primitive> contacts;
  Counters counters;  // of pairs
  StageTimes work;    // of this thread

  CycleOutput() = default;
  explicit CycleOutput(const CycleInput<Primitive>& input) : contacts(input.room) {}

  // Moves everything from `part` to here. `part` must not be used afterwards.
  void take(CycleOutput& part) {
    contacts.take(part.contacts);
    counters.addWork(part.counters);
    work.add(part.work, 1);
  }
};

// Stage `narrow_phase` (narrow_phase.cpp): counts the candidates, and adds those that are contacts
// to `output`. It returns early once the limit is over.
void narrowPhase(const CycleInput<Triangle>& input, const FilteredPairs<Triangle>& filtered,
                 CycleOutput<Triangle>& output);

// The same during a time interval; adds first times too if options.first_times.
void narrowPhase(const CycleInput<MovingTriangle>& input,
                 const FilteredPairs<MovingTriangle>& filtered,
                 CycleOutput<MovingTriangle>& output);

// Stage `oversized` (oversized.cpp): finds and decides all pairs with an oversized triangle, on
// several threads, and adds the contacts to `output`. It returns early once the limit is over.
template <class Primitive>
void sweepOversized(const CycleInput<Primitive>& input, CycleOutput<Primitive>& output);

}  // namespace deformable_contact_monitor
