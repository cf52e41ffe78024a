// Writes what was found of states into the answer to a question.
#pragma once

#include <deformable_contact_monitor/ContactState.h>
#include <deformable_contact_monitor/StatesChecked.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "core/state_checker.h"
#include "monitor/cycle/monitor_scene.h"

namespace deformable_contact_monitor {

// Appends the results of some states to the answer.
class AnswerWriter {
 public:
  // `unknown_because` says why NONE and NEAR are not known; empty: they are.
  AnswerWriter(const MonitorScene& scene, const StatesAsked& asked, bool with_names,
               std::string unknown_because, StatesChecked* answer)
      : scene_(scene),
        asked_(asked),
        with_names_(with_names),
        unknown_because_(std::move(unknown_because)),
        answer_(answer) {}

  void add(const StateResults& results) {
    auto touching = results.pairs.begin();
    for (std::size_t i = 0; i < results.states.size(); ++i) {
      const StateAnswer& found = results.states[i];
      const std::uint8_t state = toState(found.decision);
      answer_->state.push_back(state);
      if (state == ContactState::UNKNOWN && answer_->reason.empty()) {
        answer_->reason = whyUnknown(results);
      }
      if (!with_names_) continue;
      while (touching != results.pairs.end() && touching->state < i) ++touching;
      const bool is_listed = touching != results.pairs.end() && touching->state == i;
      addNames(state, found, is_listed ? &*touching : nullptr);
    }
  }

 private:
  std::uint8_t toState(PairDecision decision) const {
    if (decision == PairDecision::kContact) return ContactState::CONTACT;
    if (decision == PairDecision::kOpen || !unknown_because_.empty()) return ContactState::UNKNOWN;
    return decision == PairDecision::kNear ? ContactState::NEAR : ContactState::NONE;
  }

  std::string whyUnknown(const StateResults& results) const {
    if (!unknown_because_.empty()) return unknown_because_;
    return results.cut_off ? results.cut_off_because : "a pose makes vertices infinite";
  }

  void addNames(std::uint8_t state, const StateAnswer& found, const TouchingBodies* touching) {
    const TrianglePair& nearest = found.nearest.pair;
    BodyId a = touching != nullptr ? touching->body_a : nearest.body_a;
    BodyId b = touching != nullptr ? touching->body_b : nearest.body_b;
    if (!asked_.moved[a]) std::swap(a, b);
    const bool is_near = state == ContactState::NEAR, is_contact = state == ContactState::CONTACT;
    const bool has_names = is_near || is_contact;
    answer_->link.push_back(has_names ? scene_.bodies()[a].name : "");
    answer_->object.push_back(has_names ? scene_.bodies()[b].name : "");
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
    answer_->distance.push_back(is_contact                    ? 0
                                : is_near                     ? found.nearest.distance_m
                                : state == ContactState::NONE ? kInfinity
                                                              : kNaN);
  }

  const MonitorScene& scene_;
  const StatesAsked& asked_;
  const bool with_names_;
  const std::string unknown_because_;
  StatesChecked* const answer_;
};

// Results of states of which the checker is not asked.
inline StateResults resultsWithoutCheck(std::size_t count, PairDecision decision) {
  StateResults results;
  results.states.resize(count);
  for (StateAnswer& state : results.states) state.decision = decision;
  return results;
}

}  // namespace deformable_contact_monitor
