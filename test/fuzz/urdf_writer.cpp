// Robot descriptions that are mostly well-formed, made of an input's bytes.
#include "urdf_writer.h"

#include <iterator>

#include "text_writer.h"

namespace deformable_contact_monitor {
namespace {

std::string attribute(const std::string& name, const std::string& value) {
  return " " + name + "=\"" + value + "\"";
}

std::string linkName(ByteSource* source, std::size_t number) {
  constexpr std::uint8_t kOdd = 250;
  constexpr const char* kNames[] = {"a0", "%s%n", "", "&#37;", "&lt;", "a b"};
  const std::uint8_t code = source->byte();
  return code < kOdd ? "a" + std::to_string(number) : kNames[code - kOdd];
}

std::string shape(ByteSource* source) {
  switch (source->below(6)) {
    case 0:
      return "<box" + attribute("size", numberTexts(source, 3)) + "/>";
    case 1:
      return "<sphere" + attribute("radius", numberText(source)) + "/>";
    case 2:
      return "<cylinder" + attribute("radius", numberText(source)) +
             attribute("length", numberText(source)) + "/>";
    case 3:
      return "<mesh" + attribute("filename", "package://p/" + linkName(source, 1) + ".stl") +
             attribute("scale", numberTexts(source, 3)) + "/>";
    case 4:
      return "<box size=\"1 1 1\"/>";
    default:
      return source->flag() ? "<cone/>" : "<sphere radius=\"1\"/>";
  }
}

std::string element(ByteSource* source, const std::string& kind) {
  std::string text = "<" + kind + ">";
  if (source->flag()) {
    text += "<origin" + attribute("xyz", numberTexts(source, 3)) +
            attribute("rpy", numberTexts(source, 3)) + "/>";
  }
  text += "<geometry>" + shape(source) + "</geometry>";
  if (kind == "visual" && source->flag()) text += "<material name=\"%s\"/>";
  return text + "</" + kind + ">";
}

// Writes a joint whose child is the link of this number and whose parent is an earlier link.
std::string joint(ByteSource* source, std::size_t number) {
  constexpr const char* kTypes[] = {"fixed",    "revolute", "continuous", "prismatic",
                                    "floating", "planar",   "fixed",      "%d"};
  std::string text = "<joint" + attribute("name", "j" + std::to_string(number)) +
                     attribute("type", kTypes[source->below(16) % 8]) + ">";
  text += "<parent" + attribute("link", linkName(source, source->below(number))) + "/>";
  text += "<child" + attribute("link", linkName(source, number)) + "/>";
  if (source->flag()) text += "<origin" + attribute("xyz", numberTexts(source, 3)) + "/>";
  if (source->flag()) text += "<axis" + attribute("xyz", numberTexts(source, 3)) + "/>";
  text += "<limit effort=\"1\"" + attribute("velocity", numberText(source)) +
          attribute("lower", numberText(source)) + "/>";
  constexpr const char* kMore[] = {
      "<mimic joint=\"j1\" multiplier=\"2\"/>", "<dynamics damping=\"1\"/>",
      "<safety_controller k_velocity=\"1\"/>", "<calibration rising=\"0\"/>"};
  const std::size_t more = source->below(8);
  if (more < std::size(kMore)) text += kMore[more];
  return text + "</joint>";
}

}  // namespace

std::string urdfFrom(ByteSource* source) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot" + attribute("name", linkName(source, 9)) +
                     ">\n<material name=\"%s\"><color rgba=\"1 0 0 1\"/></material>\n";
  const std::size_t links = 1 + source->below(4);
  for (std::size_t i = 0; i < links; ++i) {
    text += "<link" + attribute("name", linkName(source, i)) + ">";
    for (std::size_t left = source->below(4); left > 0; --left) {
      text += element(source, source->flag() ? "visual" : "collision");
    }
    text += "</link>\n";
    if (i > 0) text += joint(source, i) + "\n";
  }
  return text + "</robot>\n";
}

}  // namespace deformable_contact_monitor
