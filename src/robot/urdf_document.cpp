// A URDF's links in document order, their geometry as urdfdom reads it.
#include "robot/urdf_document.h"

#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>

#include <mutex>
#include <stdexcept>

#include "robot/urdf_text.h"

namespace deformable_contact_monitor {
namespace {

// Keeps what urdfdom would print.
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

bool mentions(const std::string& text, const std::string& name) {
  return text.find("[" + name + "]") != std::string::npos ||
         text.find("'" + name + "'") != std::string::npos;
}

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

// What urdfdom said of one link: the messages since it left the link before, up to the one that
// names this link.
std::string complaintAbout(const std::string& link, const std::vector<std::string>& messages) {
  std::vector<std::string> complaint;
  for (const std::string& message : messages) {
    complaint.push_back(message);
    if (message.find("for Link [") == std::string::npos) continue;
    if (mentions(message, link)) break;
    complaint.clear();
  }
  return joined(complaint);
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

UrdfDocument readUrdf(const std::string& urdf_xml, GeometryKind kind) {
  const UrdfText text = readUrdfText(urdf_xml, kind);
  const Parsed parsed = parse(text.xml);
  if (!parsed.model) refuse(text, joined(parsed.messages));

  UrdfDocument document;
  document.name = unguarded(parsed.model->getName());
  document.root_link = unguarded(parsed.model->getRoot()->name);
  for (const UrdfText::Link& entry : text.links) {
    const urdf::LinkConstSharedPtr found = parsed.model->getLink(guarded(entry.name));
    if (!found) refuse(text, "link '" + entry.name + "' cannot be read");
    UrdfLink link;
    link.name = entry.name;
    link.elements = kind == GeometryKind::kCollision ? convert(found->collision_array)
                                                     : convert(found->visual_array);
    // urdfdom drops an element that it cannot read, and all that follow it, and goes on.
    if (link.elements.size() != entry.elements) {
      link.elements.clear();
      link.problem = "robot description, line " + std::to_string(entry.line) + ": " +
                     complaintAbout(entry.name, parsed.messages);
    }
    document.links.push_back(std::move(link));
  }
  return document;
}

}  // namespace deformable_contact_monitor
