// Yaml that users write: the node's parameters, what an evaluation expects, a robot description's
// dump.
#include <functional>
#include <stdexcept>

#include "core/options.h"
#include "fuzz_target.h"
#include "monitor/cycle/monitor_scene.h"
#include "monitor/rules/parameters.h"
#include "scratch_file.h"
#include "tools/common/yaml_parameters.h"
#include "tools/evaluate_bag/expectations.h"

namespace deformable_contact_monitor {
namespace {

// Returns whether `read` accepts the file. If it rejects the file, its message must name the file.
bool isRead(const ScratchFile& file, const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const ParameterError&) {
    return false;
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal does not name its file");
    return false;
  }
}

// Past the first check: it is yaml.
bool tryYaml(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(".yaml");
  file.write(data, size);
  XmlRpc::XmlRpcValue tree;
  const bool is_yaml = isRead(file, [&] { tree = readYamlParameters(file.path()); });
  isRead(file, [] { readExpectations(file.path()); });
  isRead(file, [] { readRobotDescription(file.path()); });
  if (!is_yaml) return false;
  isRead(file, [&tree] {
    std::vector<std::string> warnings;
    const MonitorParameters parameters = parseParameters(tree, &warnings);
    requireValid(parameters.detector);
    const MonitorScene scene(parameters);
    requireThat(scene.scene().bodyCount() >= parameters.objects.size(), "an object has no body");
    makeMeshInputs(parameters);
  });
  return true;
}

const FuzzTargetEntry entry("yaml", tryYaml);

}  // namespace
}  // namespace deformable_contact_monitor
