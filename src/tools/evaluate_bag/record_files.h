// Files with the records of an evaluation's parts. JSON, a line each: a head, a record of each
// cycle in their order, an end.
#pragma once

#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/bags/bag_part.h"
#include "tools/evaluate_bag/evaluation_tables.h"

namespace deformable_contact_monitor {

// Has its name once it is whole. Throws std::system_error that names it.
class RecordsWriter {
 public:
  // `origin`: what the cycles are found in and with: names, and what they say. Records of another
  // origin are refused by the name that differs. `backends`: of each run, what runs.
  RecordsWriter(const std::string& path, const BagPart& part, const nlohmann::json& origin,
                const std::vector<std::string>& backends);
  void add(const nlohmann::json& cycle);
  // `elapsed_s`: of the part.
  void finish(double elapsed_s);
  std::uint64_t cycles() const { return cycles_; }

 private:
  TableFile file_;
  std::uint64_t cycles_ = 0;
};

// All parts of an evaluation, as one. What is wrong with a file is a std::runtime_error, one line
// that names it.
class RecordsReader {
 public:
  // In any order. Refuses files that are no records, cut off, of another version or another origin,
  // parts that are missing or there twice, and those that ran on different backends.
  RecordsReader(const std::vector<std::string>& paths, const nlohmann::json& origin);

  const std::vector<std::string>& backends() const { return files_[0].backends; }

  // The next cycle's, of whatever file; null: there is none. Until the next call.
  const nlohmann::json* next();
  // The file that next() read from last.
  const std::string& path() const { return files_[file_].path; }
  [[noreturn]] void fail(const std::string& why) const;
  double elapsedS() const { return elapsed_s_; }  // of all parts

 private:
  struct File {
    std::string path;
    BagPart part;
    std::vector<std::string> backends;
  };

  void checkParts() const;
  void open();

  std::vector<File> files_;  // in the order of parts
  std::size_t file_ = 0;
  std::ifstream stream_;
  nlohmann::json cycle_;
  double elapsed_s_ = 0;
};

}  // namespace deformable_contact_monitor
