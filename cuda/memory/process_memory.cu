#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "cuda/memory/device_pool.cuh"
#include "cuda/memory/process_memory.h"

namespace deformable_contact_monitor {
namespace {

// The functions of NVML that are used, with their types as in nvml.h. NVML stays open, as the
// driver does.
class Nvml {
 public:
  static const Nvml& instance() {
    static const auto* const nvml = new Nvml;
    return *nvml;
  }

  // Returns what the driver tells of this process on the device with that PCI address.
  std::optional<std::uint64_t> bytesOfThisProcess(const char* pci_address) const {
    void* device = nullptr;
    if (!works_ || find_device_(pci_address, &device) != 0) return std::nullopt;
    for (const List list : lists_) {
      const std::optional<std::uint64_t> bytes =
          list == nullptr ? std::nullopt : find(list, device);
      if (bytes) return bytes;
    }
    return std::nullopt;
  }

 private:
  struct Process {  // nvmlProcessInfo_t from version 2 on
    unsigned id;
    unsigned long long bytes;
    unsigned gpu_instance, compute_instance;
  };
  using Initialise = int (*)();
  using FindDevice = int (*)(const char*, void**);
  using List = int (*)(void*, unsigned*, Process*);

  Nvml() {
    void* const library = dlopen("libnvidia-ml.so.1", RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) return;
    const auto initialise = reinterpret_cast<Initialise>(dlsym(library, "nvmlInit_v2"));
    find_device_ = reinterpret_cast<FindDevice>(dlsym(library, "nvmlDeviceGetHandleByPciBusId_v2"));
    // A client of MPS is on a list of its own.
    lists_[0] = reinterpret_cast<List>(dlsym(library, "nvmlDeviceGetComputeRunningProcesses_v3"));
    lists_[1] =
        reinterpret_cast<List>(dlsym(library, "nvmlDeviceGetMPSComputeRunningProcesses_v3"));
    works_ = initialise != nullptr && find_device_ != nullptr && initialise() == 0;
  }

  static std::optional<std::uint64_t> find(List list, void* device) {
    constexpr unsigned kMostProcesses = 256;
    constexpr unsigned long long kUnknown = ~0ULL;
    std::vector<Process> processes(kMostProcesses);
    unsigned count = kMostProcesses;
    if (list(device, &count, processes.data()) != 0) return std::nullopt;
    const auto id = static_cast<unsigned>(getpid());
    const auto end = processes.begin() + std::min(count, kMostProcesses);
    const auto found = std::find_if(processes.begin(), end,
                                    [id](const Process& process) { return process.id == id; });
    if (found == end || found->bytes == 0 || found->bytes == kUnknown) return std::nullopt;
    return found->bytes;
  }

  FindDevice find_device_ = nullptr;
  List lists_[2] = {};
  bool works_ = false;
};

std::optional<std::uint64_t> bytesToldByDriver(int device) {
  char pci_address[32] = "";
  if (cudaDeviceGetPCIBusId(pci_address, sizeof pci_address, device) != cudaSuccess) {
    cudaGetLastError();  // an unknown address is no failure of the cycle
    return std::nullopt;
  }
  return Nvml::instance().bytesOfThisProcess(pci_address);
}

}  // namespace

ProcessMemory& ProcessMemory::of(int device) {
  static std::mutex mutex;
  static auto* const all = new std::map<int, std::unique_ptr<ProcessMemory>>;
  const std::lock_guard<std::mutex> lock(mutex);
  std::unique_ptr<ProcessMemory>& its = (*all)[device];
  if (its == nullptr) its = std::make_unique<ProcessMemory>(device);
  return *its;
}

MemoryUse ProcessMemory::afterCycle(unsigned kind) {
  const std::uint64_t pooled_bytes = DevicePool::ofCurrentDevice().bytes();
  const std::lock_guard<std::mutex> lock(mutex_);
  const bool is_new_kind = kinds_.insert(kind).second;
  if (!is_new_kind && pooled_bytes == pooled_bytes_) return last_;
  pooled_bytes_ = pooled_bytes;
  const std::optional<std::uint64_t> told = bytesToldByDriver(device_);
  last_ = {told.value_or(pooled_bytes), told.has_value()};
  return last_;
}

}  // namespace deformable_contact_monitor
