#include <stdexcept>
#include <string>

#include "cuda/device/own_process.h"
#include "cuda/memory/copy_from_device.h"
#include "cuda/memory/device_vertices.cuh"

namespace deformable_contact_monitor {
namespace {

cudaStream_t streamOf(const Body& body) {
  return static_cast<cudaStream_t>(body.device_vertices->stream);
}

[[noreturn]] void refuse(const Body& body, const std::string& what) {
  cudaGetLastError();  // clears the error; the next check would report it again
  throw std::invalid_argument(body.name + ": " + what);
}

// Makes a device the current one, and afterwards the one that was.
class DeviceGuard {
 public:
  explicit DeviceGuard(int device) {
    checkCuda(cudaGetDevice(&before_), "cudaGetDevice");
    checkCuda(cudaSetDevice(device), "cudaSetDevice");
  }
  DeviceGuard(const DeviceGuard&) = delete;
  DeviceGuard& operator=(const DeviceGuard&) = delete;
  ~DeviceGuard() { cudaSetDevice(before_); }

 private:
  int before_ = 0;
};

}  // namespace

void copyFromDevice(void* to, const void* from, std::size_t bytes, void* stream) {
  requireOwnProcess();
  cudaPointerAttributes memory{};
  checkCuda(cudaPointerGetAttributes(&memory, from), "cudaPointerGetAttributes");
  if (memory.type != cudaMemoryTypeDevice && memory.type != cudaMemoryTypeManaged) {
    throw std::invalid_argument(
        "the array is said to be on a device, but that is no pointer of "
        "CUDA's");
  }
  const DeviceGuard guard(memory.device);
  auto* const of_array = static_cast<cudaStream_t>(stream);
  checkCuda(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, of_array), "cudaMemcpyAsync");
  checkCuda(cudaStreamSynchronize(of_array), "cudaStreamSynchronize");
}

void DeviceVerticesReader::requireReadable(const Body& body, int device) {
  cudaPointerAttributes memory{};
  checkCuda(cudaPointerGetAttributes(&memory, body.device_vertices->xyz),
            "cudaPointerGetAttributes");
  const bool managed = memory.type == cudaMemoryTypeManaged;
  if (memory.type != cudaMemoryTypeDevice && !managed) {
    refuse(body, "its vertices are said to be on a device, but that is no pointer of CUDA's");
  }
  if (memory.device != device && !managed) {
    refuse(body, "its vertices are on CUDA device " + std::to_string(memory.device) +
                     ", and the detector is on " + std::to_string(device));
  }
  cudaStreamCaptureStatus capture = cudaStreamCaptureStatusNone;
  const cudaError_t asked = cudaStreamIsCapturing(streamOf(body), &capture);
  if (asked == cudaErrorStreamCaptureImplicit || capture != cudaStreamCaptureStatusNone) {
    refuse(body, "the stream of its vertices is being captured, so nothing can wait for it");
  }
  checkCuda(asked, "cudaStreamIsCapturing");
}

void DeviceVerticesReader::copy(const Body& body, float* to, cudaStream_t stream) {
  const cudaError_t recorded = written_.tryRecord(streamOf(body));
  if (recorded == cudaErrorInvalidResourceHandle) {
    refuse(body, "the stream of its vertices is not one of the detector's device");
  }
  checkCuda(recorded, "cudaEventRecord");
  written_.makeWait(stream);
  checkCuda(cudaMemcpyAsync(to, body.device_vertices->xyz,
                            body.mesh.vertices.size() * sizeof(float), cudaMemcpyDefault, stream),
            "cudaMemcpyAsync on the device");
}

}  // namespace deformable_contact_monitor
