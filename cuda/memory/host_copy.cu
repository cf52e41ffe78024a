#include "cuda/device/check.cuh"
#include "cuda/memory/host_copy.cuh"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned kThreads = 256, kWordsEach = 4;
constexpr std::uint32_t kWordsOfBlock = kThreads * kWordsEach;

// Makes all copies of the list. Each block finds its copy by its number, and copies up to
// kWordsOfBlock words, four for each thread. It loads all four before it stores any, because each
// load from the host's memory takes long.
__global__ void __launch_bounds__(kThreads) copyKernel(HostCopyList copies) {
  unsigned k = 0;
  while (k + 1 < copies.count && copies.first_block[k + 1] <= blockIdx.x) ++k;
  const std::uint32_t* const from = copies.from[k];
  std::uint32_t* const to = copies.to[k];
  const std::uint32_t words = copies.words[k], plus = copies.plus[k];
  const std::uint32_t first = (blockIdx.x - copies.first_block[k]) * kWordsOfBlock + threadIdx.x;
  std::uint32_t word[kWordsEach];
#pragma unroll
  for (unsigned i = 0; i < kWordsEach; ++i) {
    const std::uint32_t at = first + i * kThreads;
    if (at < words) word[i] = from == nullptr ? 0 : from[at] + plus;
  }
#pragma unroll
  for (unsigned i = 0; i < kWordsEach; ++i) {
    const std::uint32_t at = first + i * kThreads;
    if (at < words) to[at] = word[i];
  }
}

}  // namespace

void HostCopies::addWords(const std::uint32_t* from, std::size_t words, std::uint32_t* to,
                          std::uint32_t plus) {
  if (words == 0) return;
  if (list_.count == HostCopyList::kMost) launch();
  const unsigned k = list_.count++;
  list_.from[k] = from;
  list_.to[k] = to;
  list_.words[k] = static_cast<std::uint32_t>(words);
  list_.plus[k] = plus;
  list_.first_block[k] = blocks_;
  blocks_ += static_cast<std::uint32_t>((words + kWordsOfBlock - 1) / kWordsOfBlock);
}

void HostCopies::launch() {
  if (blocks_ > 0) copyKernel<<<blocks_, kThreads, 0, stream_>>>(list_);
  forget();
  checkCuda(cudaGetLastError(), "a kernel that copies from the host");
}

}  // namespace deformable_contact_monitor
