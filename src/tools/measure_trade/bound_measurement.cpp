// What tolerances and budgets cost, and what they say of pairs of bodies, against the exact states.
#include "tools/measure_trade/bound_measurement.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/body_distance.h"
#include "core/common/posed_body.h"
#include "tools/common/backend_choice.h"
#include "tools/common/sample_statistics.h"
#include "tools/measure_trade/trade_grid.h"
#include "tools/measure_trade/triangle_gap.h"

namespace deformable_contact_monitor {
namespace {

double share(std::uint64_t part, std::uint64_t whole) {
  return whole == 0 ? 1 : static_cast<double>(part) / static_cast<double>(whole);
}

std::set<BodyPair> touching(const DetectionResult& result) {
  std::set<BodyPair> bodies;
  for (std::size_t i = 0; i < result.contacts.size(); ++i) {
    const TrianglePair& pair = result.contacts[i];
    if (pair.body_a == pair.body_b) continue;
    if (!result.separations_m.empty() && result.separations_m[i] > 0) continue;
    bodies.insert({pair.body_a, pair.body_b});
  }
  return bodies;
}

// The states of one detection.
class Counting {
 public:
  Counting(const Scene& scene, const std::set<BodyPair>& truth, std::string frame,
           BoundMeasurement* sum)
      : scene_(scene), truth_(truth), frame_(std::move(frame)), sum_(sum) {}

  void add(const DetectionResult& result) {
    if (result.distances.empty()) return addExact(result);
    for (const BodyDistance& distance : result.distances) {
      const float margin_m =
          std::max(scene_.body(distance.body_a).margin_m, scene_.body(distance.body_b).margin_m);
      const PairDecision decision = decide(distance, margin_m, sum_->setting.tolerance_m);
      add({distance.body_a, distance.body_b}, decision);
      if (decision == PairDecision::kContact) addClaim(distance.witness);
    }
  }

 private:
  void addExact(const DetectionResult& result) {
    const std::set<BodyPair> found = touching(result);
    for (const BodyPair& bodies : scene_.enabledPairs()) {
      if (bodies.first == bodies.second) continue;
      const bool is_found = found.count(bodies) > 0;
      add(bodies, is_found         ? PairDecision::kContact
                  : result.cut_off ? PairDecision::kOpen
                                   : PairDecision::kNone);
    }
  }

  void add(const BodyPair& bodies, PairDecision decision) {
    const bool is_true = truth_.count(bodies) > 0, claimed = decision == PairDecision::kContact;
    ++sum_->pairs;
    sum_->decided += decision != PairDecision::kOpen;
    sum_->contacts += is_true;
    sum_->claimed += claimed;
    sum_->common += claimed && is_true;
    if (!is_true || claimed || decision == PairDecision::kOpen) return;
    ++sum_->missed;
    if (sum_->setting.overlap < 1) return;
    fail("says that " + scene_.body(bodies.first).name + " and " + scene_.body(bodies.second).name +
         ", which intersect, do not");
  }

  void addClaim(const TrianglePair& witness) {
    const Triangle a = PosedBody(scene_.body(witness.body_a)).triangle(witness.triangle_a);
    const Triangle b = PosedBody(scene_.body(witness.body_b)).triangle(witness.triangle_b);
    const double gap_m = triangleGapM(a, b);
    sum_->largest_claim_m = std::max(sum_->largest_claim_m, gap_m);
    double largest = 0;
    for (const Triangle& t : {a, b}) {
      for (const Vec3f& v : t.v) {
        largest = std::max(
            {largest, std::abs(double{v.x}), std::abs(double{v.y}), std::abs(double{v.z})});
      }
    }
    constexpr double kRounding = 1e-12;
    if (gap_m <= double{sum_->setting.tolerance_m} + kRounding * largest) return;
    fail("claims a contact of triangles that are " + numberText(gap_m) + " m apart");
  }

  void fail(const std::string& how) {
    if (sum_->broken.empty()) sum_->broken = describe(sum_->setting) + " " + how + ", in " + frame_;
  }

  const Scene& scene_;
  const std::set<BodyPair>& truth_;
  const std::string frame_;
  BoundMeasurement* const sum_;
};

}  // namespace

std::string describe(const BoundSetting& setting) {
  if (setting.overlap < 1) return "overlap " + numberText(setting.overlap);
  if (!setting.isBounded()) return setting.backend == "cpu" ? "exact" : "exact, " + setting.backend;
  std::string text = "tolerance " + numberText(setting.tolerance_m) + " m";
  if (setting.budget_ms > 0) text += ", budget " + numberText(setting.budget_ms) + " ms";
  return text;
}

double BoundMeasurement::recall() const { return share(common, contacts); }
double BoundMeasurement::precision() const { return share(common, claimed); }
double BoundMeasurement::decidedShare() const { return share(decided, pairs); }
double BoundMeasurement::p99OverBudget() const {
  return setting.budget_ms > 0 ? percentile(ms, 0.99) / setting.budget_ms : 0;
}

TouchingBodies touchingBodies(FrameSource* frames, Detector* exact, const Options& options,
                              const SayProgress& progress) {
  TouchingBodies truth;
  frames->rewind();
  while (frames->next()) {
    progress("exact contacts of " + frames->label());
    truth.push_back(touching(exact->detect(frames->scene(), options)));
  }
  return truth;
}

void measureBounds(FrameSource* frames, const TouchingBodies& truth, const CycleCounts& cycles,
                   const Options& options, Detector* detector, TilingCache* tilings,
                   BoundMeasurement* sum) {
  Options bounded = options;
  bounded.tolerance_m = sum->setting.tolerance_m;
  bounded.overlap = sum->setting.overlap;
  int warm_up = cycles.warm_up;
  for (int pass = 0; pass < cycles.passes || warm_up > 0;) {
    frames->rewind();
    for (std::size_t frame = 0; frames->next(); ++frame) {
      const Scene& scene = frames->scene();
      if (tilings != nullptr) makeTilings(scene, tilings);
      const SteadyTime start = std::chrono::steady_clock::now();
      if (sum->setting.budget_ms > 0) {
        bounded.limits.deadline = start + fromSeconds(sum->setting.budget_ms / 1e3);
      }
      const DetectionResult& result = detector->detect(scene, bounded);
      const double ms = 1e3 * toSeconds(std::chrono::steady_clock::now() - start);
      if (warm_up > 0) continue;
      sum->ms.push_back(ms);
      Counting(scene, truth.at(frame), frames->label(), sum).add(result);
    }
    if (warm_up > 0) {
      warm_up -= static_cast<int>(truth.size());
    } else {
      ++pass;
    }
  }
}

}  // namespace deformable_contact_monitor
