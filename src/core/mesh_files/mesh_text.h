// Reads words and numbers from the text of a mesh file, and knows on which line they are. Words are
// separated by blanks. All text formats use it: OBJ, OFF, ascii STL, ascii PLY and the header of
// every PLY file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace deformable_contact_monitor {

// Selects the syntax that a format has in addition to words and lines.
struct MeshTextRules {
  bool hash_comments = false;        // '#' begins a comment that ends with its line
  bool backslash_continues = false;  // a line whose last character is '\' goes on in the next
};

// A cursor in the text of a mesh file. `path` and `text` must outlive it. Lines end with LF or CRLF
// and are counted up from `first_line`.
class MeshText {
 public:
  MeshText(const std::string& path, std::string_view text, MeshTextRules rules,
           std::size_t first_line = 1);

  // Returns the next word of this line; empty at the end of the line. The result is a view of the
  // file's text.
  std::string_view word();

  // Returns the next word, on this line or a later one; empty at the end of the text.
  std::string_view wordOnAnyLine();

  // Skips the rest of this line and goes to the next line that has a word. Returns false if there
  // is none.
  bool nextLine();

  // Skips blanks, empty lines and comments. Returns false at the end of the text.
  bool skipToWord();

  // Returns the next word of this line as the nearest float32. Numbers beyond its range become
  // infinity, and numbers below it a zero with the text's sign. "nan" and "inf" may have all of C's
  // spellings, and those of Windows programs ("1.#QNAN", "-1.#IND", "1.#INF"), whose '#' begins no
  // comment. Throws if there is no number; `what` names it in the message.
  float real(const char* what);

  // Returns the next word of this line as an integer in [0, limit). Throws if there is none.
  std::uint64_t count(const char* what, std::uint64_t limit);

  // Skips blanks and returns whether this line has no more words. Comments are no words.
  bool atLineEnd();

  // Return how many characters are before the cursor, and after it.
  std::size_t offset() const { return static_cast<std::size_t>(at_ - begin_); }
  std::size_t remaining() const { return static_cast<std::size_t>(end_ - at_); }

  std::size_t line() const { return line_; }

  // Throw std::runtime_error, "<path>:<line>: <what>", for this line or another one.
  [[noreturn]] void fail(const std::string& what) const { failOnLine(line_, what); }
  [[noreturn]] void failOnLine(std::size_t line, const std::string& what) const;

  // Throws in the same way because a word is not what was wanted. An empty word means that the line
  // ended.
  [[noreturn]] void failAt(std::string_view word, const std::string& wanted) const;

 private:
  bool isDelimiter(const char* p) const;
  bool isInSpecial(const char* first) const;
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

// Returns the word in quotes, shortened and with unprintable bytes as '?', so that messages stay on
// one line.
std::string quoted(std::string_view word);

// Returns whether two words are equal apart from the case of ASCII letters.
bool equalIgnoringCase(std::string_view a, std::string_view b);

}  // namespace deformable_contact_monitor
