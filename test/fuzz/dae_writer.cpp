// COLLADA files that are mostly well-formed, made of an input's bytes.
#include <iterator>

#include "mesh_writer.h"
#include "text_writer.h"

namespace deformable_contact_monitor {
namespace {

std::string positions(ByteSource* source, std::size_t vertices) {
  const std::string param = "<param name=\"X\" type=\"float\"/>";
  return "<source id=\"p\"><float_array id=\"a\" count=\"" + countText(source, 3 * vertices) +
         "\">" + numberTexts(source, 3 * vertices) +
         "</float_array><technique_common><accessor source=\"#a\" count=\"" +
         countText(source, vertices) + "\" stride=\"" + countText(source, 3) + "\">" + param +
         param + param + "</accessor></technique_common></source><vertices id=\"v\">" +
         "<input semantic=\"POSITION\" source=\"#p\"/></vertices>";
}

std::string primitive(ByteSource* source, std::size_t vertices) {
  constexpr const char* kKinds[] = {"triangles", "polylist", "polygons",
                                    "trifans",   "lines",    "tristrips"};
  const std::string kind = kKinds[source->below(std::size(kKinds))];
  const std::size_t faces = 1 + source->below(4);
  const std::size_t corners = kind == "triangles" ? 3 : 3 + source->below(3);
  const bool has_normals = source->below(4) == 3;
  std::string counts, indices;
  for (std::size_t i = 0; i < faces; ++i) {
    counts += countText(source, corners) + " ";
    for (std::size_t k = 0; k < corners * (has_normals ? 2 : 1); ++k) {
      indices += std::to_string(indexFrom(source, vertices)) + " ";
    }
  }
  std::string text = "<" + kind + " count=\"" + countText(source, faces) + "\">" +
                     "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  if (has_normals) text += "<input semantic=\"NORMAL\" source=\"#p\" offset=\"1\"/>";
  if (kind == "polylist") text += "<vcount>" + counts + "</vcount>";
  return text + "<p>" + indices + "</p></" + kind + ">";
}

std::string node(ByteSource* source, int depth) {
  std::string text = "<node id=\"n" + std::to_string(depth) + "\">";
  for (std::size_t left = source->below(3); left > 0; --left) {
    constexpr struct {
      const char* name;
      std::size_t numbers;
    } kKinds[] = {{"matrix", 16},   {"rotate", 4}, {"scale", 3},
                  {"translate", 3}, {"lookat", 9}, {"skew", 7}};
    const auto& kind = kKinds[source->below(std::size(kKinds))];
    const std::string name = kind.name;
    text += "<" + name + ">" + numberTexts(source, kind.numbers) + "</" + name + ">";
  }
  constexpr const char* kContents[] = {
      "<instance_geometry url=\"#g\"/>", "<instance_geometry url=\"#g\"/>",
      "<instance_node url=\"#n0\"/>", "<instance_node url=\"#n1\"/>",
      "<instance_controller url=\"#c\"/>"};
  constexpr int kDeepest = 3;
  if (depth < kDeepest && source->flag()) text += node(source, depth + 1);
  const std::size_t content = source->below(16);
  return text + kContents[content < std::size(kContents) ? content : 0] + "</node>";
}

}  // namespace

std::string daeFrom(ByteSource* source) {
  const std::size_t vertices = 3 + source->below(6);
  std::string text =
      "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
      "version=\"1.4.1\"><asset><unit meter=\"" +
      numberText(source) + "\"/><up_axis>" + (source->flag() ? "Z_UP" : "Y_UP") +
      "</up_axis></asset><library_geometries><geometry id=\"g\"><mesh>" +
      positions(source, vertices);
  for (std::size_t left = 1 + source->below(2); left > 0; --left) {
    text += primitive(source, vertices);
  }
  text += "</mesh></geometry></library_geometries>";
  if (source->below(8) == 7) {
    text +=
        "<library_controllers><controller id=\"c\"><skin source=\"#g\"/></controller>"
        "</library_controllers>";
  }
  return text + "<library_visual_scenes><visual_scene id=\"s\">" + node(source, 0) +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/>"
         "</scene></COLLADA>";
}

}  // namespace deformable_contact_monitor
