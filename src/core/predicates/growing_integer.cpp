#include "core/predicates/growing_integer.h"

namespace deformable_contact_monitor {
namespace {

__extension__ using Word2 = unsigned __int128;

}  // namespace

GrowingInteger::GrowingInteger(std::int64_t value) : negative_(value < 0) {
  few_[0] = negative_ ? 0 - static_cast<std::uint64_t>(value) : static_cast<std::uint64_t>(value);
  size_ = few_[0] != 0 ? 1 : 0;
}

std::uint64_t* GrowingInteger::resized(int size) {
  size_ = size;
  if (size <= kFew) return few_;
  many_.assign(static_cast<std::size_t>(size), 0);
  return many_.data();
}

void GrowingInteger::trim() {
  const std::uint64_t* const w = words();
  while (size_ > 0 && w[size_ - 1] == 0) --size_;
}

GrowingInteger GrowingInteger::operator-() const {
  GrowingInteger result = *this;
  result.negative_ = !negative_;
  return result;
}

// Compares absolute values.
int GrowingInteger::compareSizes(const GrowingInteger& a, const GrowingInteger& b) {
  if (a.size_ != b.size_) return a.size_ < b.size_ ? -1 : 1;
  for (int i = a.size_ - 1; i >= 0; --i) {
    if (a.words()[i] != b.words()[i]) return a.words()[i] < b.words()[i] ? -1 : 1;
  }
  return 0;
}

// Returns |a| + |b|.
GrowingInteger GrowingInteger::sumOfSizes(const GrowingInteger& a, const GrowingInteger& b) {
  const GrowingInteger &longer = a.size_ < b.size_ ? b : a, &shorter = a.size_ < b.size_ ? a : b;
  GrowingInteger result;
  std::uint64_t* const out = result.resized(longer.size_ + 1);
  std::uint64_t carry = 0;
  for (int i = 0; i < longer.size_; ++i) {
    const Word2 sum =
        Word2{longer.words()[i]} + (i < shorter.size_ ? shorter.words()[i] : 0) + carry;
    out[i] = static_cast<std::uint64_t>(sum);
    carry = static_cast<std::uint64_t>(sum >> 64);
  }
  out[longer.size_] = carry;
  result.trim();
  return result;
}

// Returns |a| - |b|, for |a| >= |b|.
GrowingInteger GrowingInteger::differenceOfSizes(const GrowingInteger& a, const GrowingInteger& b) {
  GrowingInteger result;
  std::uint64_t* const out = result.resized(a.size_);
  std::uint64_t borrow = 0;
  for (int i = 0; i < a.size_; ++i) {
    const Word2 difference = Word2{a.words()[i]} - (i < b.size_ ? b.words()[i] : 0) - borrow;
    out[i] = static_cast<std::uint64_t>(difference);
    borrow = static_cast<std::uint64_t>(difference >> 64) != 0 ? 1 : 0;
  }
  result.trim();
  return result;
}

GrowingInteger GrowingInteger::operator+(const GrowingInteger& other) const {
  GrowingInteger result;
  if (negative_ == other.negative_) {
    result = sumOfSizes(*this, other);
    result.negative_ = negative_;
  } else if (compareSizes(*this, other) >= 0) {
    result = differenceOfSizes(*this, other);
    result.negative_ = negative_;
  } else {
    result = differenceOfSizes(other, *this);
    result.negative_ = other.negative_;
  }
  return result;
}

GrowingInteger GrowingInteger::operator*(const GrowingInteger& other) const {
  GrowingInteger result;
  if (size_ == 0 || other.size_ == 0) return result;
  std::uint64_t* const out = result.resized(size_ + other.size_);
  for (int i = 0; i < size_; ++i) {
    std::uint64_t carry = 0;
    for (int j = 0; j < other.size_; ++j) {
      const Word2 sum = Word2{words()[i]} * other.words()[j] + out[i + j] + carry;
      out[i + j] = static_cast<std::uint64_t>(sum);
      carry = static_cast<std::uint64_t>(sum >> 64);
    }
    out[i + other.size_] = carry;
  }
  result.negative_ = negative_ != other.negative_;
  result.trim();
  return result;
}

GrowingInteger GrowingInteger::operator<<(int bits) const {
  GrowingInteger result;
  if (size_ == 0) return result;
  const int skipped = bits / 64, shift = bits % 64;
  std::uint64_t* const out = result.resized(size_ + skipped + 1);
  for (int i = 0; i < size_; ++i) {
    const Word2 word = Word2{words()[i]} << shift;
    out[i + skipped] |= static_cast<std::uint64_t>(word);
    out[i + skipped + 1] = static_cast<std::uint64_t>(word >> 64);
  }
  result.negative_ = negative_;
  result.trim();
  return result;
}

std::int64_t GrowingInteger::floored(int bits) const {
  const int skipped = bits / 64, shift = bits % 64;
  const std::uint64_t low = skipped < size_ ? words()[skipped] : 0;
  const std::uint64_t high = skipped + 1 < size_ ? words()[skipped + 1] : 0;
  return static_cast<std::int64_t>(
      static_cast<std::uint64_t>(((Word2{high} << 64) | low) >> shift));
}

}  // namespace deformable_contact_monitor
