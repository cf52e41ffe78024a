// All mesh files of a robot.
#include "robot/link_mesh_files.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

std::string seconds(std::chrono::milliseconds time) {
  std::ostringstream text;
  text << std::chrono::duration<double>(time).count() << " s";
  return text.str();
}

std::size_t meshBytes(const SourceMesh& mesh) {
  return mesh.vertices.size() * sizeof(mesh.vertices[0]) +
         mesh.triangles.size() * sizeof(mesh.triangles[0]);
}

// Calls work(i) for each i < count, on as many threads as there are cores, but not on more than
// kMaxReaders.
template <typename Work>
void forEachInParallel(std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto loop = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  const unsigned cores = std::max(std::thread::hardware_concurrency(), 1U);
  const std::size_t threads = std::min<std::size_t>(std::min(cores, kMaxReaders), count);
  std::vector<std::future<void>> others;
  for (std::size_t i = 1; i < threads; ++i) others.push_back(std::async(std::launch::async, loop));
  loop();
  for (std::future<void>& other : others) other.get();
}

}  // namespace

LinkMeshFiles::LinkMeshFiles(const std::vector<std::string>& uris, const ResourceResolver& resolve,
                             const MeshReading& reading) {
  for (const std::string& uri : uris) {
    if (path_of_.count(uri) + problem_of_.count(uri) > 0) continue;
    try {
      files_.emplace(path_of_[uri] = resolve(uri), File());
    } catch (const std::exception& e) {
      path_of_.erase(uri);
      problem_of_[uri] = e.what();
    }
  }

  std::vector<std::map<std::string, File>::value_type*> files;
  for (auto& entry : files_) files.push_back(&entry);
  const Clock::time_point deadline = Clock::now() + reading.robot_time;
  std::atomic<std::size_t> bytes{0};
  forEachInParallel(files.size(), [&](std::size_t i) {
    auto& [path, file] = *files[i];
    MeshReading this_reading = reading;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    this_reading.file_time = std::min(reading.file_time, left);
    try {
      if (left.count() <= 0) {
        throw std::runtime_error(path + ": not read, for the robot's files took " +
                                 seconds(reading.robot_time));
      }
      SourceMesh mesh = readLinkMeshFile(path, this_reading);
      if ((bytes += meshBytes(mesh)) > reading.robot_mib * kBytesPerMib) {
        throw std::runtime_error(path + ": left out, for the robot's meshes take more than " +
                                 std::to_string(reading.robot_mib) + " MiB");
      }
      file.mesh = std::move(mesh);
    } catch (const ReadingStopped&) {
      throw;
    } catch (const std::exception& e) {
      file.problem = e.what();
    }
  });
}

const SourceMesh& LinkMeshFiles::mesh(const std::string& uri) const {
  const auto unresolved = problem_of_.find(uri);
  if (unresolved != problem_of_.end()) throw std::runtime_error(unresolved->second);
  const File& file = files_.at(path_of_.at(uri));
  if (!file.problem.empty()) throw std::runtime_error(file.problem);
  return file.mesh;
}

}  // namespace deformable_contact_monitor
