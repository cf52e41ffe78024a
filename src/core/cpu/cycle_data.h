// What the CPU's stages hand to one another from `sort` on.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/common/body_groups.h"
#include "core/common/cycle_limit.h"
#include "core/common/index.h"
#include "core/common/parallel.h"
#include "core/common/stages.h"
#include "core/cpu/assign.h"
#include "core/cpu/contact_list.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"
#include "core/options.h"
#include "core/predicates/narrow_phase.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// What these stages read; made by the ones before them. Any number of threads. Hull: as in hull.h,
// here and below.
template <class Hull>
struct CycleInput {
  const Scene& scene;
  const WorkingSet& set;
  const SizeSplit& split;
  const ClusterAssignment<Hull>& assignment;
  const BodyGroups& groups;
  const std::vector<float>& slack;  // per body [scaled]
  const Options& options;
  const CycleLimit& limit = noLimit();
  ContactRoom* room = nullptr;  // for contacts; null: without bound
};

// Two triangles of the working set that boxes and filters leave to the verdict, and what is known
// of them.
template <class Hull>
struct Candidate {
  TriangleIndex a, b;
  PairFacts facts;
};

template <>
struct Candidate<MovingTriangle> {
  TriangleIndex a, b;
  SharedVertices shared;
  bool meet;  // certainly; if first times are wanted, at the start
};

// What the filters leave of many pairs.
template <class Hull>
struct Screened {
  std::vector<Candidate<Hull>> candidates;

  void clear() { candidates.clear(); }
};

template <>
struct Screened<Triangle> {
  std::vector<Candidate<Triangle>> candidates;
  // Candidates too, of which float32 says that they certainly are contacts; and how many of which
  // it says that they certainly are not.
  std::vector<std::array<TriangleIndex, 2>> meeting;
  std::uint64_t apart = 0;

  void clear() {
    candidates.clear();
    meeting.clear();
    apart = 0;
  }
};

// What these stages add to, each thread to one of its own.
template <class Hull>
struct alignas(kOwnLines) CycleOutput {
  ContactList<Hull> contacts;
  std::uint64_t interval_overlaps = 0, candidates = 0, exact = 0, undecided = 0;
  StageTimes work;  // of this thread

  CycleOutput() = default;
  explicit CycleOutput(const CycleInput<Hull>& input) : contacts(input.room) {}

  // All of another's, which must not be used any more.
  void take(CycleOutput& part) {
    contacts.take(part.contacts);
    interval_overlaps += part.interval_overlaps;
    candidates += part.candidates;
    exact += part.exact;
    undecided += part.undecided;
    work.add(part.work, 1);
  }
};

}  // namespace deformable_contact_monitor
