// Reads the rules of an SRDF that say which links may touch each other. Groups, states and end
// effectors are not needed here and are skipped. Reading does not check whether the links exist;
// srdfWarnings() compares them with those of the robot.
#include "robot/srdf.h"

#include <tinyxml2.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "robot/nearest_name.h"
#include "robot/regular_file.h"
#include "robot/xml_text.h"

namespace deformable_contact_monitor {
namespace {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

[[noreturn]] void failSrdf(int line, const std::string& what) {
  throw std::invalid_argument("SRDF, line " + std::to_string(line) + ": " + what);
}

// Returns `text`, which goes into messages and diagnostics. A control character is an error.
std::string checkedText(const char* text, int line) {
  const auto is_forbidden = [](unsigned char c) {
    return c < 0x20 && c != '\t' && c != '\n' && c != '\r';
  };
  std::string copy = text;
  if (std::any_of(copy.begin(), copy.end(), is_forbidden)) failSrdf(line, "a control character");
  return copy;
}

// Returns the value of an attribute that must be there and must not be empty.
std::string required(const XMLElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  if (value == nullptr || *value == '\0') {
    failSrdf(element.GetLineNum(), std::string(element.Name()) + " without " + attribute);
  }
  return checkedText(value, element.GetLineNum());
}

// Reads the two links of a rule, and its reason if it has one.
Srdf::Pair readPair(const XMLElement& element) {
  Srdf::Pair pair{required(element, "link1"), required(element, "link2"), ""};
  const char* reason = element.Attribute("reason");
  if (reason != nullptr) pair.reason = checkedText(reason, element.GetLineNum());
  return pair;
}

// Appends the names that are not known to `text`, with the nearest known name.
void addUnknown(const std::set<std::string>& names, const std::set<std::string>& known,
                std::string* text) {
  constexpr std::size_t kShown = 20;
  const std::vector<std::string> candidates(known.begin(), known.end());
  std::size_t count = 0;
  for (const std::string& name : names) {
    if (known.count(name) != 0 || ++count > kShown) continue;
    *text += (text->empty() ? "'" : ", '") + name + "'" + nearestNameHint(name, candidates);
  }
  if (count > kShown) *text += " and " + std::to_string(count - kShown) + " more";
}

}  // namespace

bool Srdf::operator==(const Srdf& other) const {
  const auto same = [](const std::vector<Pair>& a, const std::vector<Pair>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Pair& p, const Pair& q) {
      return std::tie(p.a, p.b, p.reason) == std::tie(q.a, q.b, q.reason);
    });
  };
  return robot == other.robot && same(disabled, other.disabled) && same(enabled, other.enabled) &&
         disabled_links == other.disabled_links;
}

Srdf readSrdf(const std::string& xml) {
  if (xml.empty()) throw std::invalid_argument("SRDF: is empty");
  if (xml.size() > kMaxSrdfBytes) {
    throw std::invalid_argument("SRDF: is larger than " + std::to_string(kMaxSrdfBytes >> 20U) +
                                " MiB");
  }
  XMLDocument document;
  if (const auto error = parseXml(xml, &document)) failSrdf(error->line, error->what);
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) failSrdf(1, "there is no element 'robot'");

  Srdf srdf;
  srdf.robot = required(*robot, "name");
  std::size_t rules = 0;
  for (const XMLElement* e = robot->FirstChildElement(); e != nullptr;
       e = e->NextSiblingElement()) {
    const std::string kind = e->Name();
    const bool disables = kind == "disable_collisions", enables = kind == "enable_collisions";
    const bool disables_link = kind == "disable_default_collisions";
    if (!disables && !enables && !disables_link) continue;
    if (++rules > kMostSrdfRules) {
      failSrdf(e->GetLineNum(),
               "more than " + std::to_string(kMostSrdfRules) + " rules, which is the most");
    }
    if (disables) srdf.disabled.push_back(readPair(*e));
    if (enables) srdf.enabled.push_back(readPair(*e));
    if (disables_link) srdf.disabled_links.insert(required(*e, "link"));
  }
  return srdf;
}

Srdf readSrdfFile(const std::string& path) {
  std::string xml;
  try {
    xml = readRegularFile(path);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  try {
    return readSrdf(xml);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(path + ": " + error.what());
  }
}

Srdf prefixed(const Srdf& srdf, const std::string& prefix, const std::set<std::string>& links) {
  const auto named = [&](const std::string& name) {
    return links.count(prefix + name) > 0 ? prefix + name : name;
  };
  Srdf renamed = srdf;
  for (std::vector<Srdf::Pair>* pairs : {&renamed.disabled, &renamed.enabled}) {
    for (Srdf::Pair& pair : *pairs) {
      pair.a = named(pair.a);
      pair.b = named(pair.b);
    }
  }
  renamed.disabled_links.clear();
  for (const std::string& link : srdf.disabled_links) renamed.disabled_links.insert(named(link));
  return renamed;
}

std::vector<std::string> srdfWarnings(const Srdf& srdf, const std::string& robot,
                                      const std::set<std::string>& links) {
  std::vector<std::string> lines;
  if (!robot.empty() && srdf.robot != robot) {
    lines.push_back("the SRDF is of robot '" + srdf.robot + "', but the robot is '" + robot + "'");
  }
  std::set<std::string> named = srdf.disabled_links;
  for (const std::vector<Srdf::Pair>* pairs : {&srdf.disabled, &srdf.enabled}) {
    for (const Srdf::Pair& pair : *pairs) {
      named.insert(pair.a);
      named.insert(pair.b);
    }
  }
  std::string unknown;
  addUnknown(named, links, &unknown);
  if (!unknown.empty()) {
    lines.push_back("the SRDF names links that the robot lacks: " + unknown);
  }
  return lines;
}

}  // namespace deformable_contact_monitor
