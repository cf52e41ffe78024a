// Checks a COLLADA text. It walks through the whole XML tree with tinyxml2, since the elements with
// numbers may be at many places.
#include "robot/read_link_mesh/check_collada.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "robot/xml_text.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether `text` is a number from 0 to 2^31 - 1, which fits every reader's integer.
bool isIndex(const std::string& text) {
  const std::string digits = text.substr(std::min(text.find_first_not_of('0'), text.size()));
  const bool is_digits = text.find_first_not_of("0123456789") == std::string::npos;
  const std::string largest = "2147483647";
  return !text.empty() && is_digits &&
         (digits.size() < largest.size() || (digits.size() == largest.size() && digits <= largest));
}

// Returns the start of a text for a message; the text may be as long as the file.
std::string shortened(const std::string& text) {
  constexpr std::size_t kShown = 40;
  return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
}

using tinyxml2::XMLElement;

[[noreturn]] void fail(int line, const std::string& what) {
  throw std::runtime_error("line " + std::to_string(line) + ": " + what);
}

// Returns the attribute as a number, `missing` where there is none. A malformed number is an error.
std::uint32_t number(const XMLElement& element, const char* attribute, std::uint32_t missing) {
  const char* text = element.Attribute(attribute);
  if (text == nullptr) return missing;
  unsigned value = 0;
  const bool is_digits = *text != '\0' && std::all_of(text, text + std::strlen(text), [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
  });
  if (!is_digits || element.QueryUnsignedAttribute(attribute, &value) != tinyxml2::XML_SUCCESS) {
    fail(element.GetLineNum(), std::string(attribute) + "=\"" + text + "\" is no count");
  }
  return value;
}

// Checks the lists of indices of a document, and collects its arrays and accessors.
class Visitor : public tinyxml2::XMLVisitor {
 public:
  bool VisitEnter(const XMLElement& element, const tinyxml2::XMLAttribute*) override {
    const std::string name = element.Name();
    // <p> and <h> have the indices of faces and of holes, <vcount> the corner counts of polygons.
    // <v> belongs to skins, and may use -1 for the shape that is not deformed.
    if (name == "p" || name == "vcount" || name == "h") {
      requireIndices(element);
    } else if (name == "v") {
      requireIntegers(element);
    } else if (name == "float_array") {
      const char* id = element.Attribute("id");
      const std::uint32_t size = number(element, "count", 0);
      if (id == nullptr) return true;
      // Two arrays with the same id are an error in the file. The smaller size is safe for both.
      const auto [entry, is_new] = array_sizes_.emplace(id, size);
      if (!is_new) entry->second = std::min(entry->second, size);
    } else if (name == "accessor") {
      accessors_.push_back(&element);
    } else if (name == "unit") {
      requireLength(element);
    } else if (name == "skew") {
      fail(element.GetLineNum(),
           "<skew> is not supported; export the mesh with its transforms applied");
    }
    return true;
  }

  // Compares each accessor with its array. Called after the whole document was visited.
  void checkAccessors() const {
    for (const XMLElement* accessor : accessors_) {
      const char* source = accessor->Attribute("source");
      const auto array = array_sizes_.find(source != nullptr && *source == '#' ? source + 1 : "");
      if (array == array_sizes_.end()) continue;
      std::uint64_t params = 0;
      for (const XMLElement* e = accessor->FirstChildElement("param"); e != nullptr;
           e = e->NextSiblingElement("param")) {
        ++params;
      }
      const std::uint64_t count = number(*accessor, "count", 0);
      const std::uint64_t stride = number(*accessor, "stride", 1);
      const std::uint64_t offset = number(*accessor, "offset", 0);
      if (count == 0) continue;
      // Items begin `stride` numbers apart, and the last one must have all of its parameters.
      const std::uint64_t needed = offset + (count - 1) * stride + std::max(stride, params);
      if (needed > array->second) {
        fail(accessor->GetLineNum(), "an accessor needs " + std::to_string(needed) +
                                         " numbers, but array '" + array->first + "' has " +
                                         std::to_string(array->second));
      }
    }
  }

 private:
  // Assimp would read a length with blanks around it as 1 m.
  static void requireLength(const XMLElement& unit) {
    const char* const meter = unit.Attribute("meter");
    if (meter == nullptr) return;
    double length_m = 0;
    const bool is_plain =
        std::string(meter).find_first_not_of("0123456789.eE+-") == std::string::npos;
    if (is_plain && tinyxml2::XMLUtil::ToDouble(meter, &length_m) && length_m > 0) return;
    fail(unit.GetLineNum(),
         "<unit meter=\"" + shortened(meter) + "\"> is no length above 0 written without blanks");
  }

  // Assimp would read a negative index or a signed count as 0, and a large one modulo 2^32.
  static void requireIndices(const XMLElement& list) {
    for (const tinyxml2::XMLNode* n = list.FirstChild(); n != nullptr; n = n->NextSibling()) {
      if (n->ToText() == nullptr) continue;
      std::istringstream numbers(n->Value());
      for (std::string text; numbers >> text;) {
        if (isIndex(text)) continue;
        const bool is_integer = text.find_first_not_of("0123456789+-") == std::string::npos;
        fail(list.GetLineNum(),
             std::string("<") + list.Name() + "> holds " +
                 (is_integer ? shortened(text) + ", which is no index" : "more than integers"));
      }
    }
  }

  // Negative integers are allowed here; see VisitEnter().
  static void requireIntegers(const XMLElement& list) {
    for (const tinyxml2::XMLNode* n = list.FirstChild(); n != nullptr; n = n->NextSibling()) {
      if (n->ToText() == nullptr) continue;
      const std::string text = n->Value();
      if (text.find_first_not_of("0123456789+- \t\r\n") != std::string::npos) {
        fail(list.GetLineNum(), std::string("<") + list.Name() + "> holds more than integers");
      }
    }
  }

  std::map<std::string, std::uint32_t> array_sizes_;
  std::vector<const XMLElement*> accessors_;
};

}  // namespace

void checkCollada(const std::string& text) {
  tinyxml2::XMLDocument document;
  if (const auto error = parseXml(text, &document)) fail(error->line, error->what);
  Visitor visitor;
  document.Accept(&visitor);
  visitor.checkAccessors();
}

}  // namespace deformable_contact_monitor
