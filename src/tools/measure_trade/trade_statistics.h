// Compares results with the exact ones, and decides which settings are worth their time.
//
// Everything here is arithmetic on counts and times, so it can be tested without a detector.
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

// Returns the share of a part; 1 if there is nothing to count.
double share(std::uint64_t part, std::uint64_t whole);

// Counts of pairs: true ones, found ones, and found ones that are true.
struct PairCounts {
  std::uint64_t truth = 0, found = 0, common = 0;

  // Adds the counts of other pairs.
  void add(const PairCounts& o);
  // Returns how many true contacts were not found, and how many were found that are not true.
  std::uint64_t lost() const { return truth - common; }
  std::uint64_t added() const { return found - common; }
  // Returns the share of the true contacts that were found; 1 if there is none.
  double recall() const { return share(common, truth); }
  // Returns the share of the found contacts that are true; 1 if nothing was found.
  double precision() const { return share(common, found); }
};

// The counts of one frame. It holds only pairs of bodies with a true or found contact.
using FrameCounts = std::map<BodyPair, PairCounts>;

// Compares two lists, which must be sorted and without duplicates.
FrameCounts compare(const std::vector<TrianglePair>& truth, const std::vector<TrianglePair>& found);

// Says which contacts are counted: all, those of two bodies, or self-contacts.
enum class ContactKind { kAny, kExternal, kSelf };
// Sums the counts of all pairs of bodies of a kind.
PairCounts total(const FrameCounts& counts, ContactKind kind);

// A rate over frames, such as recall. Frames without any contact count as 1.
struct RateOverFrames {
  double sum = 0, worst = 1;
  std::size_t count = 0, worst_frame = 0;  // the first frame with the worst rate

  // Adds the rate of a frame.
  void add(double rate, std::size_t frame);
  // Returns the mean; 1 without frames.
  double mean() const { return count == 0 ? 1 : sum / static_cast<double>(count); }
};

// The delay until a contact is found, over sequences of frames with true contact ("runs").
struct OnsetDelay {
  std::size_t runs = 0, missed = 0;  // missed: not found in any frame of the run
  std::size_t worst = 0, sum = 0;    // [frames]; a missed run counts with its length

  // Adds the delays of another pair of bodies or pass.
  void add(const OnsetDelay& o);
  // Returns the mean delay [frames]; 0 without runs.
  double mean() const {
    return runs == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(runs);
  }
};

// Returns the delays of one pair of bodies. The lists say for each frame whether there is a
// contact, and whether one was found.
OnsetDelay onsetDelay(const std::vector<bool>& truth, const std::vector<bool>& found);

// Says how far a figure went below and above its value in repeated measurements.
struct Spread {
  double below = 0, above = 0;
};

// Returns the spread of the repeats' figures around the figure of all repeats together.
Spread spreadAround(double figure, const std::vector<double>& of_repeats);

// The criteria by which a setting is chosen.
struct Worth {
  double median_ms = 0, p95_ms = 0;
  double recall = 1, precision = 1;  // of the worst frame
  bool guaranteed = false;
  Spread median_noise = {}, p95_noise = {};  // [ms]
  double strictness = 0;                     // strictness() of its options
};

// Returns how exact a setting is by design: by predicates (exact, conservative), then by overlap.
double strictness(const Options& options);

// Return true if the medians, or the 95th percentiles, of two settings cannot be told apart because
// the ranges of their repeats overlap.
bool isMedianWithinNoise(const Worth& a, const Worth& b);
bool isP95WithinNoise(const Worth& a, const Worth& b);

// Returns for each setting whether it is on the Pareto front: no other is as good in median time,
// recall and precision, and better in one of them.
std::vector<bool> paretoFront(const std::vector<Worth>& settings);

// Returns the index of the setting to use, or nothing if there is none. Candidates are the settings
// whose 95th percentile keeps the budget; without a budget, the guaranteed ones. Among them, these
// criteria decide in this order:
// 1. recall; 2. precision; 3. a guarantee;
// 4. the strictest of those whose median is within noise of the fastest's; 5. the fastest.
// A setting that keeps the budget only in some repeats is preferred if it is better in recall,
// precision or guarantee, and if the two 95th percentiles are within noise of each other.
std::optional<std::size_t> choose(const std::vector<Worth>& settings,
                                  std::optional<double> budget_ms);

// Returns the other settings whose medians are within noise of the chosen one's.
std::vector<std::size_t> asFast(const std::vector<Worth>& settings, std::size_t chosen);

// Returns the setting with the least median. There must be at least one.
std::size_t fastest(const std::vector<Worth>& settings);

}  // namespace deformable_contact_monitor
