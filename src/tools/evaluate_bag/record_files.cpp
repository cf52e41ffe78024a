// Files with the records of an evaluation's parts.
#include "tools/evaluate_bag/record_files.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "evaluate_bag_records";
constexpr int kFormatVersion = 2;
constexpr const char* kEnd = "end";
constexpr std::streamoff kLongestEnd = 4096;  // [bytes] of the line

std::string lineOf(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw std::runtime_error(path + ": " + why);
}

// What is no JSON is discarded.
Json parsed(const std::string& line) { return Json::parse(line, nullptr, false); }

Json headOf(std::ifstream& file, const std::string& path) {
  std::string line;
  if (!file || !std::getline(file, line)) refuse(path, "cannot be read");
  Json head = parsed(line);
  if (!head.is_object() || head.count(kFormat) == 0) refuse(path, "no records of evaluate_bag");
  if (head[kFormat] != kFormatVersion || head.value("version", Json()) != DCM_VERSION) {
    refuse(path, "records of another version than " DCM_VERSION);
  }
  return head;
}

Json endOf(std::ifstream& file, const std::string& path) {
  file.seekg(0, std::ios::end);
  const std::streamoff size = file.tellg();
  file.seekg(std::max<std::streamoff>(0, size - kLongestEnd));
  std::string tail(static_cast<std::size_t>(std::min(size, kLongestEnd)), '\0');
  file.read(&tail[0], static_cast<std::streamsize>(tail.size()));
  if (!tail.empty() && tail.back() == '\n') {
    tail.pop_back();
    Json end = parsed(tail.substr(tail.rfind('\n') + 1));
    if (end.is_object() && end.count(kEnd) > 0) return end;
  }
  refuse(path, "cut off");
}

void checkOrigin(const std::string& path, const Json& of_file, const Json& wanted) {
  for (const auto& entry : wanted.items()) {
    if (of_file.value(entry.key(), Json()) != entry.value()) {
      refuse(path, "records of other " + entry.key());
    }
  }
}

std::string nameOf(const BagPart& part) {
  return "part " + std::to_string(part.number) + "/" + std::to_string(part.of);
}

}  // namespace

RecordsWriter::RecordsWriter(const std::string& path, const BagPart& part, const Json& origin,
                             const std::vector<std::string>& backends)
    : file_(path) {
  file_.line(lineOf({{kFormat, kFormatVersion},
                     {"version", DCM_VERSION},
                     {"part", part.number},
                     {"of", part.of},
                     {"origin", origin},
                     {"backends", backends}}));
}

void RecordsWriter::add(const Json& cycle) {
  file_.line(lineOf(cycle));
  ++cycles_;
}

void RecordsWriter::finish(double elapsed_s) {
  file_.line(lineOf({{kEnd, cycles_}, {"elapsed_s", elapsed_s}}));
  file_.finish();
}

RecordsReader::RecordsReader(const std::vector<std::string>& paths, const Json& origin) {
  const Json wanted = parsed(lineOf(origin));  // as a file has it: names need not be UTF-8
  for (const std::string& path : paths) {
    std::ifstream file(path, std::ios::binary);
    const Json head = headOf(file, path);
    const Json end = endOf(file, path);
    try {
      checkOrigin(path, head.at("origin"), wanted);
      File found;
      found.path = path;
      head.at("part").get_to(found.part.number);
      head.at("of").get_to(found.part.of);
      head.at("backends").get_to(found.backends);
      files_.push_back(std::move(found));
      elapsed_s_ += end.at("elapsed_s").get<double>();
    } catch (const Json::exception& error) {
      refuse(path, std::string("damaged: ") + error.what());
    }
  }
  std::sort(files_.begin(), files_.end(),
            [](const File& a, const File& b) { return a.part.number < b.part.number; });
  checkParts();
  open();
}

void RecordsReader::checkParts() const {
  const std::uint64_t of = files_.at(0).part.of;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    const std::string& path = files_[i].path;
    const BagPart& part = files_[i].part;
    if (part.of != of) {
      refuse(path, nameOf(part) + " does not go with " + nameOf(files_[0].part));
    }
    if (files_[i].backends != backends()) {
      refuse(path, "it ran on another backend than " + files_[0].path);
    }
    if (i > 0 && part.number == files_[i - 1].part.number) {
      refuse(path, nameOf(part) + " is there twice, also as " + files_[i - 1].path);
    }
    if (part.number != i + 1) refuse(path, "before this, " + nameOf({i + 1, of}) + " is missing");
  }
  if (files_.size() != of) {
    refuse(files_.back().path, "behind this, " + nameOf({files_.size() + 1, of}) + " is missing");
  }
}

void RecordsReader::open() {
  stream_ = std::ifstream(path(), std::ios::binary);
  headOf(stream_, path());
}

const Json* RecordsReader::next() {
  std::string line;
  while (std::getline(stream_, line)) {
    cycle_ = parsed(line);
    if (!cycle_.is_object()) fail("damaged: a line is no JSON");
    if (cycle_.count(kEnd) == 0) return &cycle_;
    if (file_ + 1 == files_.size()) return nullptr;
    ++file_;
    open();
  }
  fail("cut off");
}

void RecordsReader::fail(const std::string& why) const { refuse(path(), why); }

}  // namespace deformable_contact_monitor
