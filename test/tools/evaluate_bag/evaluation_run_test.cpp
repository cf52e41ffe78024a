// How runs are compared and judged.
#include "tools/evaluate_bag/evaluation_run.h"

#include <gtest/gtest.h>

#include "reference/reference_detectors.h"
#include "scenes.h"
#include "tools/evaluate_bag/evaluation_summary.h"

namespace deformable_contact_monitor {
namespace {

using Runs = std::vector<std::unique_ptr<EvaluationRun>>;

void addRun(const std::string& backend, Predicates predicates, float overlap, Runs* runs) {
  Options options;
  options.predicates = predicates;
  options.overlap = overlap;
  runs->push_back(std::make_unique<EvaluationRun>(backend, makeBruteForceDetector(), options,
                                                  StateRules(), std::vector<Expectation>()));
}

TEST(RunComparison, OnlyExactRunsMustAgree) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  addRun("cuda", Predicates::kExact, 1, &runs);
  addRun("cuda", Predicates::kConservative, 1, &runs);
  addRun("cpu", Predicates::kConservative, 1, &runs);
  addRun("cpu", Predicates::kExact, 0.5F, &runs);
  addRun("fcl", Predicates::kExact, 1, &runs);
  const std::vector<RunComparison> all = comparisons(runs);
  ASSERT_EQ(all.size(), 5U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].must_agree, i == 0) << runs[all[i].b]->name();
  }
}

TEST(RunComparison, WithinATolerancePairsMayDiffer) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  Options options;
  options.tolerance_m = 0.25F;
  runs.push_back(std::make_unique<EvaluationRun>("cpu", makeBruteForceDetector(), options,
                                                 StateRules(), std::vector<Expectation>()));
  EXPECT_FALSE(comparisons(runs).at(0).must_agree);
  EXPECT_EQ(runs[1]->name(), "cpu exact, tolerance 0.25 m");
}

// By the state, for pairs are those that were seen.
std::string failureOf(Expectation::Touches touches, std::uint32_t min_pairs, std::uint8_t state,
                      std::uint32_t pair_count, float tolerance, std::uint8_t inside = 0,
                      bool found_all = true) {
  Expectation expectation;
  expectation.link = "hand";
  expectation.object = "cloth";
  expectation.touches = touches;
  expectation.min_pairs = min_pairs;
  ExpectationJudge judge(std::vector<Expectation>{expectation});
  ContactStates states;
  states.header.stamp = ros::Time(1);
  states.tolerance = tolerance;
  states.states.resize(1);
  states.states[0].stamp = ros::Time(1);
  states.states[0].body_a = "hand";
  states.states[0].body_b = "cloth";
  states.states[0].state = state;
  states.states[0].pair_count = pair_count;
  states.states[0].inside = inside;
  judge.look(states, false, found_all);
  return judge.verdicts().at(0).failure;
}

// The failures of one expectation in a recording whose pair has cycles only at these stamps.
std::string failureAtGap(Expectation expectation, const std::vector<double>& stamps_s,
                         std::uint8_t state, const std::string& reason = "") {
  expectation.link = "hand";
  expectation.object = "cloth";
  constexpr double kMaxAgeS = 0.5;
  ExpectationJudge judge({expectation}, kMaxAgeS);
  for (const double stamp_s : stamps_s) {
    ContactStates states;
    states.states.resize(1);
    states.header.stamp = states.states[0].stamp = ros::Time(stamp_s);
    states.states[0].body_a = "hand";
    states.states[0].body_b = "cloth";
    states.states[0].state = state;
    states.states[0].reason = reason;
    states.states[0].pair_count = 1;
    judge.look(states, !reason.empty());
  }
  return judge.verdicts().at(0).failure;
}

TEST(ExpectationJudge, ATimeWithoutCyclesIsUnknown) {
  using Touches = Expectation::Touches;
  const std::vector<double> gap = {10, 10.5, 11, 14, 14.5};
  Expectation never, always, keeps;
  never.touches = Touches::kNever;
  always.touches = Touches::kAlways;
  keeps.keeps_m = 0.1;
  EXPECT_EQ(failureAtGap(never, gap, ContactState::NONE),
            "at 1.500 s: UNKNOWN until 4.000 s (no new mesh within max_mesh_age_s)");
  EXPECT_NE(failureAtGap(always, gap, ContactState::CONTACT), "");
  EXPECT_NE(failureAtGap(keeps, gap, ContactState::NONE), "");
  EXPECT_EQ(failureAtGap(Expectation(), gap, ContactState::CONTACT), "");
  EXPECT_EQ(failureAtGap(never, {10, 10.5, 11}, ContactState::NONE), "");
  EXPECT_EQ(failureAtGap(never, {20, 20.5, 10, 10.5}, ContactState::NONE), "") << "clock went back";
  // Only the time of the expectation counts.
  never.from_s = 2;
  never.to_s = 3;
  EXPECT_NE(failureAtGap(never, gap, ContactState::NONE).find("at 2.000 s: UNKNOWN"),
            std::string::npos);
  never.from_s = 4;
  never.to_s = 5;
  EXPECT_EQ(failureAtGap(never, gap, ContactState::NONE), "");
  never.from_s = 0;
  never.to_s = 1.5;
  EXPECT_EQ(failureAtGap(never, gap, ContactState::NONE), "");
  // What is UNKNOWN at an edge of the recording is not judged, and neither is the time between.
  EXPECT_EQ(failureAtGap(always, {10, 10.75}, ContactState::UNKNOWN, "hand: TF is missing"),
            "no cycle in that time");
}

// A judge of hand and cloth, which look at each other with a state at each of these stamps. Where a
// stamp is below 0, another object has a cycle then, and the two are UNKNOWN.
ExpectationJudge judgeOf(const Expectation& like, const std::vector<double>& stamps_s,
                         const std::string& unknown_part = "") {
  Expectation expectation = like;
  expectation.link = "hand";
  expectation.object = "cloth";
  ExpectationJudge judge({expectation}, 0.5);
  for (const double stamp_s : stamps_s) {
    ContactStates states;
    states.header.stamp = ros::Time(std::abs(stamp_s));
    ContactState state;
    state.stamp = states.header.stamp;
    state.body_a = "hand";
    state.body_b = "cloth";
    state.state = stamp_s < 0 ? ContactState::UNKNOWN : ContactState::NONE;
    states.states.push_back(state);
    if (!unknown_part.empty()) {
      state.body_b = unknown_part;
      state.state = ContactState::UNKNOWN;
      states.states.push_back(state);
    }
    judge.look(states);
  }
  return judge;
}

std::vector<Expectation> neverAndKeeps() {
  std::vector<Expectation> both(2);
  both[0].touches = Expectation::Touches::kNever;
  both[1].keeps_m = 0.1;
  return both;
}

TEST(ExpectationJudge, WhatIsAwayBeforeTheEndIsUnknown) {
  for (Expectation e : neverAndKeeps()) {
    const std::vector<double> stamps = {10, 10.5, 11};
    const auto failure = [&](const ros::Time& end) {
      return judgeOf(e, stamps).verdicts(end).at(0).failure;
    };
    EXPECT_EQ(failure(ros::Time()), "");
    EXPECT_EQ(failure(ros::Time(12.5)), "") << "recorders end one topic after the other";
    EXPECT_EQ(failure(ros::Time(9)), "");
    EXPECT_EQ(failure(ros::Time(14)),
              "at 1.500 s: UNKNOWN until 4.000 s (no new mesh within max_mesh_age_s)");
    e.to_s = 1.5;
    EXPECT_EQ(failure(ros::Time(14)), "") << "its own time is over then";
    e.to_s = 2;
    EXPECT_NE(failure(ros::Time(14)), "");
  }
}

TEST(ExpectationJudge, TheCycleOfAnotherObjectEndsNoGap) {
  for (Expectation e : neverAndKeeps()) {
    e.from_s = 1.2;
    EXPECT_NE(judgeOf(e, {10, 13}).verdicts().at(0).failure, "");
    EXPECT_NE(judgeOf(e, {10, -11.1, -12.9, 13}).verdicts().at(0).failure, "");
    e.from_s = 2.8;
    EXPECT_NE(judgeOf(e, {10, -12.7, 13}).verdicts().at(0).failure, "");
    e.from_s = 3;
    EXPECT_EQ(judgeOf(e, {10, -12.7, 13}).verdicts().at(0).failure, "");
  }
}

TEST(ExpectationJudge, AnUnknownPartMakesItsBodyUnknown) {
  for (const Expectation& e : neverAndKeeps()) {
    EXPECT_NE(judgeOf(e, {10, 10.5}, "cloth:hem").verdicts().at(0).failure, "");
    EXPECT_EQ(judgeOf(e, {10, 10.5}, "clothes").verdicts().at(0).failure, "");
    EXPECT_EQ(judgeOf(e, {10, 10.5}, "rug:hem").verdicts().at(0).failure, "");
  }
}

TEST(ExpectationJudge, AContactIsATouchWithoutPairsToo) {
  using Touches = Expectation::Touches;
  const auto contact = [](Touches touches, std::uint32_t min_pairs, std::uint32_t listed) {
    return failureOf(touches, min_pairs, ContactState::CONTACT, listed, 0, 0, false);
  };
  EXPECT_NE(contact(Touches::kNever, 1, 0), "");
  EXPECT_EQ(contact(Touches::kAlways, 1, 0), "");
  EXPECT_EQ(contact(Touches::kSometime, 1, 0), "");
  EXPECT_NE(contact(Touches::kNever, 5, 4), "") << "there may be five";
  EXPECT_NE(contact(Touches::kAlways, 5, 4), "");
  EXPECT_EQ(contact(Touches::kAlways, 5, 5), "");
  EXPECT_NE(failureOf(Touches::kNever, 2, ContactState::PASSED, 1, 0, 0, false), "");
}

TEST(ExpectationJudge, NearPairsAreNotCounted) {
  std::vector<Expectation> expectations(3);
  expectations[0].min_pairs = 2;
  expectations[2].keeps_m = 0.01;
  expectations[2].link = "hand";
  for (const bool near_pairs : {false, true}) {
    const auto marginOf = [](const std::string& name) { return BodyMargin{name, 0.02}; };
    checkMargins(marginOf, near_pairs, &expectations);
    EXPECT_EQ(expectations[0].problem.empty(), !near_pairs);
    EXPECT_EQ(expectations[1].problem, "");
    EXPECT_EQ(expectations[2].problem, "");
  }
}

// The state of a body with its own part is about self-contact.
TEST(ExpectationJudge, NoDistanceIsKnownWithinABody) {
  std::vector<Expectation> expectations(3);
  for (Expectation& e : expectations) e.keeps_m = 0.01;
  for (Expectation& e : expectations) e.link = "cloth:hem";
  expectations[0].object = "cloth";
  expectations[1].object = "cloth:collar";
  expectations[2].object = "left:cloth";
  const auto marginOf = [](const std::string& name) {
    return BodyMargin{name.rfind("cloth", 0) == 0 ? "cloth" : name, 0.02};
  };
  checkMargins(marginOf, false, &expectations);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(expectations[i].problem.empty(), i == 2) << i;
}

// Bounds of a time belong to it, and a gap is longer than max_mesh_age_s, although decimals are no
// doubles.
TEST(ExpectationJudge, TimesAreThoseThatPeopleWrite) {
  for (const int step : {1, 2, 3, 7}) {  // tenths of a second
    std::vector<Expectation> each(50);
    for (std::size_t i = 0; i < each.size(); ++i) {
      each[i].touches = Expectation::Touches::kAlways;
      each[i].link = "hand";
      each[i].object = "cloth";
      each[i].from_s = each[i].to_s = static_cast<double>(i * step) / 10;
    }
    each.push_back(each[0]);
    each.back().to_s = 1e9;
    ExpectationJudge judge(each, step / 10.0);
    for (std::size_t i = 0; i + 1 < each.size(); ++i) {
      ContactStates states;
      states.states.resize(1);
      const std::size_t tenths = i * step;
      states.header.stamp = ros::Time(100 + tenths / 10, tenths % 10 * 100000000);
      states.states[0].stamp = states.header.stamp;
      states.states[0].body_a = "hand";
      states.states[0].body_b = "cloth";
      states.states[0].state = ContactState::CONTACT;
      states.states[0].pair_count = 1;
      judge.look(states);
    }
    const auto verdicts = judge.verdicts();
    for (std::size_t i = 0; i < each.size(); ++i) {
      EXPECT_EQ(verdicts.at(i).failure, "") << each[i].from_s << " s, step " << step;
    }
  }
}

TEST(ExpectationJudge, WithinAToleranceGoesByStates) {
  using Touches = Expectation::Touches;
  constexpr float kTolerance = 0.01F;
  const auto contact = [&](Touches touches, std::uint32_t min_pairs, std::uint32_t seen) {
    return failureOf(touches, min_pairs, ContactState::CONTACT, seen, kTolerance);
  };
  EXPECT_EQ(contact(Touches::kSometime, 1, 0), "");
  EXPECT_EQ(contact(Touches::kAlways, 1, 0), "");
  EXPECT_NE(contact(Touches::kNever, 1, 0), "");
  EXPECT_NE(contact(Touches::kNever, 5, 2), "") << "there may be five";
  EXPECT_NE(contact(Touches::kAlways, 5, 2), "");
  EXPECT_NE(contact(Touches::kSometime, 5, 2), "");
  EXPECT_EQ(contact(Touches::kAlways, 5, 5), "");
  EXPECT_EQ(failureOf(Touches::kNever, 5, ContactState::CONTACT, 2, 0), "") << "exact";
  EXPECT_EQ(failureOf(Touches::kNever, 1, ContactState::NONE, 0, kTolerance), "");
  for (const Touches touches : {Touches::kNever, Touches::kAlways, Touches::kSometime}) {
    EXPECT_NE(failureOf(touches, 1, ContactState::UNKNOWN, 0, kTolerance), "");
  }
}

TEST(ExpectationJudge, WhatIsInsideTouchesWithoutPairs) {
  using Touches = Expectation::Touches;
  for (const float tolerance : {0.F, 0.01F}) {
    const auto inside = [&](Touches touches) {
      return failureOf(touches, 3, ContactState::CONTACT, 0, tolerance, 1);
    };
    EXPECT_NE(inside(Touches::kNever), "");
    EXPECT_EQ(inside(Touches::kSometime), "");
    EXPECT_EQ(inside(Touches::kAlways), "");
  }
}

// One cycle in which the pair of a link and a cloth is UNKNOWN for `reason`, or nothing is wrong.
void look(const std::string& reason, EvaluationRun* run) {
  CycleReport cycle;
  cycle.header.stamp = ros::Time(1 + static_cast<double>(run->cycles++));
  cycle.bodies = {{"hand", BodyKind::kLink, ros::Time(1), 0, ""},
                  {"cloth", BodyKind::kDeformable, ros::Time(1), 0, "", true}};
  cycle.pairs = {{0, 1}};
  ContactStates states;
  states.states.resize(1);
  states.states[0].state = reason.empty() ? ContactState::NONE : ContactState::UNKNOWN;
  states.states[0].reason = reason;
  run->unknown.look(cycle, states);
}

TEST(EvaluationEnd, PassesUnlessExactRunsDisagreeOrAnExpectationFails) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  look("", runs[0].get());
  for (const bool must_agree : {false, true}) {
    for (const std::uint64_t differing : {0, 3}) {
      for (const char* failure : {"", "not once"}) {
        const std::vector<RunComparison> compared = {{0, 1, must_agree, differing, 0, 0, ""}};
        EvaluationEnd end;
        end.runs = &runs;
        end.comparisons = &compared;
        end.expectations = {{"a touches b", failure}};
        EXPECT_EQ(isPassed(end), (!must_agree || differing == 0) && *failure == '\0');
      }
    }
  }
}

TEST(EvaluationEnd, WithoutACycleThatFoundOutAnythingNothingIsPassed) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  const std::vector<RunComparison> compared;
  EvaluationEnd end;
  end.runs = &runs;
  end.comparisons = &compared;
  EXPECT_FALSE(isPassed(end));
  look("hand: no pose", runs[0].get());
  EXPECT_FALSE(isPassed(end));
  EXPECT_NE(verdictText(end).find("no cycle"), std::string::npos);
  look("", runs[0].get());
  EXPECT_TRUE(isPassed(end));
}

TEST(EvaluationEnd, ADamagedBagIsNotPassed) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  look("", runs[0].get());
  const std::vector<RunComparison> compared;
  EvaluationEnd end;
  end.runs = &runs;
  end.comparisons = &compared;
  end.damage = "1 messages, on /cloth for example: too short";
  EXPECT_FALSE(isPassed(end));
  EXPECT_EQ(verdictText(end).find("Not judged: a bag is damaged."), 0U) << verdictText(end);
  end.expectations = {{"a touches b", "not once"}};
  EXPECT_EQ(verdictText(end).find("Failed: 1 expectation fails, a bag is damaged."), 0U)
      << verdictText(end);
}

TEST(UnknownReasons, AreCountedWithoutTheirNumbersAndTheCommonestIsFirst) {
  Runs runs;
  addRun("cpu", Predicates::kExact, 1, &runs);
  for (const char* reason : {"link_2: late: wanted 3.25, newest available 3.1", "hand: no mesh yet",
                             "link_2: late: wanted 4.5, newest available 3.1",
                             "link_3: late: wanted 4.5, newest available 3.1", ""}) {
    look(reason, runs[0].get());
  }
  const std::vector<UnknownReason> all = runs[0]->unknown.all();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].text, "link_2: late: wanted 3.25, newest available 3.1");
  EXPECT_EQ(all[0].cycles, 2U);
  EXPECT_EQ(all[0].from, ros::Time(1));
  EXPECT_EQ(all[0].to, ros::Time(3));
  EXPECT_EQ(all[1].text, "hand: no mesh yet");
  EXPECT_EQ(all[2].text, "link_3: late: wanted 4.5, newest available 3.1");
  EXPECT_EQ(runs[0]->unknown.evaluatedCycles(), 1U);
}

TEST(RunSettings, ThreadsOfTheCommandLineGoBeforeTheConfigurations) {
  EvaluateArguments arguments;
  arguments.overlaps = {1, 0.5F};
  MonitorParameters parameters;
  parameters.detector.threads = 3;
  for (const RunSettings& run : runSettings(arguments, parameters)) {
    EXPECT_EQ(run.options.threads, 3);
  }
  for (const int threads : {0, 1}) {
    arguments.threads = threads;
    const std::vector<RunSettings> runs = runSettings(arguments, parameters);
    ASSERT_EQ(runs.size(), 2U);
    for (const RunSettings& run : runs) EXPECT_EQ(run.options.threads, threads);
  }
}

TEST(EvaluationRun, CompleteMeansThatNothingCanBeMissing) {
  CycleReport cycle;
  cycle.bodies = {{"hand", BodyKind::kLink, ros::Time(1), 0, ""}};
  DetectionResult result;
  EXPECT_FALSE(isComplete(cycle, result));
  result.guaranteed = true;
  EXPECT_TRUE(isComplete(cycle, result));
  result.left_out = 1;
  EXPECT_FALSE(isComplete(cycle, result));
  result.left_out = 0;
  result.counters.rejected = 1;
  EXPECT_FALSE(isComplete(cycle, result));
  result.counters.rejected = 0;
  result.cut_off = true;
  EXPECT_FALSE(isComplete(cycle, result));
  result.cut_off = false;
  cycle.bodies[0].unknown_because = "no mesh yet";
  EXPECT_FALSE(isComplete(cycle, result));
}

}  // namespace
}  // namespace deformable_contact_monitor
