// Parses XML texts with tinyxml2, which accepts nothing but blanks ahead of the XML declaration.
#include "robot/xml_text.h"

#include <algorithm>
#include <string_view>

#include "core/mesh_files/mesh_readers.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool startsAt(std::string_view text, std::size_t at, std::string_view start) {
  return text.substr(std::min(at, text.size()), start.size()) == start;
}

// Returns the text with blanks in the place of comments that are ahead of its XML declaration. Line
// ends stay. A text without a declaration, or with anything else ahead of it, is not changed.
std::string withoutLeadingComments(const std::string& text) {
  std::string changed = text;
  std::size_t at = startsAt(text, 0, kByteOrderMark) ? kByteOrderMark.size() : 0;
  while (true) {
    at = std::min(text.find_first_not_of(kBlanks, at), text.size());
    if (startsAt(text, at, "<?xml") && at + 5 < text.size() &&
        kBlanks.find(text[at + 5]) != std::string_view::npos) {
      return changed;
    }
    const bool is_comment = startsAt(text, at, "<!--");
    if (!is_comment && !startsAt(text, at, "<?")) return text;
    const std::size_t end = is_comment ? text.find("-->", at + 4) : text.find("?>", at);
    if (end == std::string::npos) return text;
    const std::size_t next = end + (is_comment ? 3 : 2);
    for (; at < next; ++at) {
      if (is_comment && text[at] != '\n' && text[at] != '\r') changed[at] = ' ';
    }
  }
}

}  // namespace

std::optional<XmlError> parseXml(const std::string& text, tinyxml2::XMLDocument* document) {
  const std::string parsed = withoutLeadingComments(text);
  const bool is_xml = document->Parse(parsed.data(), parsed.size()) == tinyxml2::XML_SUCCESS;
  const std::string kind = unreadableBecause(text);
  if (!kind.empty()) return XmlError{1, kind};
  if (is_xml) return std::nullopt;
  return XmlError{std::max(document->ErrorLineNum(), 1),
                  std::string("not well-formed XML: ") + document->ErrorName()};
}

}  // namespace deformable_contact_monitor
