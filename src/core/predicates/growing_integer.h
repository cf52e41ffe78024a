// Integers of any size, for values that do not fit into fixed ones. Host only. Different threads
// may use different objects.
#pragma once

#include <cstdint>
#include <vector>

namespace deformable_contact_monitor {

class GrowingInteger {
 public:
  GrowingInteger(std::int64_t value = 0);  // NOLINT(google-explicit-constructor): a number

  int sign() const { return size_ == 0 ? 0 : (negative_ ? -1 : 1); }

  GrowingInteger operator-() const;
  GrowingInteger operator+(const GrowingInteger& other) const;
  GrowingInteger operator-(const GrowingInteger& other) const { return *this + -other; }
  GrowingInteger operator*(const GrowingInteger& other) const;
  GrowingInteger operator<<(int bits) const;  // times 2^bits, bits >= 0

  // Returns floor(this / 2^bits), for a result that is not negative and less than 2^63.
  std::int64_t floored(int bits) const;

 private:
  // The words of the absolute value, least significant first; the last one is not zero. Small
  // values stay in few_.
  static constexpr int kFew = 8;
  std::uint64_t* resized(int size);
  const std::uint64_t* words() const { return many_.empty() ? few_ : many_.data(); }
  void trim();
  static int compareSizes(const GrowingInteger& a, const GrowingInteger& b);
  static GrowingInteger sumOfSizes(const GrowingInteger& a, const GrowingInteger& b);
  static GrowingInteger differenceOfSizes(const GrowingInteger& a, const GrowingInteger& b);

  std::uint64_t few_[kFew] = {};
  std::vector<std::uint64_t> many_;  // used instead of few_ unless it is empty
  int size_ = 0;
  bool negative_ = false;
};

}  // namespace deformable_contact_monitor
