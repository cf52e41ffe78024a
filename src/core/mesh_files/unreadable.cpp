// Recognises files that are no mesh by how they begin: what a failed download, a checkout without
// Git LFS, or an editor leaves in the place of a mesh file.
#include <algorithm>
#include <utility>

#include "core/mesh_files/mesh_readers.h"
#include "core/mesh_files/mesh_text.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether the text begins like that, whatever the case of its letters.
bool beginsLike(std::string_view text, std::string_view start) {
  return equalIgnoringCase(text.substr(0, start.size()), start);
}

// Returns whether there is such a tag among the first characters. Others may be before it: an XML
// declaration, comments, blanks.
bool hasTag(std::string_view text, std::string_view tag) {
  constexpr std::size_t kLooked = 1024;
  text = text.substr(0, kLooked);
  for (std::size_t i = text.find('<'); i < text.size(); i = text.find('<', i + 1)) {
    if (beginsLike(text.substr(i), tag)) return true;
  }
  return false;
}

// Returns whether the text looks like UTF-16 without a mark: nearly every second byte is zero, as
// in ASCII letters of 16 bits.
bool looksWide(std::string_view text) {
  constexpr std::size_t kLooked = 256;
  text = text.substr(0, std::min(text.size(), kLooked));
  std::size_t zeros[2] = {0, 0};
  for (std::size_t i = 0; i < text.size(); ++i) zeros[i % 2] += text[i] == '\0' ? 1 : 0;
  const std::size_t half = text.size() / 2;
  return half >= 4 && std::max(zeros[0], zeros[1]) * 10 >= half * 9 &&
         std::min(zeros[0], zeros[1]) * 10 <= half;
}

using std::string_view_literals::operator""sv;  // NOLINT(misc-unused-using-decls): kArchives' own

// The first bytes of archives, in small letters.
constexpr std::pair<std::string_view, const char*> kArchives[] = {
    {"pk\3\4"sv, "a zip archive"},
    {"pk\5\6"sv, "a zip archive"},
    {"\x1f\x8b"sv, "a gzip archive"},
    {"bzh"sv, "a bzip2 archive"},
    {"\xfd\x37zxz\0"sv, "an xz archive"},
    {"\x28\xb5\x2f\xfd"sv, "a zstd archive"},
    {"7z\xbc\xaf\x27\x1c"sv, "a 7z archive"},
    {"rar!\x1a\7"sv, "a rar archive"}};

// Returns the kind of an archive; null if the content is none.
const char* archiveKind(std::string_view content) {
  for (const auto& [start, kind] : kArchives) {
    if (beginsLike(content, start)) return kind;
  }
  constexpr std::size_t kTarMark = 257;
  return content.substr(0, 512).find("ustar") == kTarMark ? "a tar archive" : nullptr;
}

// Returns the encoding of a text of wide characters; null if it is none.
const char* wideEncoding(std::string_view content) {
  if (beginsLike(content, "\xff\xfe\0\0"sv) || beginsLike(content, "\0\0\xfe\xff"sv)) {
    return "UTF-32";
  }
  const bool has_mark = beginsLike(content, "\xff\xfe"sv) || beginsLike(content, "\xfe\xff"sv);
  return has_mark || looksWide(content) ? "UTF-16" : nullptr;
}

}  // namespace

std::string unreadableBecause(std::string_view content) {
  constexpr std::string_view kBlanks = " \t\r\n\v\f\0"sv;
  if (content.empty()) return "is empty";
  if (content.find_first_not_of(kBlanks) == std::string_view::npos) {
    return "holds nothing but blanks or zero bytes";
  }
  if (const char* const encoding = wideEncoding(content)) {
    return std::string("is ") + encoding + " text; save it as UTF-8";
  }
  if (const char* const kind = archiveKind(content)) {
    return std::string("is ") + kind + ", not the file itself; unpack it first";
  }
  std::string_view text = content;
  if (beginsLike(text, "\xef\xbb\xbf"sv)) text.remove_prefix(3);  // a byte order mark
  text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
  if (beginsLike(text, "version https://git-lfs"sv)) {
    return "is a Git LFS pointer, not the file that it stands for; get that with 'git lfs pull'";
  }
  const bool is_markup = text.substr(0, 1) == "<"sv;
  if (is_markup && (hasTag(text, "<!doctype html"sv) || hasTag(text, "<html"sv))) {
    return "is an HTML page, as a failed download leaves; download the file itself";
  }
  return "";
}

}  // namespace deformable_contact_monitor
