// What each of measure_trade's summaries begins with.
#include "tools/measure_trade/summary_head.h"

#include "tools/common/machine.h"

namespace deformable_contact_monitor {

nlohmann::json summaryHead(const TradeArguments& arguments, const FrameSource& frames) {
  nlohmann::json json;
  json["version"] = DCM_VERSION;
  json["command"] = arguments.command;
  json["machine"] = machineJson();
  json["adjacent"] = toString(arguments.base.adjacent);
  json["threads"] = arguments.base.threads;
  json["bodies"] = nlohmann::json::array();
  const Scene& scene = frames.scene();
  for (BodyId body = 0; body < scene.bodyCount(); ++body) {
    json["bodies"].push_back({{"name", scene.body(body).name},
                              {"triangles", scene.body(body).mesh.triangleCount()},
                              {"deformable", frames.isDeformable(body)}});
  }
  return json;
}

}  // namespace deformable_contact_monitor
