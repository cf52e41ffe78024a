// Sends meshes and transforms to a monitor as fast as it is told, and watches what comes of them.
// Prints a line of JSON every few seconds, and one of all at the end; `run` reads them.
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/mesh_file.h"
#include "load_scene.h"
#include "scenes.h"
#include "states_watch.h"
#include "tools/common/command_line.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

struct LoadOptions {
  std::string monitor = "/contact_monitor", mesh_file;
  std::size_t first = 0, objects = 1, links = 0;
  int cells = 10;
  double rate_hz = 30, warm_up_s = 0, seconds = 0, period_s = 5;
  bool together = false, unwatched = false;
};

// Transforms are a little ahead of the meshes, so that none waits for them.
void moveLinks(std::size_t links, const std::atomic<bool>& stopped) {
  constexpr std::chrono::milliseconds kPeriod(10);
  const ros::Duration ahead(0.02);
  ros::NodeHandle node;
  const ros::Publisher publisher = node.advertise<tf2_msgs::TFMessage>("/tf", 10);
  for (Clock::time_point due = Clock::now(); !stopped; due += kPeriod) {
    if (!ros::Time::now().isZero()) {
      publisher.publish(linkTransforms(links, ros::Time::now() + ahead));
    }
    std::this_thread::sleep_until(due);
    due = std::max(due, Clock::now() - kPeriod);
  }
}

// Objects take turns, evenly over a period; or all of one period have one stamp.
class LoadSender {
 public:
  LoadSender(const LoadOptions& options, const TriangleMesh& mesh) : options_(options) {
    ros::NodeHandle node;
    for (std::size_t n = options.first; n < options.first + options.objects; ++n) {
      objects_.emplace_back(n, mesh);
      publishers_.push_back(node.advertise<DeformableMesh>("/" + objectName(n), 2));
    }
  }

  // The first meshes have the triangles, and nobody keeps them for whoever comes later.
  void waitForMonitor() const {
    for (const ros::Publisher& publisher : publishers_) {
      while (ros::ok() && publisher.getNumSubscribers() == 0) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    }
  }

  // Until the next is due; what is late by more than a period is left out.
  void sendNext(StatesWatch* watch) {
    const double steps_hz = options_.rate_hz * (options_.together ? 1.0 : objects_.size());
    const auto step = std::chrono::duration_cast<Clock::duration>(Seconds(1 / steps_hz));
    std::this_thread::sleep_until(due_);
    due_ = std::max(due_ + step, Clock::now() - step);
    const ros::Time stamp = ros::Time::now();
    if (stamp.isZero()) return;
    if (watch != nullptr) watch->noteSent(stamp);
    for (std::size_t i = 0; i < (options_.together ? objects_.size() : 1); ++i) {
      publishers_[next_].publish(objects_[next_].next(stamp, keyframePeriod()));
      next_ = (next_ + 1) % objects_.size();
      ++sent_;
    }
  }

  std::uint64_t sent() const { return sent_; }

 private:
  // Triangles once a second.
  std::size_t keyframePeriod() const {
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(options_.rate_hz)));
  }

  const LoadOptions options_;
  std::vector<LoadObject> objects_;
  std::vector<ros::Publisher> publishers_;
  Clock::time_point due_;
  std::size_t next_ = 0;
  std::uint64_t sent_ = 0;
};

void sendAndWatch(const LoadOptions& options) {
  LoadSender sender(options, options.mesh_file.empty() ? clothGrid(options.cells, 0.8F, 0, 0.02F)
                                                       : readMeshFile(options.mesh_file));
  const std::unique_ptr<StatesWatch> watch =
      options.unwatched ? nullptr : std::make_unique<StatesWatch>(options.monitor);
  sender.waitForMonitor();
  for (const Clock::time_point start = Clock::now();
       ros::ok() && Seconds(Clock::now() - start).count() < options.warm_up_s;) {
    sender.sendNext(watch.get());
  }
  if (watch) watch->beginAgain();
  const std::uint64_t sent_before = sender.sent();
  const Clock::time_point start = Clock::now();
  const auto print = [&](const char* kind, const nlohmann::json& figures) {
    nlohmann::json line{{"kind", kind},
                        {"seconds", Seconds(Clock::now() - start).count()},
                        {"sent", sender.sent() - sent_before}};
    if (!figures.is_null()) line.update(figures);
    std::cout << line.dump() << std::endl;
  };
  double printed_s = 0;
  while (ros::ok()) {
    sender.sendNext(watch.get());
    const double passed_s = Seconds(Clock::now() - start).count();
    if (options.seconds > 0 && passed_s >= options.seconds) break;
    if (passed_s - printed_s < options.period_s) continue;
    printed_s = passed_s;
    print("progress", watch ? watch->takeLatest() : nlohmann::json());
  }
  print("summary", watch ? watch->summary() : nlohmann::json());
}

void addOptions(CommandLine* line, LoadOptions* options) {
  line->add("--monitor", &options->monitor, "the node to watch");
  line->addFlag("--unwatched", &options->unwatched, "watch none");
  line->add("--objects", &options->objects, "how many");
  line->add("--first", &options->first, "number of the first of them");
  line->add("--links", &options->links, "how many links TF moves; 0: none of this client's");
  line->add("--cells", &options->cells, "the objects' meshes are grids of CELLS^2 x 2 triangles");
  line->add("--mesh", &options->mesh_file, "OBJ, PLY, STL or OFF instead of a grid");
  line->add("--rate", &options->rate_hz, "of each object [Hz]", isPositive());
  line->addFlag("--together", &options->together, "all objects' meshes have the same stamps");
  line->add("--warm-up", &options->warm_up_s, "time that does not count, before the rest [s]");
  line->add("--seconds", &options->seconds, "how long; 0: until SIGINT");
  line->add("--period", &options->period_s, "between lines [s]");
}

int run(const LoadOptions& options) {
  const ros::NodeHandle node;
  ros::AsyncSpinner spinner(1);  // /clock
  spinner.start();
  std::atomic<bool> stopped{false};
  std::thread mover;
  if (options.links > 0) mover = std::thread([&] { moveLinks(options.links, stopped); });
  const auto stop = [&] {
    stopped = true;
    if (mover.joinable()) mover.join();
  };
  try {
    if (options.objects > 0) {
      sendAndWatch(options);
    } else {
      ros::waitForShutdown();
    }
  } catch (...) {
    stop();
    throw;
  }
  stop();
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  using namespace deformable_contact_monitor;
  ros::init(argc, argv, "load_client", ros::init_options::AnonymousName);
  return runTool("load_client", [argc, argv] {
    CommandLine line("load_client",
                     "Loads a monitor with meshes and transforms, and watches its ~contact_states");
    LoadOptions options;
    addOptions(&line, &options);
    return line.parse(argc, argv) ? run(options) : 0;
  });
}
