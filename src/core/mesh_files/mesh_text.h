// A cursor over the text of a mesh file: words, numbers, and the line they stand on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace deformable_contact_monitor {

struct MeshTextRules {
  bool hash_comments = false;        // '#' begins a comment that ends with its line
  bool backslash_continues = false;  // a line whose last character is '\' goes on in the next
};

// Views `path` and `text`, which must outlive it. Lines end with LF or CRLF and are counted up from
// `first_line`.
class MeshText {
 public:
  MeshText(const std::string& path, std::string_view text, MeshTextRules rules,
           std::size_t first_line = 1);

  // The next word of this line; empty at its end.
  std::string_view word();

  // The next word, on this line or a later one; empty at the end of the text.
  std::string_view wordOnAnyLine();

  // Skips to the next line that has a word on it, from wherever this line stands; false if there
  // is none.
  bool nextLine();

  // Skips blanks, empty lines and comments; false at the end of the text.
  bool skipToWord();

  // The next word of this line as the nearest float32: infinity beyond its range, a zero of the
  // text's sign below; "nan" and "inf" in C's spellings. Throws if there is none; `what` says what
  // was wanted.
  float real(const char* what);

  // The next word of this line as an integer in [0, limit). Throws if there is none.
  std::uint64_t count(const char* what, std::uint64_t limit);

  bool atLineEnd();

  // Where the cursor stands.
  std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

  std::size_t line() const { return line_; }

  // Throws std::runtime_error, "<path>:<line>: <what>", for this line or another.
  [[noreturn]] void fail(const std::string& what) const { failOnLine(line_, what); }
  [[noreturn]] void failOnLine(std::size_t line, const std::string& what) const;

  // The same for a word that is not what was wanted (empty: the line ended).
  [[noreturn]] void failAt(std::string_view word, const std::string& wanted) const;

 private:
  bool isDelimiter(const char* p) const;
  const char* continuation(const char* p) const;
  void skipBlanks();
  void skipRestOfLine();

  const std::string& path_;
  const char* begin_;
  const char* at_;
  const char* end_;
  std::size_t line_;
  MeshTextRules rules_;
};

// "'abc'", shortened and with unprintable bytes as '?', so that a message stays one line.
std::string quoted(std::string_view word);

bool equalIgnoringCase(std::string_view a, std::string_view b);

}  // namespace deformable_contact_monitor
