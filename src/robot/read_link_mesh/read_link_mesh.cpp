// read_link_mesh: reads one mesh file of a robot link for robot/link_mesh_files.cpp, and writes the
// mesh or an error to its standard output (mesh_stream.h). The file may crash this process, fill
// its memory or keep it busy: limits end it, and its parent says why.
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
#include "robot/read_link_mesh/foreign_mesh.h"
#include "robot/reading_limits.h"

namespace deformable_contact_monitor {
namespace {

// Sets a limit of this process. An error is ignored: the parent's limit of the wall time remains.
void limit(__rlimit_resource resource, rlim_t soft, rlim_t hard) {
  const rlimit limits{soft, hard};
  setrlimit(resource, &limits);
}

// Ends this process when its parent ends, since nobody would read the answer. The kernel sends the
// signal only if the parent ends after prctl(). If the parent ended before, the pipe has no reader
// any more, which poll() reports as an error.
void endWithParent() {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  pollfd output{STDOUT_FILENO, 0, 0};
  const bool is_too_late = poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
  if (is_too_late) std::_Exit(1);
}

// Limits processor time and memory. The parent limits the wall time.
void limitThisProcess() {
  limit(RLIMIT_CPU, kMaxCpuS, kMaxCpuS + 1);
  limit(RLIMIT_CORE, 0, 0);  // no core file: a crash is an answer
  // Sanitizers reserve terabytes of address space, so there is no limit with them.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  limit(RLIMIT_AS, kMaxMemoryMib * kBytesPerMib, kMaxMemoryMib * kBytesPerMib);
#endif
  // If the machine runs out of memory first, the kernel ends this process and not the robot's.
  std::ofstream("/proc/self/oom_score_adj") << 1000;
}

bool write(const void* data, std::size_t bytes) {
  return std::fwrite(data, 1, bytes, stdout) == bytes;
}

bool writeMesh(const SourceMesh& mesh) {
  MeshStreamHeader header;
  header.vertices = mesh.vertices.size();
  header.triangles = mesh.triangles.size();
  header.note_bytes = std::min(mesh.note.size(), kMaxRefusalBytes);
  return write(&header, sizeof(header)) &&
         write(mesh.vertices.data(), mesh.vertices.size() * sizeof(StreamVertex)) &&
         write(mesh.triangles.data(), mesh.triangles.size() * sizeof(StreamTriangle)) &&
         write(mesh.note.data(), header.note_bytes);
}

// Writes the reason, cut to its longest length. A text of no length would mean that a mesh follows,
// so an empty reason is replaced.
bool writeRefusal(const char* reason) {
  MeshStreamHeader header;
  header.refusal_bytes = std::min(std::strlen(reason), kMaxRefusalBytes);
  if (header.refusal_bytes == 0) return writeRefusal("cannot be read");
  return write(&header, sizeof(header)) && write(reason, header.refusal_bytes);
}

// Reads the file, and writes the mesh or the reason why there is none. Returns false if the output
// could not be written.
bool answer(const std::string& path) {
  try {
    return writeMesh(readForeignMesh(path));
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
  const bool is_help = argc == 2 && std::string(argv[1]) == "--help";
  if (is_help || argc != 2 || isatty(STDOUT_FILENO) == 1) {
    std::fputs("Usage: read_link_mesh FILE, by programs that load a robot; it writes binary data\n",
               is_help ? stdout : stderr);
    return is_help ? 0 : 2;
  }
  dcm::endWithParent();
  dcm::limitThisProcess();
  const bool is_written = dcm::answer(argv[1]) && std::fflush(stdout) == 0;
  std::_Exit(is_written ? 0 : 1);  // skips destructors, which could still fail
}
