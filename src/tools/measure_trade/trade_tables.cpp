// The tables that measure_trade writes.
#include <algorithm>

#include "tools/common/csv_field.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

class Row {
 public:
  Row& text(const std::string& words) {
    line_ += (line_.empty() ? "" : ",") + csvField(words);
    return *this;
  }
  Row& number(double value) { return text(numberText(value)); }
  Row& number(float value) { return text(numberText(value)); }
  Row& count(std::uint64_t value) { return text(std::to_string(value)); }
  Row& flag(bool value) { return text(value ? "true" : "false"); }
  std::string line() const { return line_ + "\n"; }

 private:
  std::string line_;
};

constexpr const char* kSettingColumns =
    "backend,predicates,overlap,clusters,fuzzifier,iterations,refresh_period";
constexpr const char* kOnsetColumns = "onset_runs,onset_missed,onset_delay_mean,onset_delay_worst";

void addSetting(const Setting& setting, Row* row) {
  const Options& options = setting.options;
  row->text(setting.backend).text(toString(options.predicates)).number(options.overlap);
  row->text(std::to_string(options.clusters)).number(options.fuzzifier);
  row->text(std::to_string(options.iterations)).text(std::to_string(options.refresh_period));
}

void addRecall(const RateOverFrames& recall, bool counts, const ExactResults& exact, Row* row) {
  if (!counts) {
    row->text("").text("").text("");
    return;
  }
  row->number(recall.mean()).number(recall.worst);
  row->text(recall.worst < 1 ? exact.labels.at(recall.worst_frame) : "");
}

// Of all cycles, and of what the repeats came to.
void addNoise(const Measurement& m, Row* row) {
  const Worth worth = m.worth();
  row->number(percentile(m.round_trip_ms, 0.1)).number(percentile(m.round_trip_ms, 0.9));
  row->number(worth.median_ms - worth.median_noise.below);
  row->number(worth.median_ms + worth.median_noise.above);
  row->number(worth.p95_ms - worth.p95_noise.below);
  row->number(worth.p95_ms + worth.p95_noise.above);
}

void addOnset(const OnsetDelay& onset, Row* row) {
  row->count(onset.runs).count(onset.missed).number(onset.mean()).count(onset.worst);
}

double ratio(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

void addWork(const Measurement& m, Row* row) {
  const Counters& work = m.work;
  const std::uint64_t swept = work.clustered + work.large;
  const auto cycles = m.round_trip_ms.size();
  row->number(ratio(work.undecided, cycles)).number(ratio(work.clusters, cycles));
  row->number(ratio(work.candidates, swept)).number(ratio(work.cluster_entries, work.clustered));
  row->number(ratio(work.interval_overlaps, swept)).number(ratio(work.exact, work.candidates));
}

}  // namespace

std::string settingsCsv(const TradeResults& results) {
  bool external = false, self = false;
  for (const BodyPair& bodies : results.exact.bodies) {
    (bodies.first == bodies.second ? self : external) = true;
  }
  std::string text = std::string(kSettingColumns) +
                     ",median_ms,p95_ms,least_ms,p10_ms,p90_ms,median_low_ms,median_high_ms,"
                     "p95_low_ms,p95_high_ms,recall_external_mean,recall_external_worst,"
                     "recall_external_worst_frame,recall_self_mean,recall_self_worst,"
                     "recall_self_worst_frame,precision_mean,precision_worst,undecided,"
                     "clusters_used,candidates_per_triangle,clusters_per_triangle,"
                     "interval_overlaps_per_triangle,exact_share," +
                     kOnsetColumns + ",guaranteed,pareto_front\n";
  for (std::size_t i = 0; i < results.measurements.size(); ++i) {
    const Measurement& m = results.measurements[i];
    Row row;
    addSetting(m.setting, &row);
    row.number(median(m.round_trip_ms)).number(percentile(m.round_trip_ms, 0.95));
    row.number(*std::min_element(m.round_trip_ms.begin(), m.round_trip_ms.end()));
    addNoise(m, &row);
    addRecall(m.external, external, results.exact, &row);
    addRecall(m.self, self, results.exact, &row);
    row.number(m.precision.mean()).number(m.precision.worst);
    addWork(m, &row);
    addOnset(m.onset, &row);
    row.flag(m.guaranteed).flag(results.front[i]);
    text += row.line();
  }
  return text;
}

std::string linksCsv(const TradeResults& results, const FrameSource& frames) {
  std::string text = std::string(kSettingColumns) +
                     ",link,object,recall_mean,recall_worst,recall_worst_frame," + kOnsetColumns +
                     "\n";
  const auto name = [&frames](BodyId body) { return frames.scene().body(body).name; };
  for (const Measurement& m : results.measurements) {
    for (const auto& [bodies, of_bodies] : m.bodies) {
      const bool first_deforms = frames.isDeformable(bodies.first);
      Row row;
      addSetting(m.setting, &row);
      row.text(name(first_deforms ? bodies.second : bodies.first));
      row.text(name(first_deforms ? bodies.first : bodies.second));
      addRecall(of_bodies.recall, true, results.exact, &row);
      addOnset(of_bodies.onset, &row);
      text += row.line();
    }
  }
  return text;
}

}  // namespace deformable_contact_monitor
