// Copies the geometry out of a URDF's text, has urdfdom parse the copy, and sorts its messages.
#include "robot/urdf_document.h"

#include <console_bridge/console.h>
#include <tinyxml2.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <mutex>
#include <stdexcept>
#include <string_view>

#include "robot/xml_text.h"

namespace deformable_contact_monitor {
namespace {

using tinyxml2::XMLAttribute;
using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;

// Takes the place of '%'. A document cannot contain this character: checked() rejects it.
constexpr char kPercentGuard = '\x1f';

[[noreturn]] void fail(int line, const std::string& what) {
  throw std::invalid_argument("robot description, line " + std::to_string(line) + ": " + what);
}

// Returns `text`, guarded. Control characters, which XML forbids, are an error.
std::string checked(const char* text, int line) {
  const auto is_forbidden = [](unsigned char c) {
    return c < 0x20 && c != '\t' && c != '\n' && c != '\r';
  };
  const std::string copy = text;
  if (std::any_of(copy.begin(), copy.end(), is_forbidden)) fail(line, "a control character");
  return guarded(copy);
}

// Copies the element and its attributes, not its children.
XMLElement* copyElement(const XMLElement& from, tinyxml2::XMLNode& to) {
  XMLElement* copy = to.GetDocument()->NewElement(checked(from.Name(), from.GetLineNum()).c_str());
  to.InsertEndChild(copy);
  for (const XMLAttribute* a = from.FirstAttribute(); a != nullptr; a = a->Next()) {
    copy->SetAttribute(checked(a->Name(), a->GetLineNum()).c_str(),
                       checked(a->Value(), a->GetLineNum()).c_str());
  }
  return copy;
}

// Copies the element with all its descendants. Text between elements is left out.
void copyTree(const XMLElement& from, tinyxml2::XMLNode& to) {
  XMLElement* copy = copyElement(from, to);
  for (const XMLElement* e = from.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    copyTree(*e, *copy);
  }
}

// Returns the element's name. Throws if it has none.
const char* requireName(const XMLElement& element) {
  const char* name = element.Attribute("name");
  if (name == nullptr || *name == '\0') {
    fail(element.GetLineNum(), std::string(element.Name()) + " without a name");
  }
  return name;
}

// Refuses a xacro file that was not expanded, which would be a robot without the links of its
// macros. Old versions of xacro left calls of macros that they did not know, so these are no sign.
void requireExpanded(const XMLElement& robot) {
  for (const XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    const std::string element = e->Name();
    const char* const name = e->Attribute("name");
    if (name != nullptr && std::string_view(name).find("${") != std::string_view::npos) {
      fail(e->GetLineNum(), "the name '" + std::string(name) + "' is xacro; run xacro on it first");
    }
    if (element == "xacro:include" || element == "xacro:macro") {
      fail(e->GetLineNum(), "<" + element + "> is xacro; run xacro on it first");
    }
  }
}

// Copies a link with its elements of one kind. Each copied element keeps only origin and geometry.
UrdfText::Link copyLink(const XMLElement& from, GeometryKind kind, tinyxml2::XMLNode& to) {
  UrdfText::Link link;
  link.name = requireName(from);
  link.line = from.GetLineNum();
  const bool has_collision = from.FirstChildElement("collision") != nullptr;
  const bool has_visual = from.FirstChildElement("visual") != nullptr;
  link.is_visual =
      kind == GeometryKind::kVisual || (kind == GeometryKind::kCollisionOrVisual && !has_collision);
  link.has_others = link.is_visual ? has_collision : has_visual;
  const char* element_name = link.is_visual ? "visual" : "collision";
  XMLElement* copy = copyElement(from, to);
  for (const XMLElement* e = from.FirstChildElement(element_name); e != nullptr;
       e = e->NextSiblingElement(element_name)) {
    ++link.elements;
    XMLElement* element = copyElement(*e, *copy);
    for (const char* part : {"origin", "geometry"}) {
      const XMLElement* child = e->FirstChildElement(part);
      if (child != nullptr) copyTree(*child, *element);
    }
  }
  return link;
}

// Collects the messages that urdfdom would print.
class MessageCollector : public console_bridge::OutputHandler {
 public:
  MessageCollector() { console_bridge::useOutputHandler(this); }
  ~MessageCollector() override { console_bridge::restorePreviousOutputHandler(); }

  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level == console_bridge::CONSOLE_BRIDGE_LOG_ERROR) messages_.push_back(unguarded(text));
  }

  const std::vector<std::string>& messages() const { return messages_; }

 private:
  std::vector<std::string> messages_;
};

// The robot as urdfdom read it, and the errors that it reported.
struct Parsed {
  urdf::ModelInterfaceSharedPtr model;  // null: refused
  std::vector<std::string> messages;
};

Parsed parse(const std::string& guarded_xml) {
  static std::mutex mutex;  // console_bridge has one handler a process
  const std::lock_guard<std::mutex> lock(mutex);
  MessageCollector collector;
  Parsed parsed;
  std::string thrown;
  try {
    parsed.model = urdf::parseURDF(guarded_xml);
  } catch (const std::exception& e) {
    thrown = unguarded(e.what());
  }
  parsed.messages = collector.messages();
  if (!thrown.empty()) parsed.messages.push_back(thrown);
  return parsed;
}

std::string joined(const std::vector<std::string>& messages) {
  std::string text;
  for (const std::string& message : messages) text += (text.empty() ? "" : "; ") + message;
  return text.empty() ? "urdfdom refuses it without a reason" : text;
}

// Returns whether a message names a link or joint. urdfdom writes names in brackets or quotes.
bool mentions(const std::string& text, const std::string& name) {
  return text.find("[" + name + "]") != std::string::npos ||
         text.find("'" + name + "'") != std::string::npos;
}

// The types are in the order of those of urdfdom.
RobotJoint::Type typeOf(const urdf::Joint& joint) {
  using Type = RobotJoint::Type;
  constexpr Type kTypes[] = {Type::kUnknown,  Type::kRevolute, Type::kContinuous, Type::kPrismatic,
                             Type::kFloating, Type::kPlanar,   Type::kFixed};
  return kTypes[joint.type];
}

// Converts a joint of urdfdom. It reads limits of a continuous joint, which mean nothing.
RobotJoint convert(const urdf::Joint& from) {
  RobotJoint joint;
  joint.name = unguarded(from.name);
  joint.parent = unguarded(from.parent_link_name);
  joint.child = unguarded(from.child_link_name);
  joint.type = typeOf(from);
  joint.origin = from.parent_to_joint_origin_transform;
  joint.axis = from.axis;
  if (from.limits != nullptr && joint.type != RobotJoint::Type::kContinuous) {
    joint.lower = from.limits->lower;
    joint.upper = from.limits->upper;
  }
  if (from.limits != nullptr) joint.max_velocity = from.limits->velocity;
  if (from.mimic == nullptr) return joint;
  joint.mimics = unguarded(from.mimic->joint_name);
  joint.multiplier = from.mimic->multiplier;
  joint.offset = from.mimic->offset;
  return joint;
}

// Throws the error of a whole document, with the line of the link or joint that the reason names.
[[noreturn]] void refuse(const UrdfText& text, const std::string& reason) {
  std::string where;
  for (const UrdfText::Link& link : text.links) {
    if (mentions(reason, link.name)) where = ", line " + std::to_string(link.line);
  }
  for (const auto& [name, line] : text.joint_lines) {
    if (mentions(reason, name)) where = ", line " + std::to_string(line);
  }
  throw std::invalid_argument("robot description" + where + ": " + reason);
}

// Returns urdfdom's messages about one link: those after the previous link's, up to the one that
// names this link.
std::string messagesAbout(const std::string& link, const std::vector<std::string>& messages) {
  std::vector<std::string> selected;
  for (const std::string& message : messages) {
    selected.push_back(message);
    if (message.find("for Link [") == std::string::npos) continue;
    if (mentions(message, link)) break;
    selected.clear();
  }
  return joined(selected);
}

Eigen::Affine3d toEigen(const urdf::Pose& pose) {
  const urdf::Rotation& r = pose.rotation;
  const urdf::Vector3& p = pose.position;
  return Eigen::Translation3d(p.x, p.y, p.z) * Eigen::Quaterniond(r.w, r.x, r.y, r.z);
}

template <typename Elements>
std::vector<UrdfElement> convert(const Elements& elements) {
  std::vector<UrdfElement> converted;
  for (const auto& element : elements) {
    const auto mesh = std::dynamic_pointer_cast<urdf::Mesh>(element->geometry);
    if (mesh) mesh->filename = unguarded(mesh->filename);
    converted.push_back({toEigen(element->origin), element->geometry});
  }
  return converted;
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
  if (const auto error = parseXml(urdf_xml, &document)) fail(error->line, error->what);
  const XMLElement* robot = document.FirstChildElement("robot");
  if (robot == nullptr) fail(1, "there is no element 'robot'");
  requireName(*robot);
  requireExpanded(*robot);

  UrdfText text;
  XMLDocument copy;
  XMLElement* robot_copy = copyElement(*robot, copy);
  std::map<std::string, int> link_lines;
  for (const XMLElement* e = robot->FirstChildElement("link"); e != nullptr;
       e = e->NextSiblingElement("link")) {
    text.links.push_back(copyLink(*e, kind, *robot_copy));
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

UrdfDocument readUrdf(const std::string& urdf_xml, GeometryKind kind) {
  const UrdfText text = readUrdfText(urdf_xml, kind);
  const Parsed parsed = parse(text.xml);
  if (!parsed.model) refuse(text, joined(parsed.messages));

  UrdfDocument document;
  document.name = unguarded(parsed.model->getName());
  document.root_link = unguarded(parsed.model->getRoot()->name);
  for (const auto& [name, joint] : parsed.model->joints_) {
    document.joints.push_back(convert(*joint));
  }
  for (const UrdfText::Link& entry : text.links) {
    const urdf::LinkConstSharedPtr found = parsed.model->getLink(guarded(entry.name));
    if (!found) refuse(text, "link '" + entry.name + "' cannot be read");
    UrdfLink link;
    link.name = entry.name;
    link.has_others = entry.has_others;
    link.elements =
        entry.is_visual ? convert(found->visual_array) : convert(found->collision_array);
    // urdfdom drops an element that it cannot read, and all that follow it, and goes on.
    if (link.elements.size() != entry.elements) {
      link.elements.clear();
      link.problem = "robot description, line " + std::to_string(entry.line) + ": " +
                     messagesAbout(entry.name, parsed.messages);
    }
    document.links.push_back(std::move(link));
  }
  return document;
}

}  // namespace deformable_contact_monitor
