// Bags, from their bytes to states. Even first byte: the others are a bag. Odd: they are messages
// of one, so that damage gets beyond the index.
#include <console_bridge/console.h>
#include <pthread.h>
#include <rosbag/bag.h>
#include <signal.h>
#include <sys/resource.h>

#include <array>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "byte_source.h"
#include "core/cpu_detector.h"
#include "fuzz_target.h"
#include "recorded_bytes.h"
#include "scratch_file.h"
#include "tools/bags/bag_cycles.h"
#include "tools/bags/bag_messages.h"
#include "tools/bags/bag_records.h"
#include "tools/bags/bag_setup.h"
#include "tools/evaluate_bag/evaluation_run.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kMostMessages = 16;

// A crash of the child process that reads with rosbag's library is not a finding. The child must
// therefore not write libFuzzer's crash files, as every forked process otherwise would. The other
// settings are those of evaluate_bag.
void prepareProcess() {
  signal(SIGPIPE, SIG_IGN);
  ros::Time::init();
  console_bridge::noOutputHandler();
  static const int registered = pthread_atfork(nullptr, nullptr, [] {
    const rlimit none{0, 0};
    setrlimit(RLIMIT_FSIZE, &none);
    signal(SIGXFSZ, SIG_IGN);
    for (const int fatal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) signal(fatal, SIG_DFL);
  });
  requireThat(registered == 0, "no handler of forks");
}

// A message for each of `source`'s: its type, its topic, its time, its bytes.
void writeBag(ByteSource* source, const std::string& path) {
  constexpr const char* kTopics[] = {
      "/cloth", "/towel", "/tf", "/tf_static", "/robot_description", "/link_meshes"};
  rosbag::Bag bag(path, rosbag::bagmode::Write);
  ros::Time time(100, 0);
  for (std::size_t i = 0; i < kMostMessages && source->left() > 0; ++i) {
    constexpr std::array kTypes = {recordedAs<DeformableMesh>, recordedAs<tf2_msgs::TFMessage>,
                                   recordedAs<LinkMeshes>, recordedAs<std_msgs::String>};
    const auto recorded = kTypes.at(source->below(kTypes.size()));
    const char* const topic = kTopics[source->below(std::size(kTopics))];
    time += ros::Duration(0.01 * source->byte());
    // An empty message is avoided because rosbag's writer copies its bytes from a null pointer.
    std::vector<std::uint8_t> bytes = source->bytes(source->number<std::uint16_t>());
    if (bytes.empty()) bytes.push_back(0);
    const RecordedBytes message = recorded(std::move(bytes));
    bag.write(topic, time, message);
  }
}

// In swept motion, which detects at the stamps too.
void evaluate(const ScratchFile& file, BagReader* reader, BagContents* contents) {
  BagFiles files;
  files.bags = {file.path()};
  MonitorParameters parameters;
  parameters.motion = Motion::kSwept;
  try {
    const BagSetup setup =
        setUpBags(files, parameters, SceneObject(), contents, [](const std::string&) {});
    Options options;
    options.threads = 1;  // no threads where forks come
    EvaluationRun run("cpu", makeCpuDetector(), options, StateRules(), {});
    BagCycles cycles(setup.parameters, *contents, setup.robots, nullptr);
    cycles.run(reader, [&](CycleReport* cycle) { run.evaluate(cycle, &cycles.sceneOfStep()); });
    requireThat(run.cycles <= contents->meshes.size(), "more cycles than meshes");
  } catch (const std::exception& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
  }
}

// Past the first check: a message of a type that is needed was read.
bool tryBag(const std::uint8_t* data, std::size_t size) {
  static const ScratchFile file(".bag");
  prepareProcess();
  ByteSource source(data, size);
  if (source.flag()) {
    writeBag(&source, file.path());
  } else {
    file.write(data + 1, size == 0 ? 0 : size - 1);
  }
  try {
    checkBagIndex(file.path());
  } catch (const std::runtime_error& refusal) {
    requireThat(*refusal.what() != '\0', "a refusal without a reason");
  }
  try {
    BagReader reader({file.path()}, neededMessages(MonitorParameters(), BagFiles()));
    BagFiles files;
    files.bags = {file.path()};
    BagContents contents = scanBags(&reader, files, MonitorParameters(), [](std::uint64_t) {});
    if (contents.topics.empty()) return false;
    evaluate(file, &reader, &contents);
    return true;
  } catch (const std::runtime_error& refusal) {
    requireThat(namesFile(refusal.what(), file), "a refusal does not name its file");
    return false;
  }
}

const FuzzTargetEntry entry("bag", tryBag);

}  // namespace
}  // namespace deformable_contact_monitor
