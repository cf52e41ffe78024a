#include "tools/measure_trade/state_measurement.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "cuda/detector_choice.h"
#include "tools/common/formatted.h"
#include "tools/common/reports.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_report.h"

namespace deformable_contact_monitor {
namespace {

double shareOfStates(std::size_t part, std::size_t all) {
  return all == 0 ? 0 : static_cast<double>(part) / static_cast<double>(all);
}

std::vector<TableRow> rows(const std::vector<StateMeasurement>& all) {
  std::vector<TableRow> rows;
  rows.reserve(all.size());
  for (const StateMeasurement& m : all) {
    rows.push_back({{"way", m.way},
                    {"question", m.nearest ? "nearest" : "touch"},
                    {"threads", m.threads},
                    {"batch", m.batch},
                    {"median_us", median(m.us)},
                    {"p95_us", percentile(m.us, 0.95)},
                    {"states", m.states},
                    {"false_free", shareOfStates(m.false_free, m.states)},
                    {"false_blocked", shareOfStates(m.false_blocked, m.states)}});
  }
  return rows;
}

}  // namespace

StateMeasurement measureStates(const SceneStates& states, const std::vector<bool>& touches,
                               std::size_t batch, int passes, StateWay* way) {
  StateMeasurement m;
  m.way = way->name;
  m.nearest = way->nearest;
  m.threads = way->threads;
  m.batch = batch;
  StateOptions options;
  options.nearest = way->nearest;
  options.threads = way->threads;
  for (int pass = -1; pass < passes; ++pass) {
    for (std::size_t first = 0; first < states.count(); first += batch) {
      const std::size_t size = std::min(batch, states.count() - first);
      const StateResults& results =
          way->checker->check(states.scene, states.batch(first, size), options);
      if (pass >= 0 && size == batch) {
        m.us.push_back(1e3 * results.check_ms / static_cast<double>(size));
      }
      for (std::size_t i = 0; pass < 0 && i < size; ++i) {
        const PairDecision decision = results.states[i].decision;
        if (decision == PairDecision::kOpen) continue;
        const bool touch = decision == PairDecision::kContact;
        ++m.states;
        if (touches[first + i] && !touch) ++m.false_free;
        if (!touches[first + i] && touch) ++m.false_blocked;
      }
    }
  }
  return m;
}

std::vector<bool> exactTouches(const SceneStates& states) {
  const StateResults results =
      makeCpuStateChecker()->check(states.scene, states.batch(0, states.count()), {});
  std::vector<bool> touches;
  for (const StateAnswer& answer : results.states) {
    touches.push_back(answer.decision == PairDecision::kContact);
  }
  return touches;
}

std::vector<StateWay> stateWays(const std::vector<std::string>& backends, int threads) {
  std::vector<StateWay> ways;
  for (const std::string& backend : backends) {
    for (const bool nearest : {false, true}) {
      ways.push_back({backend, makeStateChecker(toBackendChoice(backend)), nearest, threads});
    }
  }
  if (auto fcl = makeFclStateChecker()) ways.push_back({"fcl", std::move(fcl), false, 1});
  for (const std::size_t spheres : {4, 8, 16}) {
    for (const SphereSize size : {SphereSize::kCovering, SphereSize::kMean}) {
      auto checker = makeSphereStateChecker(spheres, size);
      const std::string name = checker->backend() + "_" + std::to_string(spheres);
      ways.push_back({name, std::move(checker), false, 1});
    }
  }
  return ways;
}

std::vector<std::size_t> batchSizes(const StateWay& way, std::size_t states) {
  std::vector<std::size_t> sizes;
  const bool is_ours = way.name == "cpu" || way.name == "cuda";
  for (std::size_t size = 1; is_ours && size < states; size *= 10) sizes.push_back(size);
  sizes.push_back(states);
  return sizes;
}

std::string statesCsv(const std::vector<StateMeasurement>& all) { return csvTable(rows(all)); }

std::string statesJson(const std::string& command, const SceneStates& states,
                       const std::vector<bool>& touches, const std::vector<StateMeasurement>& all) {
  nlohmann::json json = {
      {"version", DCM_VERSION}, {"command", command}, {"machine", machineJson()}};
  json["bodies"] = nlohmann::json::array();
  for (const Body& body : states.scene.bodies()) {
    json["bodies"].push_back({{"name", body.name}, {"triangles", body.mesh.triangleCount()}});
  }
  json["states"] = states.count();
  json["touching"] = std::count(touches.begin(), touches.end(), true);
  json["margin_m"] = states.scene.body(0).margin_m;
  json["ways"] = jsonTable(rows(all));
  return jsonText(json);
}

std::string statesText(const std::vector<StateMeasurement>& all) {
  std::string text;
  for (const StateMeasurement& m : all) {
    text += formatted(
        "  %-16s %-7s %2d threads, %6zu states a batch: median %9.2f us a state, "
        "p95 %9.2f us; false free %5.2f %%, false blocked %5.2f %%\n",
        m.way.c_str(), m.nearest ? "nearest" : "touch", m.threads, m.batch, median(m.us),
        percentile(m.us, 0.95), 100 * shareOfStates(m.false_free, m.states),
        100 * shareOfStates(m.false_blocked, m.states));
  }
  return text;
}

#ifndef DCM_HAVE_BAGS
SceneStates makeRobotStates(const RobotStateFiles& /*files*/, std::size_t /*count*/,
                            std::uint32_t /*seed*/) {
  throw std::runtime_error("--states reads a robot, which a build without ROS cannot do");
}
#endif

}  // namespace deformable_contact_monitor
