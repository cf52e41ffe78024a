// Scans text for the mesh readers. Numbers are read by the rules of the C locale, whatever locale
// the process uses: "1.5" must mean the same on a machine whose decimal separator is a comma. Most
// of the time goes into the loops over characters, so they test for ordinary characters first.
#include "core/mesh_files/mesh_text.h"

#include <locale.h>
#include <stdlib.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <optional>
#include <stdexcept>
#include <system_error>

namespace deformable_contact_monitor {
namespace {

// Returns whether a character separates words within a line. CR does, so CRLF ends a line like LF.
bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
// Returns whether the character certainly does not end a word. This spares the slower tests for
// almost every character.
bool isOrdinary(char c) { return static_cast<unsigned char>(c) > ' ' && c != '#' && c != '\\'; }
bool isDigit(char c) { return c >= '0' && c <= '9'; }
// Changes ASCII letters only. std::tolower would depend on the locale.
char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Returns whether a number begins with 0x, after its sign.
bool isHexadecimal(std::string_view number) {
  const std::size_t digits = number.find_first_not_of("+-");
  return digits + 1 < number.size() && number[digits] == '0' && lower(number[digits + 1]) == 'x';
}

// Windows programs write numbers that are not finite as "1.#QNAN", "-1.#IND00" or "1.#INF".
constexpr std::string_view kSpecialStart = "1.#";

std::string_view withoutSign(std::string_view word) {
  return word.substr(!word.empty() && (word[0] == '+' || word[0] == '-') ? 1 : 0);
}

// Returns the number that such a word spells; nothing if it is not one. Padding as in
// "1.#QNAN0e+000" may follow the name.
std::optional<float> toSpecial(std::string_view word) {
  std::string_view name = withoutSign(word);
  if (name.substr(0, kSpecialStart.size()) != kSpecialStart) return std::nullopt;
  name.remove_prefix(kSpecialStart.size());
  for (const std::string_view known : {"INF", "IND", "QNAN", "SNAN"}) {
    if (!equalIgnoringCase(name.substr(0, known.size()), known)) continue;
    name.remove_prefix(known.size());
    if (name.find_first_not_of("0123456789+-eE") != std::string_view::npos) return std::nullopt;
    if (known != "INF") return std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    return word[0] == '-' ? -infinity : infinity;
  }
  return std::nullopt;
}

// Returns the number that all of `word` spells, as real() says; nothing if it is no number. strtof
// rounds correctly, but needs a NUL after its text, and it accepts hexadecimal numbers, which mesh
// files do not have.
std::optional<float> toFloat(std::string_view word) {
  static const locale_t kClassic = newlocale(LC_ALL_MASK, "C", nullptr);
  char copy[64];
  std::string longer;
  const char* text = copy;
  if (word.size() < sizeof copy) {
    *std::copy(word.begin(), word.end(), copy) = '\0';
  } else {
    longer = word;
    text = longer.c_str();
  }
  char* end = nullptr;
  const float value = strtof_l(text, &end, kClassic);
  const bool is_number = !word.empty() && end == text + word.size() && !isHexadecimal(word);
  return is_number ? std::optional<float>(value) : toSpecial(word);
}

}  // namespace

std::string quoted(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string text = "'";
  for (const char c : word.substr(0, kLongest)) text += c >= ' ' && c <= '~' ? c : '?';
  return text + (word.size() > kLongest ? "...'" : "'");
}

bool equalIgnoringCase(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(),
                                            [](char x, char y) { return lower(x) == lower(y); });
}

MeshText::MeshText(const std::string& path, std::string_view text, MeshTextRules rules,
                   std::size_t first_line)
    : path_(path),
      begin_(text.data()),
      at_(begin_),
      end_(begin_ + text.size()),
      line_(first_line),
      rules_(rules) {
  // Some editors put a byte order mark in front of UTF-8 text. It is no part of the first word.
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) at_ += kByteOrderMark.size();
}

void MeshText::failOnLine(std::size_t line, const std::string& what) const {
  throw std::runtime_error(path_ + ":" + std::to_string(line) + ": " + what);
}

void MeshText::failAt(std::string_view word, const std::string& wanted) const {
  const char* ending = at_ == end_ ? "the file ends" : "the line ends";
  fail(wanted + " expected, but " + (word.empty() ? ending : "there is " + quoted(word)));
}

// Returns the character after a backslash and a line end at p; null if these are not at p.
const char* MeshText::continuation(const char* p) const {
  if (!rules_.backslash_continues || p == end_ || *p != '\\') return nullptr;
  ++p;
  if (p != end_ && *p == '\r') ++p;
  return p != end_ && *p == '\n' ? p + 1 : nullptr;
}

// Returns whether a word ends before p.
bool MeshText::isDelimiter(const char* p) const {
  return p == end_ || isBlank(*p) || *p == '\n' || (*p == '#' && rules_.hash_comments) ||
         (*p == '\\' && continuation(p) != nullptr);
}

// Goes on to the next word, comment or line end. A continued line counts as part of this line, but
// the line number goes up, so that messages name the right line of the file.
void MeshText::skipBlanks() {
  while (at_ != end_ && !isOrdinary(*at_)) {
    if (isBlank(*at_)) {
      ++at_;
    } else if (const char* next_line = continuation(at_)) {
      at_ = next_line;
      ++line_;
    } else {
      return;
    }
  }
}

bool MeshText::atLineEnd() {
  skipBlanks();
  return at_ == end_ || *at_ == '\n' || (*at_ == '#' && rules_.hash_comments);
}

// Stops before the line's LF. A comment ends with its line even if a backslash is its last
// character.
void MeshText::skipRestOfLine() {
  while (!atLineEnd()) word();
  at_ = std::find(at_, end_, '\n');
}

bool MeshText::skipToWord() {
  while (atLineEnd()) {
    at_ = std::find(at_, end_, '\n');
    if (at_ == end_) return false;
    ++at_;
    ++line_;
  }
  return true;
}

bool MeshText::nextLine() {
  skipRestOfLine();
  return skipToWord();
}

std::string_view MeshText::word() {
  if (atLineEnd()) return {};
  const char* first = at_;
  while (at_ != end_ && (isOrdinary(*at_) || !isDelimiter(at_) || isInSpecial(first))) ++at_;
  return {first, static_cast<std::size_t>(at_ - first)};
}

// Returns whether the cursor is at the '#' of a number such as "1.#QNAN", which begins at `first`,
// and not at a comment after "1.".
bool MeshText::isInSpecial(const char* first) const {
  if (*at_ != '#' || at_ + 1 == end_ || lower(at_[1]) < 'a' || lower(at_[1]) > 'z') return false;
  const std::string_view word(first, static_cast<std::size_t>(at_ + 1 - first));
  return withoutSign(word) == kSpecialStart;
}

std::string_view MeshText::wordOnAnyLine() { return skipToWord() ? word() : std::string_view(); }

float MeshText::real(const char* what) {
  const std::string_view text = word();
  const std::optional<float> value = toFloat(text);
  if (!value) failAt(text, what);
  return *value;
}

std::uint64_t MeshText::count(const char* what, std::uint64_t limit) {
  if (atLineEnd()) failAt({}, what);
  std::uint64_t value = 0;
  // std::from_chars does not depend on the locale, and reports numbers beyond 64 bits. It accepts
  // no '+', so that is skipped. A word such as "-3" is an integer that is out of range, not a wrong
  // word.
  const auto parsed = std::from_chars(at_ + (*at_ == '+' ? 1 : 0), end_, value);
  const bool is_number = parsed.ec != std::errc::invalid_argument && isDelimiter(parsed.ptr);
  if (!is_number && !(*at_ == '-' && at_ + 1 != end_ && isDigit(at_[1]))) failAt(word(), what);
  if (!is_number || parsed.ec != std::errc() || value >= limit) {
    fail(std::string(what) + " " + quoted(word()) + " is out of range, must be in [0, " +
         std::to_string(limit) + ")");
  }
  at_ = parsed.ptr;
  return value;
}

}  // namespace deformable_contact_monitor
