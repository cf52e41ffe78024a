// What a result is worth beside the exact one, and which settings are worth their time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "core/detector.h"

namespace deformable_contact_monitor {

using BodyPair = std::pair<BodyId, BodyId>;  // the lower first; both the same: self-contacts

struct PairCounts {
  std::uint64_t truth = 0, found = 0, common = 0;

  void add(const PairCounts& o);
  // Share of the true contacts that were found; 1 where there is none to find.
  double recall() const;
  // Share of the found contacts that are true; 1 where nothing was found.
  double precision() const;
};

// One frame; only pairs of bodies with a contact, true or found, are there.
using FrameCounts = std::map<BodyPair, PairCounts>;

// Both lists sorted, without duplicates.
FrameCounts compare(const std::vector<TrianglePair>& truth, const std::vector<TrianglePair>& found);

enum class ContactKind { kAny, kExternal, kSelf };
PairCounts total(const FrameCounts& counts, ContactKind kind);

// A rate, such as recall, over frames; frames without any contact are in it, at 1.
struct RateOverFrames {
  double sum = 0, worst = 1;
  std::size_t count = 0, worst_frame = 0;  // the first of the worst

  void add(double rate, std::size_t frame);
  double mean() const { return count == 0 ? 1 : sum / static_cast<double>(count); }
};

// How late contact is noticed, over runs of frames with true contact.
struct OnsetDelay {
  std::size_t runs = 0, missed = 0;  // missed: not noticed in any frame of the run
  std::size_t worst = 0, sum = 0;    // [frames]; of a missed run, its length

  void add(const OnsetDelay& o);
  double mean() const {
    return runs == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(runs);
  }
};

// Of one pair of bodies in a sequence of frames: whether there is contact, whether one was found.
OnsetDelay onsetDelay(const std::vector<bool>& truth, const std::vector<bool>& found);

// By how much a figure was below and above itself when it was measured again.
struct Spread {
  double below = 0, above = 0;
};

// Of a figure of all repeats, by that of each.
Spread spreadAround(double figure, const std::vector<double>& of_repeats);

// What choosing between settings looks at.
struct Worth {
  double median_ms = 0, p95_ms = 0;
  double recall = 1, precision = 1;  // in the worst frame
  bool guaranteed = false;
  Spread median_noise = {}, p95_noise = {};  // [ms]
  double strictness = 0;                     // how exact the setting is by design
};

// Exact predicates before conservative before fast ones, then by overlap.
double strictness(const Options& options);

// Whether the medians, or the p95s, of two settings cannot be told apart: what the repeats of one
// measured reaches into what those of the other did.
bool isMedianWithinNoise(const Worth& a, const Worth& b);
bool isP95WithinNoise(const Worth& a, const Worth& b);

// Whether each is on the Pareto front: none other is as good in median time, recall and precision,
// and better in one of them.
std::vector<bool> paretoFront(const std::vector<Worth>& settings);

// The setting to use: of those whose p95 is within the budget, without one of those that are
// guaranteed, the one with the best recall, then precision, then a guaranteed one, then, of those
// whose median is within noise of the fastest's, the strictest, then the fastest. One whose p95 was
// within the budget in some repeats alone goes before it if it is better in recall, precision or
// guarantee, and their p95s are within noise of each other. Nothing if there is none.
std::optional<std::size_t> choose(const std::vector<Worth>& settings,
                                  std::optional<double> budget_ms);

// The others that are not `chosen`, and whose medians are within noise of its.
std::vector<std::size_t> asFast(const std::vector<Worth>& settings, std::size_t chosen);

// By median; at least one setting.
std::size_t fastest(const std::vector<Worth>& settings);

}  // namespace deformable_contact_monitor
