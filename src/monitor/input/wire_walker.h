// A walker over a serialized ROS message: it checks the message's length fields, and allocates
// nothing. roscpp's own reader reserves what an array claims to hold before it looks whether those
// bytes were sent: a message of 5 KB can make it reserve 16 GB. So meshes, link meshes and
// questions from topics, and all that is read from bags, pass this walker before roscpp reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace deformable_contact_monitor {

// Walks over the fields of one message in their order: little endian, each array behind its length
// (uint32). After the first field that does not fit, nothing is left and every call returns 0, so
// that a caller may check problem() once, at the end.
class WireWalker {
 public:
  // The bytes must outlive this.
  WireWalker(const std::uint8_t* bytes, std::size_t size) : next_(bytes), left_(size) {}

  // Reads a uint32. `field` is the field's name in problem(), here and below.
  std::uint32_t word(const char* field);
  // Skips fields of a fixed size [bytes].
  void skip(const char* field, std::size_t bytes);
  // Skips an array, or a string (items of 1 byte), with its length.
  void array(const char* field, std::size_t item_bytes);
  // Skips an array of strings.
  void texts(const char* field);
  // Reads the length of an array whose items have different sizes; the caller walks over the items.
  // Fails if fewer than `least_bytes` for each item are left, which bounds the caller's loop.
  std::uint32_t count(const char* field, std::size_t least_bytes);
  // Skips a std_msgs/Header.
  void header();
  // Refuses the message for what its fields say.
  void reject(const std::string& problem) { fail(problem); }

  // Returns the bytes that follow the fields so far.
  std::size_t left() const { return left_; }
  // Returns what was wrong with the first field that did not fit; empty: nothing.
  const std::string& problem() const { return problem_; }

 private:
  void advance(std::size_t bytes);
  std::uint32_t fail(const std::string& problem);

  const std::uint8_t* next_;
  std::size_t left_;
  std::string problem_;
};

}  // namespace deformable_contact_monitor
