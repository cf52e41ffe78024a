// What Assimp takes on trust in a COLLADA file.
#include "robot/read_link_mesh/collada_check.h"

#include <tinyxml2.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "robot/read_link_mesh/collada_references.h"
#include "robot/read_link_mesh/index_text.h"

namespace deformable_contact_monitor {
namespace {

using tinyxml2::XMLElement;

[[noreturn]] void fail(int line, const std::string& what) {
  throw std::runtime_error("line " + std::to_string(line) + ": " + what);
}

// `missing` where there is no such attribute; malformed numbers are refused.
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

class Visitor : public tinyxml2::XMLVisitor {
 public:
  bool VisitEnter(const XMLElement& element, const tinyxml2::XMLAttribute*) override {
    const std::string name = element.Name();
    if (name == "p" || name == "vcount" || name == "h") {
      requireIndices(element);
    } else if (name == "v") {
      requireIntegers(element);
    } else if (name == "float_array") {
      const char* id = element.Attribute("id");
      const std::uint32_t size = number(element, "count", 0);
      if (id == nullptr) return true;
      const auto [entry, is_new] = array_sizes_.emplace(id, size);
      if (!is_new) entry->second = std::min(entry->second, size);
    } else if (name == "accessor") {
      accessors_.push_back(&element);
    }
    return true;
  }

  // To be called when the whole document was seen.
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
      const std::uint64_t needed = offset + (count - 1) * stride + std::max(stride, params);
      if (needed > array->second) {
        fail(accessor->GetLineNum(), "an accessor needs " + std::to_string(needed) +
                                         " numbers, but array '" + array->first + "' has " +
                                         std::to_string(array->second));
      }
    }
  }

 private:
  // Assimp would take a negative one or a signed count for 0, and a large one modulo 2^32.
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
  if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
    fail(std::max(document.ErrorLineNum(), 1),
         std::string("not well-formed XML: ") + document.ErrorName());
  }
  Visitor visitor;
  document.Accept(&visitor);
  visitor.checkAccessors();
  checkColladaReferences(document);
}

}  // namespace deformable_contact_monitor
