// Pieces of reserved memory.
#include "cuda/memory/reserved_memory.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kUnit = ReservedMemory::kAlignment, kUnits = 64, kAll = kUnits * kUnit;

class ReservedMemoryTest : public ::testing::Test {
 protected:
  // All of it is free, in one piece.
  void expectWhole() {
    EXPECT_TRUE(reserved_.isWhole());
    void* const all = reserved_.take(kAll);
    EXPECT_EQ(all, begin_);
    EXPECT_TRUE(reserved_.giveBack(all));
  }

  std::vector<char> memory_ = std::vector<char>(kAll);
  char* const begin_ = memory_.data();
  ReservedMemory reserved_{begin_, kAll};
};

TEST_F(ReservedMemoryTest, NoneHasNoPiece) {
  ReservedMemory none;
  EXPECT_EQ(none.take(1), nullptr);
  EXPECT_EQ(none.take(0), nullptr);
  EXPECT_FALSE(none.giveBack(begin_));
}

TEST_F(ReservedMemoryTest, AllOfItCanBeTakenOnce) {
  EXPECT_EQ(reserved_.take(kAll + 1), nullptr);
  EXPECT_EQ(reserved_.take(kAll), begin_);
  EXPECT_FALSE(reserved_.isWhole());
  EXPECT_EQ(reserved_.take(1), nullptr);
  EXPECT_TRUE(reserved_.giveBack(begin_));
  expectWhole();
}

TEST_F(ReservedMemoryTest, WhatIsNotItsOwnIsNotTakenBack) {
  void* const piece = reserved_.take(3 * kUnit);
  EXPECT_FALSE(reserved_.giveBack(begin_ + kUnit));
  EXPECT_TRUE(reserved_.giveBack(piece));
  EXPECT_FALSE(reserved_.giveBack(piece));
  expectWhole();
}

// As with new, also a piece of no bytes.
TEST_F(ReservedMemoryTest, EveryPieceHasAPlaceOfItsOwn) {
  void* const first = reserved_.take(0);
  EXPECT_NE(first, nullptr);
  EXPECT_NE(first, reserved_.take(0));
}

// A model of the free memory: a list of all units.
class Units {
 public:
  std::size_t longestFree() const {
    std::size_t longest = 0, run = 0;
    for (const bool taken : taken_) longest = std::max(longest, run = taken ? 0 : run + 1);
    return longest;
  }
  // Returns whether some were not as expected before.
  bool mark(std::size_t first, std::size_t count, bool taken) {
    bool wrong = first + count > taken_.size();
    for (std::size_t i = first; i < first + count && !wrong; ++i) {
      wrong = taken_[i] == taken;
      taken_[i] = taken;
    }
    return wrong;
  }

 private:
  std::vector<bool> taken_ = std::vector<bool>(kUnits);
};

struct Piece {
  char* begin;
  std::size_t bytes, units;
  char mark;

  bool isUntouched() const {
    return std::all_of(begin, begin + bytes, [this](char c) { return c == mark; });
  }
};

// A piece is refused where no such place is free, and only there; each keeps what is written to it.
TEST_F(ReservedMemoryTest, PiecesKeepApartAndComeTogetherAgain) {
  std::mt19937 random(5);
  std::vector<Piece> taken;
  Units units;
  std::size_t refused = 0;
  for (int i = 0; i < 4000; ++i) {
    if (random() % 2 == 0) {
      const std::size_t bytes = random() % (8 * kUnit);
      const std::size_t wanted = std::max<std::size_t>(1, (bytes + kUnit - 1) / kUnit);
      auto* const begin = static_cast<char*>(reserved_.take(bytes));
      ASSERT_EQ(begin == nullptr, wanted > units.longestFree());
      if (begin == nullptr) {
        ++refused;
        continue;
      }
      const auto at = static_cast<std::size_t>(begin - begin_);
      ASSERT_EQ(at % kUnit, 0U);
      ASSERT_FALSE(units.mark(at / kUnit, wanted, true));
      taken.push_back({begin, bytes, wanted, static_cast<char>(i)});
      std::memset(begin, taken.back().mark, bytes);
    } else if (!taken.empty()) {
      std::swap(taken[random() % taken.size()], taken.back());
      const Piece piece = taken.back();
      taken.pop_back();
      ASSERT_TRUE(piece.isUntouched());
      ASSERT_TRUE(reserved_.giveBack(piece.begin));
      units.mark(static_cast<std::size_t>(piece.begin - begin_) / kUnit, piece.units, false);
    }
  }
  EXPECT_GT(refused, 100U);
  for (const Piece& piece : taken) EXPECT_TRUE(reserved_.giveBack(piece.begin));
  expectWhole();
}

}  // namespace
}  // namespace deformable_contact_monitor
