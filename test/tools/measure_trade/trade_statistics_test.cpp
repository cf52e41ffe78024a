// Recall, onset delay, Pareto front and choice: worked examples, and random input against the
// definitions, written down another way.
#include "tools/measure_trade/trade_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <regex>
#include <set>
#include <string>

namespace deformable_contact_monitor {
namespace {

constexpr int kRandomCases = 2000;

std::vector<TrianglePair> randomPairs(std::mt19937* random) {
  std::set<TrianglePair> pairs;
  const auto below = [random](std::uint32_t end) {
    return static_cast<std::uint32_t>((*random)() % end);
  };
  const std::uint32_t count = below(12);
  for (std::uint32_t i = 0; i < count; ++i) {
    pairs.insert({below(2), below(2), below(2), below(3)});
  }
  return {pairs.begin(), pairs.end()};
}

// 0 is false, 1 is true.
std::vector<bool> flags(const std::string& text) {
  std::vector<bool> all;
  for (const char c : text) all.push_back(c == '1');
  return all;
}

std::string randomFlags(std::size_t length, std::mt19937* random) {
  std::string text;
  for (std::size_t i = 0; i < length; ++i) text += (*random)() % 3 == 0 ? '0' : '1';
  return text;
}

// Few values, so that ties are common.
std::vector<Worth> randomSettings(std::mt19937* random) {
  std::vector<Worth> settings(1 + (*random)() % 8);
  const auto quarter = [random](unsigned most) {
    return static_cast<double>((*random)() % (most + 1)) / 4;
  };
  for (Worth& w : settings) {
    w.median_ms = 1 + quarter(6);
    w.p95_ms = w.median_ms + quarter(2);
    w.recall = quarter(4);
    w.precision = quarter(4);
    w.guaranteed = (*random)() % 2 == 0;
  }
  return settings;
}

bool dominates(const Worth& a, const Worth& b) {
  if (a.median_ms > b.median_ms || a.recall < b.recall || a.precision < b.precision) return false;
  return a.median_ms != b.median_ms || a.recall != b.recall || a.precision != b.precision;
}

TEST(TradeStatistics, RatesOfAWorkedExample) {
  const std::vector<TrianglePair> truth = {{0, 1, 0, 2}, {0, 1, 1, 0}, {0, 1, 1, 4}, {0, 2, 2, 7}};
  const std::vector<TrianglePair> found = {{0, 1, 1, 0}, {0, 1, 1, 3}, {0, 2, 2, 7}};
  const FrameCounts counts = compare(truth, found);
  ASSERT_EQ(counts.size(), 3U);
  EXPECT_EQ(counts.at({0, 0}).recall(), 0);
  EXPECT_EQ(counts.at({0, 1}).recall(), 0.5);
  EXPECT_EQ(counts.at({0, 1}).precision(), 0.5);
  EXPECT_EQ(counts.at({0, 2}).recall(), 1);
  EXPECT_EQ(total(counts, ContactKind::kSelf).recall(), 0);
  EXPECT_EQ(total(counts, ContactKind::kExternal).recall(), 2 / 3.0);
  EXPECT_EQ(total(counts, ContactKind::kAny).recall(), 0.5);
  EXPECT_EQ(total(counts, ContactKind::kAny).precision(), 2 / 3.0);
}

TEST(TradeStatistics, NothingToFindIsAllFound) {
  EXPECT_EQ(PairCounts().recall(), 1);
  EXPECT_EQ(PairCounts().precision(), 1);
  EXPECT_TRUE(compare({}, {}).empty());
  const FrameCounts only_false = compare({}, {{0, 0, 1, 0}});
  EXPECT_EQ(total(only_false, ContactKind::kAny).recall(), 1);
  EXPECT_EQ(total(only_false, ContactKind::kAny).precision(), 0);
  EXPECT_EQ(RateOverFrames().mean(), 1);
}

TEST(TradeStatistics, CompareIsSetArithmetic) {
  std::mt19937 random(1);
  for (int i = 0; i < kRandomCases; ++i) {
    const std::vector<TrianglePair> truth = randomPairs(&random), found = randomPairs(&random);
    const FrameCounts counts = compare(truth, found);
    PairCounts sum;
    for (BodyId a = 0; a < 2; ++a) {
      for (BodyId b = 0; b < 2; ++b) {
        const auto of_bodies = [&](const TrianglePair& p) {
          return p.body_a == a && p.body_b == b;
        };
        PairCounts wanted;
        for (const TrianglePair& pair : truth) {
          if (!of_bodies(pair)) continue;
          ++wanted.truth;
          wanted.common += std::find(found.begin(), found.end(), pair) != found.end();
        }
        wanted.found =
            static_cast<std::uint64_t>(std::count_if(found.begin(), found.end(), of_bodies));
        const auto got = counts.find({a, b});
        ASSERT_EQ(got != counts.end(), wanted.truth + wanted.found > 0);
        if (got == counts.end()) continue;
        ASSERT_EQ(got->second.truth, wanted.truth);
        ASSERT_EQ(got->second.found, wanted.found);
        ASSERT_EQ(got->second.common, wanted.common);
        sum.add(wanted);
      }
    }
    const PairCounts any = total(counts, ContactKind::kAny);
    ASSERT_EQ(any.common, sum.common);
    ASSERT_EQ(any.truth, truth.size());
    ASSERT_EQ(any.found, found.size());
    ASSERT_EQ(total(counts, ContactKind::kSelf).truth + total(counts, ContactKind::kExternal).truth,
              truth.size());
  }
}

TEST(TradeStatistics, TheWorstFrameIsTheFirstOfTheWorst) {
  RateOverFrames rate;
  const double rates[] = {1, 0.5, 0.75, 0.5};
  for (std::size_t frame = 0; frame < 4; ++frame) rate.add(rates[frame], frame);
  EXPECT_EQ(rate.worst, 0.5);
  EXPECT_EQ(rate.worst_frame, 1U);
  EXPECT_EQ(rate.mean(), 0.6875);
}

TEST(TradeStatistics, OnsetDelaysOfAWorkedExample) {
  //                                            2 late   at once  missed (3)
  const OnsetDelay delay = onsetDelay(flags("0011110"
                                            "110"
                                            "1110"),
                                      flags("1000110"
                                            "110"
                                            "0001"));
  EXPECT_EQ(delay.runs, 3U);
  EXPECT_EQ(delay.missed, 1U);
  EXPECT_EQ(delay.worst, 3U);
  EXPECT_EQ(delay.sum, 5U);
  EXPECT_EQ(delay.mean(), 5 / 3.0);
  EXPECT_EQ(OnsetDelay().mean(), 0);
}

// Both as one text of letters a pair of flags each: a run is a match of a regular expression.
TEST(TradeStatistics, OnsetDelaysAreWhatARegularExpressionFinds) {
  std::mt19937 random(2);
  for (int i = 0; i < kRandomCases; ++i) {
    const std::size_t length = random() % 14;
    const std::string truth = randomFlags(length, &random), found = randomFlags(length, &random);
    std::string both;  // '.': no contact; 'm': missed; 'f': found
    for (std::size_t k = 0; k < length; ++k) {
      both += truth[k] == '0' ? '.' : (found[k] == '1' ? 'f' : 'm');
    }
    const OnsetDelay got = onsetDelay(flags(truth), flags(found));
    const std::regex run("(m*)(f?)[mf]*");
    std::size_t runs = 0, missed = 0, worst = 0, sum = 0;
    for (std::sregex_iterator it(both.begin(), both.end(), run), end; it != end; ++it) {
      if (it->length() == 0) continue;
      const auto delay = static_cast<std::size_t>((*it)[1].length());
      ++runs;
      missed += (*it)[2].length() == 0;
      worst = std::max(worst, delay);
      sum += delay;
    }
    ASSERT_EQ(got.runs, runs) << both;
    ASSERT_EQ(got.missed, missed) << both;
    ASSERT_EQ(got.worst, worst) << both;
    ASSERT_EQ(got.sum, sum) << both;
  }
}

TEST(TradeStatistics, FrontOfAWorkedExample) {
  const std::vector<Worth> settings = {{10, 11, 1, 1, true},     // the exact one
                                       {5, 6, 0.9, 1, false},    // faster, less found
                                       {6, 7, 0.9, 1, false},    // slower than that, no better
                                       {7, 8, 0.8, 1, false},    // worse in all
                                       {4, 5, 0.9, 0.5, false},  // the fastest, half of it wrong
                                       {10, 12, 1, 1, false}};   // a tie with the first
  EXPECT_EQ(paretoFront(settings), (std::vector<bool>{true, true, false, false, true, true}));
}

TEST(TradeStatistics, TheFrontIsWhatNothingDominates) {
  std::mt19937 random(3);
  for (int i = 0; i < kRandomCases; ++i) {
    const std::vector<Worth> settings = randomSettings(&random);
    const std::vector<bool> front = paretoFront(settings);
    ASSERT_EQ(front.size(), settings.size());
    for (std::size_t k = 0; k < settings.size(); ++k) {
      bool dominated = false, by_front = false;
      for (std::size_t other = 0; other < settings.size(); ++other) {
        if (!dominates(settings[other], settings[k])) continue;
        dominated = true;
        by_front = by_front || front[other];
      }
      ASSERT_EQ(front[k], !dominated);
      ASSERT_EQ(dominated, by_front) << "what is dominated is so by a member of the front";
    }
  }
}

TEST(TradeStatistics, ChoicesOfAWorkedExample) {
  const std::vector<Worth> settings = {{10, 12, 1, 1, true},
                                       {9, 11, 1, 0.9, true},
                                       {5, 6, 0.9, 1, false},
                                       {4, 6, 0.9, 1, false},
                                       {2, 3, 0.5, 1, false}};
  EXPECT_EQ(choose(settings, std::nullopt), 0U) << "precision before speed";
  EXPECT_EQ(choose(settings, 12), 0U) << "the budget itself is within it";
  EXPECT_EQ(choose(settings, 11.9), 1U) << "recall before precision";
  EXPECT_EQ(choose(settings, 10), 3U) << "of equals the fastest";
  EXPECT_EQ(choose(settings, 5), 4U) << "p95, not the median, has to keep the budget";
  EXPECT_EQ(choose(settings, 2.5), std::nullopt);
  EXPECT_EQ(choose({settings[2]}, std::nullopt), std::nullopt) << "none is guaranteed";
  EXPECT_EQ(fastest(settings), 4U);
  EXPECT_EQ(choose({{5, 6, 1, 1, false}, {6, 6, 1, 1, true}}, 7), 1U)
      << "a guarantee before speed, where what was measured is equal";
}

TEST(TradeStatistics, SpreadIsHowFarRepeatsReach) {
  const Spread spread = spreadAround(5, {4.5, 5.25, 4.75});
  EXPECT_EQ(spread.below, 0.5);
  EXPECT_EQ(spread.above, 0.25);
  EXPECT_EQ(spreadAround(5, {}).above, 0);
  const Worth a = {5, 6, 1, 1, true, {1, 1}}, b = {7, 8, 1, 1, true, {1, 0}},
              c = {9, 9, 1, 1, true, {0.5, 0}};
  EXPECT_TRUE(isMedianWithinNoise(a, b) && isMedianWithinNoise(b, a)) << "both reach 6";
  EXPECT_FALSE(isMedianWithinNoise(a, c) || isMedianWithinNoise(c, a));
  EXPECT_EQ(asFast({a, b, c}, 0), std::vector<std::size_t>{1});
}

TEST(TradeStatistics, WithinNoiseTheStricterIsChosen) {
  const Worth fast = {5, 6, 1, 1, true, {0.25, 0.25}, {}, 1};
  Worth exact = {5.5, 6, 1, 1, true, {0.25, 0.25}, {}, 5};
  EXPECT_EQ(choose({fast, exact}, 10), 1U);
  EXPECT_EQ(choose({fast, exact}, std::nullopt), 1U);
  exact.median_noise = {0.125, 0.25};
  EXPECT_EQ(choose({fast, exact}, 10), 0U) << "it is slower for sure";
  EXPECT_EQ(choose({fast, {5.5, 6, 1, 1, true, {1, 1}, {}, 1}}, 10), 0U) << "as strict: the faster";
}

TEST(TradeStatistics, WhatMissesTheBudgetByNoiseAloneGoesBeforeWhatIsLessExact) {
  const Worth loose = {4, 5, 0.9, 1, false, {}, {0.25, 0.5}};
  Worth exact = {4.5, 5.5, 1, 1, true, {}, {0.5, 0.5}};
  EXPECT_EQ(choose({loose, exact}, 5), 1U);
  EXPECT_EQ(choose({loose, exact}, 4.9), std::nullopt) << "nothing keeps that";
  exact.p95_noise.below = 0.25;
  EXPECT_EQ(choose({loose, exact}, 5), 0U) << "over the budget in every repeat";
  exact = {4.5, 5.8, 1, 1, true, {}, {0.8, 0.5}};
  EXPECT_EQ(choose({{4, 4.5, 0.9, 1, false, {}, {0.25, 0.25}}, exact}, 5), 0U)
      << "it can be told from it";
  EXPECT_EQ(choose({loose, {4.5, 5.5, 0.9, 1, false, {}, {0.5, 0.5}}}, 5), 0U) << "no more exact";
}

TEST(TradeStatistics, StrictnessIsOfPredicatesThenOfOverlap) {
  double before = -1;
  for (const Predicates predicates : {Predicates::kConservative, Predicates::kExact}) {
    for (const float overlap : {0.0F, 0.5F, 1.0F}) {
      Options options;
      options.predicates = predicates;
      options.overlap = overlap;
      EXPECT_GT(strictness(options), before);
      before = strictness(options);
    }
  }
}

TEST(TradeStatistics, NothingAllowedIsBetterThanTheChoice) {
  std::mt19937 random(4);
  for (int i = 0; i < kRandomCases; ++i) {
    const std::vector<Worth> settings = randomSettings(&random);
    const std::optional<double> budget =
        i % 4 == 0 ? std::nullopt : std::optional<double>(0.5 + (random() % 10) / 4.0);
    const auto allowed = [&](const Worth& w) {
      return budget ? w.p95_ms <= *budget : w.guaranteed;
    };
    const std::optional<std::size_t> chosen = choose(settings, budget);
    ASSERT_EQ(chosen.has_value(), std::any_of(settings.begin(), settings.end(), allowed));
    if (!chosen) continue;
    const Worth& best = settings[*chosen];
    ASSERT_TRUE(allowed(best));
    for (const Worth& w : settings) {
      if (!allowed(w)) continue;
      ASSERT_LE(w.recall, best.recall);
      if (w.recall < best.recall) continue;
      ASSERT_LE(w.precision, best.precision);
      if (w.precision < best.precision) continue;
      ASSERT_LE(w.guaranteed, best.guaranteed);
      if (w.guaranteed == best.guaranteed) {
        ASSERT_GE(w.median_ms, best.median_ms);
      }
    }
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
