// Writes the results of measure_trade --swept.
#include "tools/measure_trade/motion_report.h"

#include <nlohmann/json.hpp>

#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

// Returns the level's name in tables.
const char* nameOf(MotionLevel level) {
  return level == MotionLevel::kBodies ? "bodies" : "triangles";
}

// Returns the distance of the frames that a way checks.
std::size_t everyOf(const MotionResults& found, const MotionWay& way) {
  return way.kept_alone ? found.every : 1;
}

// Returns the times of all detections of a way [ms].
std::vector<double> times(const MotionResults& found, const MotionWay& way) {
  std::vector<double> ms;
  if (way.motion == Motion::kSwept) {
    for (const MotionStep& step : way.kept_alone ? found.kept_steps : found.steps) {
      ms.push_back(step.round_trip_ms);
    }
    return ms;
  }
  if (!way.kept_alone) return found.instant_ms;
  for (const std::size_t frame : keptFrames(found.labels.size(), found.every)) {
    ms.push_back(found.instant_ms[frame]);
  }
  return ms;
}

// Returns a row of motions.csv.
TableRow row(const MotionResults& found, const MotionCounts& counts, std::size_t way) {
  const MotionWay& look = waysToLook()[way];
  const auto& [contacts, onsets] = counts.ways[way];
  const TimeError error = timeError(counts.truth, onsets);
  const std::vector<double> ms = times(found, look);
  return {{"level", nameOf(counts.level)},
          {"motion", toString(look.motion)},
          {"every", everyOf(found, look)},
          {"cycles", ms.size()},
          {"contacts", contacts.truth},
          {"contacts_lost", contacts.lost()},
          {"contacts_added", contacts.added()},
          {"onsets", counts.truth.size()},
          {"onsets_lost", onsets.lost()},
          {"onsets_added", onsets.added},
          {"time_error_mean", error.mean},
          {"time_error_worst", error.worst},
          {"median_ms", median(ms)}};
}

std::vector<TableRow> rows(const MotionResults& found, const std::vector<MotionCounts>& levels) {
  std::vector<TableRow> rows;
  for (const MotionCounts& counts : levels) {
    for (std::size_t way = 0; way < counts.ways.size(); ++way) {
      rows.push_back(row(found, counts, way));
    }
  }
  return rows;
}

// Adds the times of an onset to a row; empty fields if it was not found.
void addOnset(const std::optional<Onset>& onset, bool swept, std::string* line) {
  *line += "," + (onset ? numberText(onset->low) : "");
  if (swept) *line += "," + (onset ? numberText(onset->high) : "");
}

// Returns the names of the bodies, and the triangles at the level of triangles.
std::string bodiesOf(const Onset& onset, MotionLevel level, const Scene& scene) {
  const TrianglePair& pair = onset.pair;
  const auto triangle = [level](std::uint32_t number) {
    return level == MotionLevel::kTriangles ? std::to_string(number) : std::string();
  };
  return csvField(scene.body(pair.body_a).name) + "," + triangle(pair.triangle_a) + "," +
         csvField(scene.body(pair.body_b).name) + "," + triangle(pair.triangle_b);
}

// Returns for example "loses 2 of 9 contacts".
std::string lossText(std::uint64_t lost, std::uint64_t of, const char* what) {
  return std::to_string(lost) + " of " + std::to_string(of) + " " + what;
}

}  // namespace

// The true onsets are computed once for all ways.
MotionCounts countMotions(const MotionResults& found, MotionLevel level) {
  MotionCounts counts;
  counts.level = level;
  counts.truth = trueOnsets(found, level);
  for (const MotionWay& way : waysToLook()) {
    counts.ways.push_back(
        {lostContacts(found, way, level), findOnsets(found, way, level, counts.truth)});
  }
  return counts;
}

std::string motionsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels) {
  return csvTable(rows(found, levels));
}

// `after_frame` is the frame at which the onset's interval begins. Ways by instant motion have one
// time, swept ones two.
std::string onsetsCsv(const MotionResults& found, const std::vector<MotionCounts>& levels,
                      const FrameSource& frames) {
  std::string text =
      "level,body_a,triangle_a,body_b,triangle_b,after_frame,first_low,first_high,instant,"
      "instant_kept,swept_kept_low,swept_kept_high\n";
  for (const MotionCounts& counts : levels) {
    for (std::size_t i = 0; i < counts.truth.size(); ++i) {
      const Onset& onset = counts.truth[i];
      std::string line = std::string(nameOf(counts.level)) + "," +
                         bodiesOf(onset, counts.level, frames.scene()) + "," +
                         csvField(found.labels[found.steps[onset.interval].from]);
      addOnset(onset, true, &line);
      for (std::size_t way = 0; way < counts.ways.size(); ++way) {
        addOnset(counts.ways[way].onsets.of_truth[i], waysToLook()[way].motion == Motion::kSwept,
                 &line);
      }
      text += line + "\n";
    }
  }
  return text;
}

std::string motionJson(const TradeArguments& arguments, const MotionResults& found,
                       const std::vector<MotionCounts>& levels, const FrameSource& frames) {
  Json json = summaryHead(arguments, frames);
  json["frames"] = found.labels;
  json["every"] = found.every;
  json["backend"] = arguments.grid.backends.front();
  json["pairs_without_step"] = found.pairs_without_step;
  json["rejected_triangles"] = found.rejected;
  std::vector<double> ms;
  for (const MotionStep& step : found.steps) ms.push_back(step.round_trip_ms);
  json["truth_median_ms"] = median(ms);
  json["motions"] = jsonTable(rows(found, levels));
  return jsonText(json);
}

// Each line names a way, and what it loses at both levels.
std::string motionText(const MotionResults& found, const std::vector<MotionCounts>& levels) {
  std::string text = "Of what touches at some time, by swept motion at all " +
                     std::to_string(found.labels.size()) + " frames:\n";
  for (std::size_t way = 0; way < waysToLook().size(); ++way) {
    const MotionWay& look = waysToLook()[way];
    text += std::string("  ") + toString(look.motion) +
            (look.kept_alone ? " at every " + std::to_string(found.every) + "th frame" : "") +
            " loses";
    const char* between = " ";
    for (const MotionCounts& counts : levels) {
      const std::string of = counts.level == MotionLevel::kBodies ? " of bodies" : " of triangles";
      text += between + lossText(counts.ways[way].contacts.lost(), counts.ways[way].contacts.truth,
                                 ("contacts" + of).c_str());
      text += ", " + lossText(counts.ways[way].onsets.lost(), counts.truth.size(), "onsets");
      between = "; ";
    }
    text += "\n";
  }
  return text;
}

}  // namespace deformable_contact_monitor
