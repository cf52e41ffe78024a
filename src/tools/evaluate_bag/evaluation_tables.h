// The tables that an evaluation writes while it runs: frames.csv, links.csv, events.csv,
// distances.csv, pairs.csv and swept_pairs.csv. Each file gets its name when finish() is called.
//
// Tables are for programs and for comparing evaluations: apart from times, two evaluations of one
// bag write the same bytes.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/common/output_file.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

class EvaluationTables {
 public:
  using Runs = std::vector<std::unique_ptr<EvaluationRun>>;

  // Makes the tables in a folder. `with_pairs`: pairs.csv and, in swept motion, swept_pairs.csv
  // too. A state holds for max_age_s [s]. Throws std::system_error that names a file, as the other
  // functions do.
  EvaluationTables(const std::string& folder, bool with_pairs, bool swept, double max_age_s);

  // Writes the rows of a cycle that all runs have evaluated. `differing[i]`: whether the set of run
  // i differs from that of the first run.
  void add(const CycleReport& cycle, const Runs& runs, const std::vector<bool>& differing);

  // Writes the rows that wait for the end, and finishes all files.
  void finish();

 private:
  // A sequence of cycles in which a pair of bodies kept its state.
  struct Stretch {
    std::uint8_t state = 0;
    ros::Time from, to;
    std::uint64_t cycles = 0;
    std::uint32_t least = 0, most = 0;  // triangle pairs
  };
  using StretchKey = std::pair<std::size_t, std::pair<std::string, std::string>>;  // run, bodies

  // frames.csv: a row for each cycle and run. Columns that end in _ms are times, and the only ones
  // that differ between two evaluations of one bag. The stages are those of the first cycle; a
  // stage that appears later counts in other_ms. The last columns describe the time intervals of
  // swept motion.
  void addFrame(const CycleReport& cycle, const EvaluationRun& run, bool differs);
  void writeFrameTitle(const Runs& runs, bool swept);
  // links.csv: a row for each sequence of cycles in which a pair of bodies kept one state. `from_s`
  // and `to_s` count from the first cycle on, as the times of expectations do. A gap between cycles
  // in which the state grew too old has a row without cycles.
  void addLinks(std::size_t number, const EvaluationRun& run);
  void writeLink(const StretchKey& key, const Stretch& stretch);
  // Returns the time after the first cycle [s].
  std::string sinceStart(const ros::Time& time) const;
  // events.csv: a row for each event of each run, in the order of cycles. For PASSED, `from` is the
  // beginning of the time interval.
  void addEvents(const CycleReport& cycle, const EvaluationRun& run);
  // distances.csv: a row for each cycle, run and pair of two bodies that is at most its margin
  // apart or UNKNOWN. A pair that a cycle checked and that has no row is farther apart.
  void addDistances(const CycleReport& cycle, const EvaluationRun& run);
  // pairs.csv: a row for each triangle pair of the first run.
  void addPairs(const CycleReport& cycle, const DetectionResult& result);
  // swept_pairs.csv: a row for each triangle pair of the first run that touches at some time of an
  // interval. The interval begins at `from` and ends at `stamp`.
  void addSweptPairs(const CycleReport& cycle, const RunSteps& steps);

  const double max_age_s_;
  TableFile frames_, links_, events_, distances_;
  std::optional<TableFile> pairs_, swept_pairs_;
  std::vector<std::string> stages_;  // of the title of frames.csv
  bool titled_ = false;
  ros::Time start_;                // stamp of the first cycle
  std::vector<std::string> runs_;  // their names
  std::map<StretchKey, Stretch> open_;
};

}  // namespace deformable_contact_monitor
