// The tables that an evaluation writes while it goes: frames.csv, links.csv, pairs.csv.
#include "tools/evaluate_bag/evaluation_tables.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "tools/bags/stamp_text.h"
#include "tools/common/csv_field.h"

namespace deformable_contact_monitor {
namespace {

std::string milliseconds(double ms) {
  char text[32];
  std::snprintf(text, sizeof text, ",%.4f", ms);
  return text;
}

const char* nameOf(std::uint8_t state) {
  constexpr const char* kNames[] = {"NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED"};
  return kNames[state];
}

// The first few bodies that were left out and why; links.csv has them all.
std::string skipped(const CycleReport& cycle) {
  constexpr std::size_t kShown = 2;
  std::string text;
  std::size_t count = 0;
  for (const BodyStatus& body : cycle.bodies) {
    if (body.unknown_because.empty() || ++count > kShown) continue;
    text += (text.empty() ? "" : "; ") + body.name + ": " + body.unknown_because;
  }
  return count > kShown ? text + "; and " + std::to_string(count - kShown) + " more" : text;
}

std::string objects(const CycleReport& cycle) {
  std::string text;
  for (const BodyStatus& body : cycle.bodies) {
    if (body.kind != BodyKind::kDeformable || body.stamp != cycle.header.stamp) continue;
    text += (text.empty() ? "" : " ") + body.name;
  }
  return text;
}

}  // namespace

TableFile::TableFile(const std::string& path)
    : path_(path), part_(path), file_(part_.writtenAs(), std::ios::binary) {
  if (!file_) fail();
}

void TableFile::line(const std::string& text) {
  file_ << text << '\n';
  if (!file_) fail();
}

void TableFile::finish() {
  file_.close();
  if (!file_) fail();
  part_.finish();
}

void TableFile::fail() const {
  throw std::system_error(errno, std::generic_category(), path_ + ": cannot be written");
}

void FramesTable::writeTitle(const std::vector<std::unique_ptr<EvaluationRun>>& runs, bool swept) {
  std::string title =
      "cycle,stamp,objects,run,backend,triangles,rejected,pairs,undecided,complete,differs,skipped,"
      "detect_ms,round_trip_ms";
  for (const auto& run : runs) {
    for (const auto& [name, ms] : run->stages_ms) {
      if (std::find(stages_.begin(), stages_.end(), name) != stages_.end()) continue;
      stages_.push_back(name);
      title += "," + name + "_ms";
    }
  }
  file_.line(title + ",other_ms" + (swept ? ",swept_pairs,swept_complete,swept_ms" : ""));
}

void FramesTable::add(const CycleReport& cycle,
                      const std::vector<std::unique_ptr<EvaluationRun>>& runs,
                      const std::vector<bool>& differing) {
  const bool swept = cycle.motion == Motion::kSwept;
  if (!titled_) writeTitle(runs, swept);
  titled_ = true;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const EvaluationRun& run = *runs[i];
    const DetectionResult& result = *run.result;
    std::string row = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) + "," +
                      csvField(objects(cycle)) + "," + csvField(run.name()) + "," +
                      run.source->backend() + "," + std::to_string(result.counters.triangles) +
                      "," + std::to_string(result.counters.rejected) + "," +
                      std::to_string(result.contacts.size() + result.left_out) + "," +
                      std::to_string(result.counters.undecided) + "," +
                      (isComplete(cycle, result) ? "yes" : "no") + "," +
                      (differing[i] ? "yes" : "no") + "," + csvField(skipped(cycle)) +
                      milliseconds(result.detect_ms) + milliseconds(result.round_trip_ms);
    double other_ms = 0;
    for (const std::string& stage : stages_) {
      double ms = 0;
      for (const auto& [name, took_ms] : result.stages_ms) ms += name == stage ? took_ms : 0;
      row += milliseconds(ms);
      other_ms -= ms;
    }
    for (const auto& [name, took_ms] : result.stages_ms) other_ms += took_ms;
    row += milliseconds(std::max(other_ms, 0.0));
    if (swept) {
      row += "," + std::to_string(run.steps.pairsOfCycle()) +
             (run.steps.isCycleComplete(cycle) ? ",yes" : ",no") +
             milliseconds(run.steps.msOfCycle());
    }
    file_.line(row);
  }
}

LinksTable::LinksTable(const std::string& folder) : file_(folder + "/links.csv") {
  file_.line("run,body_a,body_b,state,from,to,cycles,least_pairs,most_pairs");
}

void LinksTable::add(std::size_t run, const EvaluationRun& of) {
  if (runs_.size() <= run) runs_.resize(run + 1);
  runs_[run] = of.name();
  const ros::Time& stamp = of.states.header.stamp;
  for (const ContactState& state : of.states.states) {
    if (state.stamp != stamp) continue;  // the cycle did not look at it
    const Key key{run, {state.body_a, state.body_b}};
    const auto found = open_.find(key);
    if (found != open_.end() && found->second.state == state.state) {
      Stretch& stretch = found->second;
      stretch.to = stamp;
      ++stretch.cycles;
      stretch.least = std::min(stretch.least, state.pair_count);
      stretch.most = std::max(stretch.most, state.pair_count);
      continue;
    }
    if (found != open_.end()) write(key, found->second);
    open_[key] = {state.state, stamp, stamp, 1, state.pair_count, state.pair_count};
  }
}

void LinksTable::write(const Key& key, const Stretch& stretch) {
  file_.line(csvField(runs_[key.first]) + "," + csvField(key.second.first) + "," +
             csvField(key.second.second) + "," + nameOf(stretch.state) + "," +
             stampText(stretch.from) + "," + stampText(stretch.to) + "," +
             std::to_string(stretch.cycles) + "," + std::to_string(stretch.least) + "," +
             std::to_string(stretch.most));
}

void LinksTable::finish() {
  for (const auto& [key, stretch] : open_) write(key, stretch);
  open_.clear();
  file_.finish();
}

PairsTable::PairsTable(const std::string& folder) : file_(folder + "/pairs.csv") {
  file_.line("cycle,stamp,body_a,triangle_a,body_b,triangle_b");
}

void PairsTable::add(const CycleReport& cycle, const DetectionResult& result) {
  const std::string start = std::to_string(cycle.cycle) + "," + stampText(cycle.header.stamp) + ",";
  for (const TrianglePair& pair : result.contacts) {
    file_.line(start + csvField(cycle.bodies[pair.body_a].name) + "," +
               std::to_string(pair.triangle_a) + "," + csvField(cycle.bodies[pair.body_b].name) +
               "," + std::to_string(pair.triangle_b));
  }
}

}  // namespace deformable_contact_monitor
