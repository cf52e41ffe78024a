// A target as libFuzzer calls it, with counters: inputs, those past the first check, memory.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>

#include "fuzz_target.h"

namespace deformable_contact_monitor {
namespace {

struct Counters {
  std::atomic<std::uint64_t> inputs, passed, peak_kib;
};

// In the file that $DCM_FUZZ_COUNTERS names, which all processes of a run share, also those that
// crash; else in this process.
Counters* makeCounters() {
  static Counters own;
  const char* const path = std::getenv("DCM_FUZZ_COUNTERS");
  if (path == nullptr) return &own;
  const int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (file < 0 || ftruncate(file, sizeof(Counters)) != 0) {
    reportFinding(std::string(path) + ": cannot be written");
  }
  void* const shared = mmap(nullptr, sizeof(Counters), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  close(file);
  if (shared == MAP_FAILED) reportFinding(std::string(path) + ": cannot be mapped");
  return static_cast<Counters*>(shared);
}

Counters* counters() {
  static Counters* const counters = makeCounters();
  return counters;
}

void notePeak() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto kib = static_cast<std::uint64_t>(usage.ru_maxrss);
  std::uint64_t before = counters()->peak_kib;
  while (before < kib && !counters()->peak_kib.compare_exchange_weak(before, kib)) {
  }
}

void printCounters() {
  std::fprintf(stderr,
               "%s: %" PRIu64 " inputs, %" PRIu64 " past the first check, peak %" PRIu64 " MiB\n",
               fuzzTargets().at(0).name.c_str(), counters()->inputs.load(),
               counters()->passed.load(), counters()->peak_kib.load() / 1024);
}

}  // namespace
}  // namespace deformable_contact_monitor

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  namespace dcm = deformable_contact_monitor;
  static const int registered = std::atexit(dcm::printCounters);
  const std::uint64_t number = ++dcm::counters()->inputs;
  if (dcm::fuzzTargets().at(0).try_input(data, size)) ++dcm::counters()->passed;
  constexpr std::uint64_t kSeldom = 64;
  if (number % kSeldom == 0) dcm::notePeak();
  return registered;  // 0: it may become part of the corpus
}
