// Numbers from an input's bytes. Every input is some sequence of numbers: where it ends, zeros
// follow.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

class ByteSource {
 public:
  // Views the bytes.
  ByteSource(const std::uint8_t* data, std::size_t size) : next_(data), left_(size) {}

  std::size_t left() const { return left_; }

  std::uint8_t byte() { return number<std::uint8_t>(); }

  // In [0, count); the next byte, so count <= 256.
  std::size_t below(std::size_t count) { return byte() % count; }

  bool flag() { return byte() % 2 == 1; }

  // The next bytes, in this machine's order.
  template <typename T>
  T number() {
    T value = 0;
    const std::size_t count = std::min(sizeof value, left_);
    if (count > 0) std::memcpy(&value, next_, count);
    skip(count);
    return value;
  }

  // Takes the next `count` bytes, or all that are left if there are fewer.
  std::vector<std::uint8_t> bytes(std::size_t count) {
    count = std::min(count, left_);
    std::vector<std::uint8_t> taken(next_, next_ + count);
    skip(count);
    return taken;
  }

  std::string text(std::size_t count) {
    const std::vector<std::uint8_t> taken = bytes(count);
    return std::string(taken.begin(), taken.end());
  }

  // A coordinate [m]: mostly on a small grid, where triangles touch, else what tries a predicate.
  float coordinate() {
    using Float = std::numeric_limits<float>;
    constexpr float kSpecial[] = {0.F,       -0.F,         Float::quiet_NaN(),  Float::infinity(),
                                  1e30F,     -1e30F,       Float::max(),        -Float::max(),
                                  1e-30F,    Float::min(), Float::denorm_min(), -Float::infinity(),
                                  1.000001F, 0.3333333F,   16777216.F,          1e6F};
    constexpr std::uint8_t kFirstSpecial = 216, kFirstRaw = 232;
    const std::uint8_t code = byte();
    if (code >= kFirstRaw) return number<float>();
    if (code >= kFirstSpecial) return kSpecial[code - kFirstSpecial];
    constexpr int kMiddle = 4, kSteps = 9;
    const int place = code % kSteps - kMiddle;
    return static_cast<float>(place) * (code < kFirstSpecial / 2 ? 0.25F : 0.1F);
  }

 private:
  void skip(std::size_t count) {
    next_ += count;
    left_ -= count;
  }

  const std::uint8_t* next_;
  std::size_t left_;
};

}  // namespace deformable_contact_monitor
