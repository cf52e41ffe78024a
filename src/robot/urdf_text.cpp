// The part of a URDF's text that says where a link's geometry is, made safe for urdfdom.
#include "robot/urdf_text.h"

#include <tinyxml2.h>

#include <algorithm>
#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

using tinyxml2::XMLAttribute;
using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

constexpr char kPercentGuard = '\x1f';

[[noreturn]] void fail(int line, const std::string& what) {
  throw std::invalid_argument("robot description, line " + std::to_string(line) + ": " + what);
}

// `text` without what XML forbids, and without what urdfdom cannot be trusted with.
std::string checked(const char* text, int line) {
  const auto is_forbidden = [](unsigned char c) {
    return c < 0x20 && c != '\t' && c != '\n' && c != '\r';
  };
  const std::string copy = text;
  if (std::any_of(copy.begin(), copy.end(), is_forbidden)) fail(line, "a control character");
  return guarded(copy);
}

// The element and its attributes, not its children.
XMLElement* copyElement(const XMLElement& from, tinyxml2::XMLNode& to) {
  XMLElement* copy = to.GetDocument()->NewElement(checked(from.Name(), from.GetLineNum()).c_str());
  to.InsertEndChild(copy);
  for (const XMLAttribute* a = from.FirstAttribute(); a != nullptr; a = a->Next()) {
    copy->SetAttribute(checked(a->Name(), a->GetLineNum()).c_str(),
                       checked(a->Value(), a->GetLineNum()).c_str());
  }
  return copy;
}

void copyTree(const XMLElement& from, tinyxml2::XMLNode& to) {
  XMLElement* copy = copyElement(from, to);
  for (const XMLElement* e = from.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    copyTree(*e, *copy);
  }
}

const char* requireName(const XMLElement& element) {
  const char* name = element.Attribute("name");
  if (name == nullptr || *name == '\0') {
    fail(element.GetLineNum(), std::string(element.Name()) + " without a name");
  }
  return name;
}

UrdfText::Link copyLink(const XMLElement& from, const char* kind, tinyxml2::XMLNode& to) {
  UrdfText::Link link{requireName(from), from.GetLineNum(), 0};
  XMLElement* copy = copyElement(from, to);
  for (const XMLElement* e = from.FirstChildElement(kind); e != nullptr;
       e = e->NextSiblingElement(kind)) {
    ++link.elements;
    XMLElement* element = copyElement(*e, *copy);
    for (const char* part : {"origin", "geometry"}) {
      const XMLElement* child = e->FirstChildElement(part);
      if (child != nullptr) copyTree(*child, *element);
    }
  }
  return link;
}

}  // namespace

std::string guarded(std::string text) {
  std::replace(text.begin(), text.end(), '%', kPercentGuard);
  return text;
}

std::string unguarded(std::string text) {
  std::replace(text.begin(), text.end(), kPercentGuard, '%');
  return text;
}

UrdfText readUrdfText(const std::string& urdf_xml, GeometryKind kind) {
  if (urdf_xml.empty()) throw std::invalid_argument("robot description: is empty");
  XMLDocument document;
  if (document.Parse(urdf_xml.data(), urdf_xml.size()) != tinyxml2::XML_SUCCESS) {
    fail(std::max(document.ErrorLineNum(), 1),
         std::string("not well-formed XML: ") + document.ErrorName());
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) fail(1, "there is no element 'robot'");
  requireName(*robot);

  UrdfText text;
  XMLDocument copy;
  XMLElement* robot_copy = copyElement(*robot, copy);
  const char* element = kind == GeometryKind::kCollision ? "collision" : "visual";
  std::map<std::string, int> link_lines;
  for (const XMLElement* e = robot->FirstChildElement("link"); e != nullptr;
       e = e->NextSiblingElement("link")) {
    text.links.push_back(copyLink(*e, element, *robot_copy));
    const auto [first, is_new] = link_lines.emplace(text.links.back().name, e->GetLineNum());
    if (!is_new) {
      fail(e->GetLineNum(), "link '" + first->first + "' is there twice, first in line " +
                                std::to_string(first->second));
    }
  }
  if (text.links.empty()) fail(robot->GetLineNum(), "the robot has no links");
  for (const XMLElement* e = robot->FirstChildElement("joint"); e != nullptr;
       e = e->NextSiblingElement("joint")) {
    text.joint_lines.emplace(requireName(*e), e->GetLineNum());
    copyTree(*e, *robot_copy);
  }
  tinyxml2::XMLPrinter printer(nullptr, true);
  copy.Print(&printer);
  text.xml = printer.CStr();
  return text;
}

}  // namespace deformable_contact_monitor
