// read_link_mesh: reads one mesh file of a robot link, in a process that it may crash or fill, for
// robot/link_mesh_file.cpp.
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <new>
#include <string>

#include "robot/mesh_stream.h"
#include "robot/read_link_mesh/assimp_mesh.h"
#include "robot/reading_limits.h"

namespace deformable_contact_monitor {
namespace {

void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
  const rlimit limits{soft, hard};
  setrlimit(resource, &limits);
}

// Without a parent, nobody reads the answer.
void endWithParent() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  pollfd output{STDOUT_FILENO, 0, 0};
  const bool is_too_late = poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
  if (is_too_late) std::_Exit(1);
}

// The wall time is the parent's affair.
void limitThisProcess() {
  limit(RLIMIT_CPU, kMaxCpuS, kMaxCpuS + 1);
  limit(RLIMIT_CORE, 0, 0);  // a crash of it is an answer
  // Sanitizers reserve terabytes.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, kMaxMemoryMib * kBytesPerMib, kMaxMemoryMib * kBytesPerMib);
#endif
  // Where memory runs out before that, it ends this process and not the robot's.
  std::ofstream("/proc/self/oom_score_adj") << 1000;
}

bool write(const void* data, std::size_t bytes) {
  return std::fwrite(data, 1, bytes, stdout) == bytes;
}

bool writeMesh(const SourceMesh& mesh) {
  MeshStreamHeader header;
  header.vertices = mesh.vertices.size();
  header.triangles = mesh.triangles.size();
  return write(&header, sizeof(header)) &&
         write(mesh.vertices.data(), mesh.vertices.size() * sizeof(StreamVertex)) &&
         write(mesh.triangles.data(), mesh.triangles.size() * sizeof(StreamTriangle));
}

bool writeRefusal(const char* reason) {
  MeshStreamHeader header;
  header.refusal_bytes = std::min(std::strlen(reason), kMaxRefusalBytes);
  if (header.refusal_bytes == 0) return writeRefusal("cannot be read");
  return write(&header, sizeof(header)) && write(reason, header.refusal_bytes);
}

bool answer(const std::string& path) {
  try {
    return writeMesh(readWithAssimp(path));
  } catch (const std::bad_alloc&) {
    return writeRefusal(
        ("takes more than " + std::to_string(kMaxMemoryMib) + " MiB of memory to read").c_str());
  } catch (const std::exception& error) {
    return writeRefusal(error.what());
  }
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  if (argc != 2 || isatty(STDOUT_FILENO) == 1) {
    std::fputs("Usage: read_link_mesh FILE, by programs that load a robot; it writes binary data\n",
               stderr);
    return 2;
  }
  dcm::endWithParent();
  dcm::limitThisProcess();
  const bool is_written = dcm::answer(argv[1]) && std::fflush(stdout) == 0;
  std::_Exit(is_written ? 0 : 1);  // nothing is left to do that could go wrong
}
