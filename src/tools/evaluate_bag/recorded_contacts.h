// The contacts of an evaluation's cycles, as records of its parts have them.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/bags/bag_contents.h"
#include "tools/bags/bag_setup.h"
#include "tools/evaluate_bag/contact_source.h"
#include "tools/evaluate_bag/cycle_records.h"
#include "tools/evaluate_bag/evaluation_run.h"
#include "tools/evaluate_bag/evaluation_runs.h"
#include "tools/evaluate_bag/record_files.h"

namespace deformable_contact_monitor {

// RecordsWriter's origin: the same where the same contacts would be found.
nlohmann::json originOf(const std::vector<std::string>& bags, const BagContents& contents,
                        const BagSetup& setup, const std::vector<RunSettings>& runs);

// What each run finds in a cycle; `scene` is the report's. For RecordsWriter.
nlohmann::json recordOf(const std::vector<std::unique_ptr<EvaluationRun>>& runs, Scene* scene,
                        CycleReport* cycle);

// All runs' records, in the order of cycles.
class RecordedCycles {
 public:
  explicit RecordedCycles(RecordsReader reader) : reader_(std::move(reader)) {}

  const std::vector<std::string>& backends() const { return reader_.backends(); }

  // Reads what a run found in the cycle that is next, or was asked for last. Throws
  // std::runtime_error, one line, if the records have another cycle there, or nothing that fits.
  void read(std::size_t run, CycleReport* cycle, RecordedCycle* into);

  // After the last cycle. Throws as read() if the records go on.
  void requireEnd();

  double elapsedS() const { return reader_.elapsedS(); }

 private:
  void goTo(const CycleReport& cycle);

  RecordsReader reader_;
  const nlohmann::json* current_ = nullptr;
  std::uint64_t cycle_ = 0;  // of current_; 0: none
};

// Those of one run.
class RecordedContacts : public ContactSource {
 public:
  RecordedContacts(std::shared_ptr<RecordedCycles> cycles, std::size_t run)
      : cycles_(std::move(cycles)), run_(run) {}

  std::string backend() const override { return cycles_->backends().at(run_); }
  void find(Scene* /*scene*/, CycleReport* cycle) override { cycles_->read(run_, cycle, &cycle_); }

 private:
  const std::shared_ptr<RecordedCycles> cycles_;
  const std::size_t run_;
  RecordedCycle cycle_;
};

}  // namespace deformable_contact_monitor
