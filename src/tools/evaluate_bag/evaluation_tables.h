// The tables that an evaluation writes while it runs: frames.csv, links.csv, events.csv,
// distances.csv, pairs.csv and swept_pairs.csv. Each file gets its name when finish() is called.
//
// Tables are for programs and for comparing evaluations: apart from times, two evaluations of one
// bag write the same bytes.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/common/output_file.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

// frames.csv: a row for each cycle and run. Columns that end in _ms are times, and the only ones
// that differ between two evaluations of one bag. The stages are those of the first cycle; a stage
// that appears later counts in other_ms. The last columns describe the time intervals of swept
// motion.
class FramesTable {
 public:
  explicit FramesTable(const std::string& folder) : file_(folder + "/frames.csv") {}
  // `differing[i]`: whether the set of run i differs from that of the first run.
  void add(const CycleReport& cycle, const std::vector<std::unique_ptr<EvaluationRun>>& runs,
           const std::vector<bool>& differing);
  void finish() { file_.finish(); }

 private:
  // Writes the titles once the first cycle shows which stages there are.
  void writeTitle(const std::vector<std::unique_ptr<EvaluationRun>>& runs, bool swept);

  TableFile file_;
  std::vector<std::string> stages_;
  bool titled_ = false;
};

// links.csv: a row for each sequence of cycles in which a pair of bodies kept one state.
class LinksTable {
 public:
  explicit LinksTable(const std::string& folder);
  // Takes the states of run number `run` after a cycle. Call it for each run and cycle, in order.
  void add(std::size_t run, const EvaluationRun& of);
  // Writes the sequences that have not ended, and finishes the file.
  void finish();

 private:
  // A sequence of cycles in which a pair kept its state.
  struct Stretch {
    std::uint8_t state = 0;
    ros::Time from, to;
    std::uint64_t cycles = 0;
    std::uint32_t least = 0, most = 0;  // triangle pairs
  };
  using Key = std::pair<std::size_t, std::pair<std::string, std::string>>;  // run, bodies

  // Writes the row of a sequence that has ended.
  void write(const Key& key, const Stretch& stretch);

  TableFile file_;
  std::vector<std::string> runs_;  // their names
  std::map<Key, Stretch> open_;
};

// distances.csv: a row for each cycle, run and pair of two bodies that is at most its margin apart
// or UNKNOWN. A pair that a cycle checked and that has no row is farther apart than its margin.
class DistancesTable {
 public:
  explicit DistancesTable(const std::string& folder);
  // Takes the states of a run after a cycle.
  void add(const CycleReport& cycle, const EvaluationRun& run);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

// events.csv: a row for each event of each run, in the order of cycles. For PASSED, `from` is the
// beginning of the time interval.
class EventsTable {
 public:
  explicit EventsTable(const std::string& folder);
  // Takes the run's events of this cycle.
  void add(const CycleReport& cycle, const EvaluationRun& run);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

// pairs.csv: a row for each triangle pair of the first run.
class PairsTable {
 public:
  explicit PairsTable(const std::string& folder);
  void add(const CycleReport& cycle, const DetectionResult& result);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

// swept_pairs.csv: a row for each triangle pair of the first run that touches at some time of an
// interval. The interval begins at `from` and ends at `stamp`.
class SweptPairsTable {
 public:
  explicit SweptPairsTable(const std::string& folder);
  void add(const CycleReport& cycle, const RunSteps& steps);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

}  // namespace deformable_contact_monitor
