// Starts a reader process for each mesh file of a robot, a few at a time, and checks its answer.
// The answer is as untrusted as the file, because a bad file may have taken over the process:
// sizes, indices and the length of messages are checked here again.
#include "robot/link_mesh_files.h"

#include <algorithm>
#include <atomic>
#include <future>
#include <sstream>
#include <thread>
#include <utility>

#include "robot/mesh_stream.h"
#include "robot/reader_process.h"

namespace deformable_contact_monitor {
namespace {

using Clock = std::chrono::steady_clock;

// Checks the sizes before anything is allocated for them.
MeshStreamHeader readHeader(ReaderProcess& reader) {
  MeshStreamHeader header;
  reader.read(&header, sizeof(header));
  if (header.start != kMeshStreamStart) {
    throw std::runtime_error("its reader's answer is none: is it of another version?");
  }
  if (header.refusal_bytes > kMaxRefusalBytes || header.note_bytes > kMaxRefusalBytes ||
      !fitsMeshLimit(header.vertices, header.triangles, kMaxMeshMib * kBytesPerMib)) {
    throw std::runtime_error("more than " + std::to_string(kMaxMeshMib) +
                             " MiB of vertices and triangles");
  }
  return header;
}

// Reads the answer of a reader. Throws std::runtime_error with its reason if it rejected the file.
SourceMesh readMesh(ReaderProcess& reader) {
  const MeshStreamHeader header = readHeader(reader);
  if (header.refusal_bytes > 0) {
    std::string refusal(header.refusal_bytes, '\0');
    reader.read(refusal.data(), refusal.size());
    throw std::runtime_error(refusal);
  }
  SourceMesh mesh;
  mesh.vertices.resize(header.vertices);
  reader.read(mesh.vertices.data(), mesh.vertices.size() * sizeof(StreamVertex));
  mesh.triangles.resize(header.triangles);
  reader.read(mesh.triangles.data(), mesh.triangles.size() * sizeof(StreamTriangle));
  for (const StreamTriangle& triangle : mesh.triangles) {
    if (*std::max_element(triangle.begin(), triangle.end()) >= header.vertices) {
      throw std::runtime_error("its reader's answer has a vertex index out of range");
    }
  }
  mesh.note.resize(header.note_bytes);
  reader.read(mesh.note.data(), mesh.note.size());
  return mesh;
}

// Formats a time for a message, such as "2.5 s".
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
// kMaxReaders. If work() throws, its exception leaves this function after all threads have ended.
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

SourceMesh readLinkMeshFile(const std::string& path, const MeshReading& reading) {
  try {
    ReaderProcess reader(reading.program.empty() ? findReaderProgram() : reading.program, path,
                         reading.file_time, reading.stop);
    return readMesh(reader);
  } catch (const ReadingStopped&) {
    throw;
  } catch (const std::exception& e) {
    throw std::runtime_error(path + ": " + e.what());
  }
}

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

  // Threads write to different entries of the map and add none, so they need no lock.
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
      // Meshes count in the order in which they are read, so it is the last ones that are left out.
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
