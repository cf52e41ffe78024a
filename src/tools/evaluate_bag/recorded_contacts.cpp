// The contacts of an evaluation's cycles, as records of its parts have them.
#include "tools/evaluate_bag/recorded_contacts.h"

#include <boost/crc.hpp>
#include <filesystem>
#include <stdexcept>

#include "tools/bags/stamp_text.h"
#include "tools/evaluate_bag/evaluation_configuration.h"

namespace deformable_contact_monitor {
namespace {

using Json = nlohmann::json;

std::uint32_t linksChecksum(const RobotGeometry& robot) {
  boost::crc_32_type sum;
  const auto add = [&sum](const auto& list) {
    sum.process_bytes(list.data(), list.size() * sizeof(list[0]));
  };
  for (const LinkGeometry& link : robot.links) {
    add(link.link);
    add(link.mesh.vertices);
    add(link.mesh.triangles);
  }
  return sum.checksum();
}

}  // namespace

Json originOf(const std::vector<std::string>& bags, const BagContents& contents,
              const BagSetup& setup, const std::vector<RunSettings>& runs) {
  Json sizes = Json::array(), names = Json::array();
  for (const std::string& path : bags) sizes.push_back(std::filesystem::file_size(path));
  for (const RunSettings& run : runs) names.push_back(runName(run.backend, run.options));
  Json configuration = configurationJson(setup);
  configuration["containment"] = setup.parameters.containment;
  return {{"bags", {{"bytes", sizes}, {"topics", topicsJson(contents)}}},
          {"configuration", configuration},
          {"links", linksChecksum(setup.robot)},
          {"runs", names}};
}

// Each run's before the next one's: they share the report.
Json recordOf(const std::vector<std::unique_ptr<EvaluationRun>>& runs, Scene* scene,
              CycleReport* cycle) {
  Json record{{"cycle", cycle->cycle},
              {"stamp", stampText(cycle->header.stamp)},
              {"scene", sceneChecksum(*cycle)},
              {"runs", Json::array()}};
  for (const auto& run : runs) {
    run->find(cycle, scene);
    record["runs"].push_back(toRecord(*cycle));
  }
  return record;
}

void RecordedCycles::read(std::size_t run, CycleReport* cycle, RecordedCycle* into) {
  goTo(*cycle);
  try {
    into->read(current_->at("runs").at(run), cycle);
  } catch (const std::exception& error) {
    reader_.fail("cycle " + std::to_string(cycle->cycle) + " is damaged: " + error.what());
  }
}

void RecordedCycles::goTo(const CycleReport& cycle) {
  if (cycle_ == cycle.cycle) return;
  current_ = reader_.next();
  cycle_ = cycle.cycle;
  const std::string name =
      "cycle " + std::to_string(cycle.cycle) + " at stamp " + stampText(cycle.header.stamp);
  if (current_ == nullptr) reader_.fail("ends before " + name);
  if (current_->value("cycle", Json()) != cycle.cycle ||
      current_->value("stamp", Json()) != stampText(cycle.header.stamp)) {
    reader_.fail("has another cycle in place of " + name);
  }
  if (current_->value("scene", Json()) != sceneChecksum(cycle)) {
    reader_.fail("has the contacts of another scene at " + name +
                 ": other meshes, transforms or pairs of bodies");
  }
}

void RecordedCycles::requireEnd() {
  if (reader_.next() != nullptr) reader_.fail("goes on behind the bags' last cycle");
}

}  // namespace deformable_contact_monitor
