// What an evaluation is of, and what decides which contacts there are.
#include "tools/evaluate_bag/evaluation_configuration.h"

namespace deformable_contact_monitor {

using Json = nlohmann::json;

Json topicsJson(const BagContents& contents) {
  Json json = Json::object();
  for (const auto& [name, topic] : contents.topics) {
    json[name] = {{"type", topic.type}, {"messages", topic.messages}, {"damaged", topic.damaged}};
  }
  return json;
}

Json configurationJson(const BagSetup& setup) {
  const MonitorParameters& p = setup.parameters;
  Json json;
  json["reference_frame"] = p.reference_frame;
  json["robot"] = setup.robot_from;
  json["geometry"] = p.geometry.kind == GeometryKind::kCollision ? "collision" : "visual";
  json["links"] = Json::array();
  for (const LinkGeometry& link : setup.robot.links) {
    json["links"].push_back({{"name", link.link},
                             {"triangles", link.mesh.triangleCount()},
                             {"source", link.source},
                             {"problem", link.problem}});
  }
  json["margin_m"] = p.margin_m;
  json["link_margin_m"] = p.link_margin_m;
  json["objects"] = Json::array();
  for (const ObjectParameters& object : p.objects) {
    json["objects"].push_back(
        {{"name", object.name}, {"topic", topicOf(object)}, {"margin_m", object.margin_m}});
  }
  json["pair_classes"] = namesOf(p.pair_classes);
  json["allowed_contacts"] = Json::array();
  for (const AllowedContact& rule : p.allowed_contacts.rules()) {
    json["allowed_contacts"].push_back(
        {{"body_a", rule.body_a}, {"body_b", rule.body_b}, {"allowed", rule.allowed != 0}});
  }
  json["adjacent_pairs"] = toString(p.detector.adjacent);
  json["max_mesh_age_s"] = p.max_mesh_age_s;
  if (p.motion == Motion::kSwept) {
    json["motion"] = toString(p.motion);
    json["swept_tolerance_m"] = p.swept_tolerance_m;
  }
  return json;
}

}  // namespace deformable_contact_monitor
