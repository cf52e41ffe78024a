// The tables that an evaluation writes while it goes: frames.csv, links.csv, pairs.csv.
#pragma once

#include <cstdint>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tools/common/part_file.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {

// A file of lines, which has its name from finish() on. Throws std::system_error that names it.
class TableFile {
 public:
  explicit TableFile(const std::string& path);
  void line(const std::string& text);
  // All of it is with the system when this returns. Once, and nothing after it.
  void finish();

 private:
  [[noreturn]] void fail() const;

  std::string path_;
  PartFile part_;
  std::ofstream file_;
};

// A row for each cycle and run. Columns that end in _ms are times, and all that differs between two
// evaluations of one bag; the stages' are those of the first cycle, later ones are in other_ms. In
// swept motion what the steps found comes behind them.
class FramesTable {
 public:
  explicit FramesTable(const std::string& folder) : file_(folder + "/frames.csv") {}
  // `differing[i]`: whether run i's set differs from the first's.
  void add(const CycleReport& cycle, const std::vector<std::unique_ptr<EvaluationRun>>& runs,
           const std::vector<bool>& differing);
  void finish() { file_.finish(); }

 private:
  void writeTitle(const std::vector<std::unique_ptr<EvaluationRun>>& runs, bool swept);

  TableFile file_;
  std::vector<std::string> stages_;
  bool titled_ = false;
};

// A row for each stretch of cycles in which a pair of bodies kept one state.
class LinksTable {
 public:
  explicit LinksTable(const std::string& folder);
  void add(std::size_t run, const EvaluationRun& of);
  // Ends the stretches that are still open.
  void finish();

 private:
  struct Stretch {
    std::uint8_t state = 0;
    ros::Time from, to;
    std::uint64_t cycles = 0;
    std::uint32_t least = 0, most = 0;  // pairs
  };
  using Key = std::pair<std::size_t, std::pair<std::string, std::string>>;  // run, bodies

  void write(const Key& key, const Stretch& stretch);

  TableFile file_;
  std::vector<std::string> runs_;  // their names
  std::map<Key, Stretch> open_;
};

// A row for each triangle pair of the first run.
class PairsTable {
 public:
  explicit PairsTable(const std::string& folder);
  void add(const CycleReport& cycle, const DetectionResult& result);
  void finish() { file_.finish(); }

 private:
  TableFile file_;
};

}  // namespace deformable_contact_monitor
