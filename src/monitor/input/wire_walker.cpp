// A walker over a serialized ROS message: it checks the message's length fields.
#include "monitor/input/wire_walker.h"

#include <cstring>

namespace deformable_contact_monitor {

std::uint32_t WireWalker::word(const char* field) {
  std::uint32_t value = 0;
  if (left_ < sizeof value) return fail(std::string("the message ends before ") + field);
  std::memcpy(&value, next_, sizeof value);
  advance(sizeof value);
  return value;
}

void WireWalker::skip(const char* field, std::size_t bytes) {
  if (bytes > left_) {
    fail(std::string("the message ends within ") + field);
    return;
  }
  advance(bytes);
}

void WireWalker::array(const char* field, std::size_t item_bytes) {
  const std::size_t items = count(field, item_bytes);
  advance(items * item_bytes);
}

void WireWalker::texts(const char* field) {
  for (std::uint32_t left = count(field, sizeof(std::uint32_t)); left > 0; --left) array(field, 1);
}

// The product is computed in 64 bits. In 32 bits it can wrap to a small number, and roscpp's own
// check is misled in this way.
std::uint32_t WireWalker::count(const char* field, std::size_t least_bytes) {
  const std::uint64_t items = word(field);
  if (items * least_bytes <= left_) return static_cast<std::uint32_t>(items);
  return fail(std::string(field) + " claims " + std::to_string(items * least_bytes) +
              " bytes, but " + std::to_string(left_) + " are there");
}

void WireWalker::header() {
  word("header.seq");
  word("header.stamp");
  word("header.stamp");
  array("header.frame_id", 1);
}

void WireWalker::advance(std::size_t bytes) {
  next_ += bytes;
  left_ -= bytes;
}

std::uint32_t WireWalker::fail(const std::string& problem) {
  if (problem_.empty()) problem_ = problem;
  left_ = 0;
  return 0;
}

}  // namespace deformable_contact_monitor
