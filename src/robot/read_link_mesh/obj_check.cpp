// What Assimp takes on trust in an OBJ file.
#include "robot/read_link_mesh/obj_check.h"

#include <algorithm>
#include <stdexcept>

#include "robot/read_link_mesh/index_text.h"

namespace deformable_contact_monitor {
namespace {

constexpr char kDigits[] = "0123456789";

// Of text[first, last).
void checkFace(const std::string& text, std::size_t first, std::size_t last, std::size_t line) {
  for (std::size_t at = text.find_first_of(kDigits, first); at < last;
       at = text.find_first_of(kDigits, at)) {
    const std::size_t end = std::min(text.find_first_not_of(kDigits, at), last);
    const std::string number = text.substr(at, end - at);
    if (!isIndex(number)) {
      throw std::runtime_error("line " + std::to_string(line) + ": a face has " +
                               shortened(number) + ", which is no index");
    }
    at = end;
  }
}

}  // namespace

void checkObj(const std::string& text) {
  bool is_face = false, continues = false;
  std::size_t line = 1;
  for (std::size_t first = 0; first < text.size(); ++line) {
    const std::size_t last = std::min(text.find('\n', first), text.size());
    if (!continues) {
      const std::size_t start = text.find_first_not_of(" \t", first);
      is_face = start < last && text[start] == 'f';
    }
    if (is_face) checkFace(text, first, last, line);
    const std::size_t end = text.find_last_not_of(" \t\r", last == first ? first : last - 1);
    continues = end != std::string::npos && end >= first && end < last && text[end] == '\\';
    first = last + 1;
  }
}

}  // namespace deformable_contact_monitor
