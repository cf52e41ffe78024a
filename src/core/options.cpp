#include "core/options.h"

#include <cmath>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

bool isThreads(int threads) { return threads >= 0 && threads <= 1024; }

std::string threadsProblem(int threads) {
  return "threads is " + std::to_string(threads) + ", must be in [0, 1024] (0: all)";
}

}  // namespace

bool isGuaranteed(const Options& options) { return options.overlap == 1; }

std::vector<std::string> problems(const Options& options) {
  std::vector<std::string> found;
  const auto require = [&found](bool ok, const std::string& line) {
    if (!ok) found.push_back(line);
  };
  require(options.overlap >= 0 && options.overlap <= 1,
          "overlap is " + std::to_string(options.overlap) + ", must be in [0, 1]");
  require(options.clusters >= 0 && options.clusters <= kMaxClusters,
          "clusters is " + std::to_string(options.clusters) + ", must be in [0, " +
              std::to_string(kMaxClusters) + "] (0: from the scene)");
  require(options.fuzzifier >= 1.05F && options.fuzzifier <= 4,
          "fuzzifier is " + std::to_string(options.fuzzifier) + ", must be in [1.05, 4]");
  require(options.iterations >= 0 && options.iterations <= 100,
          "iterations is " + std::to_string(options.iterations) + ", must be in [0, 100]");
  require(options.refresh_period >= 1,
          "refresh_period is " + std::to_string(options.refresh_period) + ", must be >= 1");
  require(isThreads(options.threads), threadsProblem(options.threads));
  require(std::isfinite(options.tolerance_m) && options.tolerance_m >= 0,
          "tolerance_m is " + std::to_string(options.tolerance_m) + ", must be finite and >= 0");
  const bool swept = options.motion == Motion::kSwept;
  require(!(options.geometry && swept), "geometry is of one moment, motion is swept");
  require(!options.first_times || swept, "first_times is of a step, motion is instant");
  return found;
}

void requireValid(const Options& options) {
  std::string lines;
  for (const std::string& line : problems(options)) lines += (lines.empty() ? "" : "; ") + line;
  if (!lines.empty()) throw std::invalid_argument(lines);
}

void requireThreads(int threads) {
  if (!isThreads(threads)) throw std::invalid_argument(threadsProblem(threads));
}

void requireInstant(const Options& options, const std::string& backend) {
  if (options.motion == Motion::kInstant) return;
  throw std::invalid_argument("backend \"" + backend + "\" knows no swept motion");
}

const char* toString(Motion motion) { return motion == Motion::kSwept ? "swept" : "instant"; }

const char* toString(AdjacentPairs adjacent) {
  return adjacent == AdjacentPairs::kSkip ? "skip" : "beyond_shared";
}

const char* toString(Predicates predicates) {
  return predicates == Predicates::kConservative ? "conservative" : "exact";
}

Predicates toPredicates(const std::string& name) {
  for (const Predicates p : {Predicates::kExact, Predicates::kConservative}) {
    if (name == toString(p)) return p;
  }
  throw std::invalid_argument("predicates '" + name + "' is none of exact, conservative");
}

}  // namespace deformable_contact_monitor
