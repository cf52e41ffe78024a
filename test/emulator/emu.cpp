#include <cuda_runtime.h>
#undef threadIdx
#undef blockIdx
#undef blockDim
#undef gridDim
#include <sys/mman.h>
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <execinfo.h>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <set>
#include <string>
#include <vector>

extern "C" void emuSwap(void** save, void* to);
asm(R"(
.text
.globl emuSwap
.hidden emuSwap
.type emuSwap,@function
emuSwap:
  pushq %rbp
  pushq %rbx
  pushq %r12
  pushq %r13
  pushq %r14
  pushq %r15
  movq %rsp, (%rdi)
  movq %rsi, %rsp
  popq %r15
  popq %r14
  popq %r13
  popq %r12
  popq %rbx
  popq %rbp
  ret
)");

namespace emu {

thread_local State state;

namespace {

int envInt(const char* name, int or_else) {
  const char* e = std::getenv(name);
  return e == nullptr ? or_else : std::atoi(e);
}
const int kOrder = envInt("EMU_ORDER", 0);  // 0 in order, 1 reversed, >= 2 random by that seed
const bool kLazy = envInt("EMU_LAZY", 0) != 0;
const bool kTrace = envInt("EMU_TRACE", 0) != 0;
const bool kPoison = envInt("EMU_POISON", 1) != 0;

struct Machine {
  void* main_sp = nullptr;
  std::vector<Fiber> fibers = std::vector<Fiber>(1024);
  std::vector<Warp> warps = std::vector<Warp>(32);
  std::vector<unsigned char> shared = std::vector<unsigned char>(256 * 1024 + 256);
  const std::function<void()>* body = nullptr;
  const char* name = "";
  unsigned threads = 0, alive = 0, at_barrier = 0;
  int barrier_count = 0, barrier_result_count = 0;
  struct Random {
    using result_type = std::uint32_t;
    std::uint64_t s;
    static constexpr result_type min() { return 0; }
    static constexpr result_type max() { return ~0U; }
    result_type operator()() { s ^= s << 13; s ^= s >> 7; s ^= s << 17; return static_cast<result_type>(s >> 16); }
  } random{0x9E3779B97F4A7C15ULL * static_cast<unsigned>(kOrder + 1)};
};
Machine& machine() {
  static thread_local Machine* m = new Machine;
  return *m;
}

constexpr std::size_t kStack = 512 * 1024;

void tryComplete(Warp& w, unsigned mask) {
  const unsigned wanted = mask & w.alive;
  if (wanted == 0 || (wanted & ~w.waiting) != 0) return;
  const void* f = nullptr;
  for (unsigned l = 0; l < 32; ++l) {
    if (!(wanted >> l & 1)) continue;
    if (w.slot[l].mask != mask) return;  // waits for others: not yet
    if (f == nullptr) f = w.slot[l].complete;
    if (f != w.slot[l].complete) fail("lanes of a warp are at different collectives");
  }
  reinterpret_cast<Complete>(const_cast<void*>(f))(w, wanted);
  w.waiting &= ~wanted;
  w.runnable |= wanted;
}

void toMain() {
  Fiber* f = state.now;
  emuSwap(&f->sp, machine().main_sp);
}

void entry() {
  Machine& m = machine();
  (*m.body)();
  Fiber* f = state.now;
  Warp& w = *f->warp;
  const unsigned bit = 1U << f->lane;
  w.alive &= ~bit;
  w.runnable &= ~bit;
  --m.alive;
  for (unsigned rest = w.waiting; rest != 0;) {
    const unsigned l = static_cast<unsigned>(__builtin_ctz(rest));
    const unsigned mask = w.slot[l].mask;
    rest &= ~mask & ~(1U << l);
    if (w.waiting >> l & 1) tryComplete(w, mask);
  }
  toMain();
  std::abort();
}

void start(Fiber& f) {
  if (f.stack == nullptr) {
    f.stack = mmap(nullptr, kStack, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (f.stack == MAP_FAILED) std::abort();
    mprotect(f.stack, 4096, PROT_NONE);
  }
  auto** top = reinterpret_cast<void**>(static_cast<char*>(f.stack) + kStack - 64);
  *--top = nullptr;                              // alignment, as behind a call
  *--top = reinterpret_cast<void*>(&entry);      // ret
  for (int i = 0; i < 6; ++i) *--top = nullptr;  // registers
  f.sp = top;
}

void releaseBarrier(Machine& m) {
  m.barrier_result_count = m.barrier_count;
  m.barrier_count = 0;
  m.at_barrier = 0;
  const unsigned warps = (m.threads + 31) / 32;
  for (unsigned w = 0; w < warps; ++w) {
    m.warps[w].runnable |= m.warps[w].atBarrier;
    m.warps[w].atBarrier = 0;
  }
}

std::string trace() {
  std::string s;
  if (state.now != nullptr) {
    s += std::string(" in ") + machine().name + " block " + std::to_string(state.block.x) + " thread " +
         std::to_string(state.now->number);
  }
  return s;
}

void runBlock(Machine& m) {
  const unsigned warps = (m.threads + 31) / 32;
  m.alive = m.threads;
  m.at_barrier = 0;
  m.barrier_count = 0;
  for (unsigned w = 0; w < warps; ++w) {
    Warp& warp = m.warps[w];
    const unsigned n = std::min(32U, m.threads - 32 * w);
    warp.alive = warp.runnable = n == 32 ? ~0U : (1U << n) - 1;
    warp.waiting = warp.atBarrier = 0;
  }
  for (unsigned t = 0; t < m.threads; ++t) {
    Fiber& f = m.fibers[t];
    f.number = t;
    f.tid = {t % state.blockDim.x, t / state.blockDim.x % state.blockDim.y, t / state.blockDim.x / state.blockDim.y};
    f.lane = t % 32;
    f.warp = &m.warps[t / 32];
    start(f);
  }
  std::vector<unsigned> order(warps);
  for (unsigned w = 0; w < warps; ++w) order[w] = kOrder == 1 ? warps - 1 - w : w;
  while (m.alive > 0) {
    if (kOrder > 1) std::shuffle(order.begin(), order.end(), m.random);
    bool ran = false;
    for (unsigned w : order) {
      Warp& warp = m.warps[w];
      while (warp.runnable != 0) {
        ran = true;
        unsigned l;
        if (kOrder == 0) l = static_cast<unsigned>(__builtin_ctz(warp.runnable));
        else if (kOrder == 1) l = 31 - static_cast<unsigned>(__builtin_clz(warp.runnable));
        else {
          const unsigned turn = m.random() & 31;
          const unsigned rotated = turn == 0 ? warp.runnable : warp.runnable >> turn | warp.runnable << (32 - turn);
          l = (static_cast<unsigned>(__builtin_ctz(rotated)) + turn) & 31;
        }
        Fiber& f = m.fibers[32 * w + l];
        state.now = &f;
        emuSwap(&m.main_sp, f.sp);
        state.now = nullptr;
      }
    }
    if (m.alive > 0 && m.at_barrier == m.alive) {
      releaseBarrier(m);
    } else if (!ran) {
      std::fprintf(stderr, "EMU deadlock in %s block %u:\n", m.name, state.block.x);
      for (unsigned w = 0; w < warps; ++w) {
        std::fprintf(stderr, "  warp %u alive %08x waiting %08x barrier %08x; masks", w, m.warps[w].alive,
                     m.warps[w].waiting, m.warps[w].atBarrier);
        for (unsigned l = 0; l < 32; ++l)
          if (m.warps[w].waiting >> l & 1) std::fprintf(stderr, " %u:%08x", l, m.warps[w].slot[l].mask);
        std::fprintf(stderr, "\n");
      }
      fail("deadlock");
    }
  }
}

void runKernel(dim3 grid, dim3 block, std::size_t shared, const std::function<void()>& body, const char* name) {
  Machine& m = machine();
  if (state.now != nullptr) fail("a launch from a kernel");
  const auto t0 = std::chrono::steady_clock::now();
  m.body = &body;
  m.name = name;
  m.threads = block.x * block.y * block.z;
  if (m.threads == 0 || m.threads > 1024) fail("threads of a block", name);
  state.blockDim = block;
  state.gridDim = grid;
  const std::uint64_t blocks = std::uint64_t{grid.x} * grid.y * grid.z;
  const std::uint64_t turn = kOrder > 1 && blocks > 0 ? m.random() % blocks : 0;
  for (std::uint64_t b = 0; b < blocks; ++b) {
    const std::uint64_t k = kOrder == 1 ? blocks - 1 - b : (b + turn) % blocks;
    state.block = {static_cast<unsigned>(k % grid.x), static_cast<unsigned>(k / grid.x % grid.y),
                   static_cast<unsigned>(k / grid.x / grid.y)};
    if (shared > 0) std::memset(dynamicShared(), 0xcd, std::min<std::size_t>(shared, 227 * 1024));
    runBlock(m);
  }
  if (kTrace) {
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - t0).count();
    std::fprintf(stderr, "EMU %-90.90s %ux%u %.2f ms\n", name, grid.x, block.x, ms);
  }
}

std::recursive_mutex queue_mutex;
std::deque<std::function<void()>> queue;
void flush() {
  if (!kLazy) return;
  const std::lock_guard<std::recursive_mutex> lock(queue_mutex);
  while (!queue.empty()) {
    const auto f = std::move(queue.front());
    queue.pop_front();
    f();
  }
}

}  // namespace

void fail(const char* what, const char* where) {
  std::fprintf(stderr, "EMU FAULT: %s %s%s\n", what, where, trace().c_str());
  void* frames[40];
  backtrace_symbols_fd(frames, backtrace(frames, 40), 2);
  std::abort();
}
void failIndex(std::uint64_t i, std::uint64_t rows, const char* where) {
  std::fprintf(stderr, "EMU FAULT: index %llu of %llu\n", static_cast<unsigned long long>(i),
               static_cast<unsigned long long>(rows));
  fail("index beyond its array", where);
}

void collective(unsigned mask, std::uint64_t value, int arg, Complete complete) {
  Fiber* f = state.now;
  Warp& w = *f->warp;
  const unsigned bit = 1U << f->lane;
  if ((mask & bit) == 0) fail("a lane calls a collective of others");
  Slot& s = w.slot[f->lane];
  s.value = value;
  s.mask = mask;
  s.arg = arg;
  s.complete = reinterpret_cast<const void*>(complete);
  w.waiting |= bit;
  w.runnable &= ~bit;
  tryComplete(w, mask);
  if (w.waiting & bit) toMain();
}

int barrier(int value, int kind) {
  Machine& m = machine();
  Fiber* f = state.now;
  Warp& w = *f->warp;
  const unsigned bit = 1U << f->lane;
  w.runnable &= ~bit;
  w.atBarrier |= bit;
  ++m.at_barrier;
  m.barrier_count += value;
  const unsigned threads = m.threads;
  toMain();
  const int r = m.barrier_result_count;
  return kind == 1 ? r : kind == 2 ? r != 0 : kind == 3 ? r == static_cast<int>(threads) : 0;
}

void* dynamicShared() {
  const auto p = reinterpret_cast<std::uintptr_t>(machine().shared.data());
  return reinterpret_cast<void*>((p + 127) / 128 * 128);
}

}  // namespace emu

// ------------------------------------------------------------------ the runtime
using namespace emu;

namespace {
using Closure = std::function<void()>;
thread_local cudaError_t last_error = cudaSuccess;
cudaError_t result(cudaError_t e) {
  if (e != cudaSuccess) last_error = e;
  return e;
}
struct Region { std::size_t bytes; cudaMemoryType type; void* base; std::size_t all; };
std::mutex regions_mutex;
std::map<std::uintptr_t, Region> regions;
std::size_t device_bytes = 0;
constexpr std::size_t kDeviceBytes = std::size_t{6} << 30, kGuard = 4096;

const Region* find(const void* p) {
  const auto a = reinterpret_cast<std::uintptr_t>(p);
  auto it = regions.upper_bound(a);
  if (it == regions.begin()) return nullptr;
  --it;
  return a < it->first + std::max<std::size_t>(it->second.bytes, 1) ? &it->second : nullptr;
}
cudaError_t allocate(void** p, std::size_t n, cudaMemoryType type) {
  const std::lock_guard<std::mutex> lock(regions_mutex);
  *p = nullptr;
  if (n == 0) return cudaSuccess;
  if (type == cudaMemoryTypeDevice && device_bytes + n > kDeviceBytes) return result(cudaErrorMemoryAllocation);
  // The end of what was asked for lies right before a page that cannot be touched (but for alignment).
  const std::size_t rounded = (n + 255) / 256 * 256;
  const std::size_t all = (rounded + 4095) / 4096 * 4096 + 2 * kGuard;
  void* base = mmap(nullptr, all, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (base == MAP_FAILED) return result(cudaErrorMemoryAllocation);
  mprotect(base, kGuard, PROT_NONE);
  mprotect(static_cast<char*>(base) + all - kGuard, kGuard, PROT_NONE);
  auto* at = static_cast<unsigned char*>(base) + all - kGuard - rounded;
  if (kPoison) std::memset(at, type == cudaMemoryTypeDevice ? 0xcb : 0xcd, n);
  if (type == cudaMemoryTypeDevice) device_bytes += n;
  regions[reinterpret_cast<std::uintptr_t>(at)] = {n, type, base, all};
  *p = at;
  return cudaSuccess;
}
cudaError_t release(void* p) {
  if (p == nullptr) return cudaSuccess;
  flush();
  const std::lock_guard<std::mutex> lock(regions_mutex);
  const auto it = regions.find(reinterpret_cast<std::uintptr_t>(p));
  if (it == regions.end()) fail("free of what was not allocated");
  if (it->second.type == cudaMemoryTypeDevice) device_bytes -= it->second.bytes;
  munmap(it->second.base, it->second.all);
  regions.erase(it);
  return cudaSuccess;
}
bool onDevice(const void* p, std::size_t n, bool& inside) {
  const std::lock_guard<std::mutex> lock(regions_mutex);
  const Region* r = find(p);
  inside = true;
  if (r == nullptr) return false;
  auto it = regions.upper_bound(reinterpret_cast<std::uintptr_t>(p));
  --it;
  inside = reinterpret_cast<std::uintptr_t>(p) + n <= it->first + r->bytes;
  return r->type != cudaMemoryTypeHost;
}
}  // namespace

struct CUgraph_st { std::vector<Closure> steps; std::vector<std::string> names; };
struct CUgraphExec_st { std::vector<Closure> steps; std::vector<std::string> names; };
struct CUevent_st { std::chrono::steady_clock::time_point time{}; bool recorded = false; };
struct CUstream_st { std::set<CUgraph_st*> into; };

namespace {
thread_local CUgraph_st* capturing = nullptr;
thread_local cudaStream_t capture_stream = nullptr;
thread_local std::set<cudaStream_t> captured;
thread_local std::set<cudaEvent_t> captured_events;

void put(cudaStream_t stream, Closure f, const std::string& name) {
  if (capturing != nullptr && captured.count(stream) != 0) {
    capturing->steps.push_back(std::move(f));
    capturing->names.push_back(name);
    return;
  }
  if (!kLazy) return f();
  const std::lock_guard<std::recursive_mutex> lock(queue_mutex);
  queue.push_back(std::move(f));
}
bool isCaptured(cudaStream_t s) { return capturing != nullptr && captured.count(s) != 0; }
}  // namespace

namespace emu {
void enqueue(cudaStream_t stream, std::function<void()> what) { put(stream, std::move(what), "cub"); }
void launch(dim3 grid, dim3 block, std::size_t shared, cudaStream_t stream, std::function<void()> thread,
            const char* name) {
  if (grid.x == 0 || grid.y == 0 || grid.z == 0 || block.x == 0) {
    result(cudaErrorInvalidConfiguration);
    return;
  }
  if (shared > 227 * 1024) { result(cudaErrorInvalidValue); return; }
  put(stream, [=] { runKernel(grid, block, shared, thread, name); }, std::string("kernel ") + name);
}
}  // namespace emu

extern "C" {
cudaError_t cudaMalloc(void** p, size_t n) { return allocate(p, n, cudaMemoryTypeDevice); }
cudaError_t cudaFree(void* p) { return release(p); }
cudaError_t cudaMallocAsync(void** p, size_t n, cudaStream_t) { return allocate(p, n, cudaMemoryTypeDevice); }
cudaError_t cudaFreeAsync(void* p, cudaStream_t) { return release(p); }
cudaError_t cudaHostAlloc(void** p, size_t n, unsigned) { return allocate(p, n, cudaMemoryTypeHost); }
cudaError_t cudaMallocHost(void** p, size_t n) { return allocate(p, n, cudaMemoryTypeHost); }
cudaError_t cudaFreeHost(void* p) { return release(p); }
cudaError_t cudaMallocManaged(void** p, size_t n, unsigned) { return allocate(p, n, cudaMemoryTypeManaged); }
cudaError_t cudaMemGetInfo(size_t* f, size_t* t) { *t = kDeviceBytes; *f = kDeviceBytes - device_bytes; return cudaSuccess; }
cudaError_t cudaHostGetDevicePointer(void** d, void* h, unsigned) { *d = h; return cudaSuccess; }
cudaError_t cudaPointerGetAttributes(cudaPointerAttributes* a, const void* p) {
  const std::lock_guard<std::mutex> lock(regions_mutex);
  const Region* r = find(p);
  *a = {};
  a->type = r == nullptr ? cudaMemoryTypeUnregistered : r->type;
  if (r != nullptr) a->devicePointer = a->hostPointer = const_cast<void*>(p);
  return cudaSuccess;
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, size_t n, cudaMemcpyKind kind, cudaStream_t s) {
  bool in_to, in_from;
  const bool to_device = onDevice(to, n, in_to), from_device = onDevice(from, n, in_from);
  if (n > 0) {
    if (!in_to || !in_from) fail("a copy goes beyond its memory");
    if (kind == cudaMemcpyHostToDevice && (!to_device)) fail("copy to the device goes to the host");
    if (kind == cudaMemcpyDeviceToHost && (!from_device)) fail("copy from the device reads the host");
    if (kind == cudaMemcpyDeviceToDevice && !(to_device && from_device)) fail("copy on the device");
  }
  bool pinned;
  { const std::lock_guard<std::mutex> lock(regions_mutex); pinned = find(from) != nullptr; }
  if (!pinned && kLazy && !isCaptured(s)) {  // pageable memory is staged at the call
    auto bytes = std::make_shared<std::vector<unsigned char>>(static_cast<const unsigned char*>(from), static_cast<const unsigned char*>(from) + n);
    put(s, [=] { std::memmove(to, bytes->data(), n); }, "copy");
    return cudaSuccess;
  }
  put(s, [=] { std::memmove(to, from, n); }, "copy");
  { const std::lock_guard<std::mutex> lock(regions_mutex); pinned = find(to) != nullptr; }
  if (!pinned && !isCaptured(s)) flush();  // to pageable memory: it waits
  return cudaSuccess;
}
cudaError_t cudaMemcpy(void* to, const void* from, size_t n, cudaMemcpyKind kind) {
  const cudaError_t e = cudaMemcpyAsync(to, from, n, kind, nullptr);
  flush();
  return e;
}
cudaError_t cudaMemcpy2DAsync(void* to, size_t tp, const void* from, size_t fp, size_t w, size_t h, cudaMemcpyKind, cudaStream_t s) {
  put(s, [=] { for (size_t i = 0; i < h; ++i) std::memmove(static_cast<char*>(to) + i * tp, static_cast<const char*>(from) + i * fp, w); }, "copy");
  return cudaSuccess;
}
cudaError_t cudaMemsetAsync(void* p, int v, size_t n, cudaStream_t s) {
  bool inside;
  if (n > 0 && !onDevice(p, n, inside)) fail("memset of the host");
  if (n > 0 && !inside) fail("memset goes beyond its memory");
  put(s, [=] { std::memset(p, v, n); }, "memset");
  return cudaSuccess;
}
cudaError_t cudaMemset(void* p, int v, size_t n) { return cudaMemsetAsync(p, v, n, nullptr); }
cudaError_t cudaStreamCreate(cudaStream_t* s) { *s = new CUstream_st; return cudaSuccess; }
cudaError_t cudaStreamCreateWithFlags(cudaStream_t* s, unsigned) { return cudaStreamCreate(s); }
cudaError_t cudaStreamCreateWithPriority(cudaStream_t* s, unsigned, int) { return cudaStreamCreate(s); }
cudaError_t cudaStreamDestroy(cudaStream_t s) { flush(); delete s; return cudaSuccess; }
cudaError_t cudaStreamQuery(cudaStream_t s) {
  if (isCaptured(s)) return result(cudaErrorStreamCaptureUnsupported);
  flush(); return cudaSuccess;
}
cudaError_t cudaStreamSynchronize(cudaStream_t s) {
  if (isCaptured(s)) return result(cudaErrorStreamCaptureUnsupported);
  flush(); return cudaSuccess;
}
cudaError_t cudaDeviceSynchronize() { flush(); return cudaSuccess; }
cudaError_t cudaDeviceReset() { flush(); return cudaSuccess; }
cudaError_t cudaStreamWaitEvent(cudaStream_t s, cudaEvent_t e, unsigned) {
  if (capturing != nullptr && captured_events.count(e) != 0) captured.insert(s);
  return cudaSuccess;
}
cudaError_t cudaEventCreate(cudaEvent_t* e) { *e = new CUevent_st; return cudaSuccess; }
cudaError_t cudaEventCreateWithFlags(cudaEvent_t* e, unsigned) { return cudaEventCreate(e); }
cudaError_t cudaEventDestroy(cudaEvent_t e) { flush(); delete e; return cudaSuccess; }
cudaError_t cudaEventRecord(cudaEvent_t e, cudaStream_t s) {
  if (isCaptured(s)) captured_events.insert(e);
  put(s, [=] { e->time = std::chrono::steady_clock::now(); e->recorded = true; }, "event");
  return cudaSuccess;
}
cudaError_t cudaEventSynchronize(cudaEvent_t) { flush(); return cudaSuccess; }
cudaError_t cudaEventQuery(cudaEvent_t) { flush(); return cudaSuccess; }
cudaError_t cudaEventElapsedTime(float* ms, cudaEvent_t a, cudaEvent_t b) {
  flush();
  if (!a->recorded || !b->recorded) return result(cudaErrorInvalidResourceHandle);
  *ms = std::chrono::duration<float, std::milli>(b->time - a->time).count();
  return cudaSuccess;
}
cudaError_t cudaStreamBeginCapture(cudaStream_t s, cudaStreamCaptureMode) {
  if (capturing != nullptr) return result(cudaErrorIllegalState);
  capturing = new CUgraph_st;
  capture_stream = s;
  captured = {s};
  captured_events.clear();
  return cudaSuccess;
}
cudaError_t cudaStreamEndCapture(cudaStream_t s, cudaGraph_t* g) {
  *g = nullptr;
  if (capturing == nullptr || s != capture_stream) return result(cudaErrorIllegalState);
  *g = capturing;
  capturing = nullptr;
  captured.clear();
  return cudaSuccess;
}
cudaError_t cudaStreamIsCapturing(cudaStream_t s, cudaStreamCaptureStatus* st) {
  *st = isCaptured(s) ? cudaStreamCaptureStatusActive : cudaStreamCaptureStatusNone;
  return cudaSuccess;
}
cudaError_t cudaGraphDestroy(cudaGraph_t g) { delete g; return cudaSuccess; }
cudaError_t cudaGraphInstantiateWithFlags(cudaGraphExec_t* x, cudaGraph_t g, unsigned long long) {
  *x = new CUgraphExec_st{g->steps, g->names};
  return cudaSuccess;
}
cudaError_t cudaGraphInstantiate(cudaGraphExec_t* x, cudaGraph_t g, unsigned long long f) { return cudaGraphInstantiateWithFlags(x, g, f); }
cudaError_t cudaGraphExecUpdate(cudaGraphExec_t x, cudaGraph_t g, cudaGraphExecUpdateResultInfo*) {
  if (x->names != g->names) return result(cudaErrorGraphExecUpdateFailure);
  x->steps = g->steps;
  return cudaSuccess;
}
cudaError_t cudaGraphExecDestroy(cudaGraphExec_t x) { flush(); delete x; return cudaSuccess; }
cudaError_t cudaGraphUpload(cudaGraphExec_t, cudaStream_t) { return cudaSuccess; }
cudaError_t cudaGraphLaunch(cudaGraphExec_t x, cudaStream_t s) {
  put(s, [steps = x->steps] { for (const auto& f : steps) f(); }, "graph");
  return cudaSuccess;
}
cudaError_t cudaLaunchHostFunc(cudaStream_t s, cudaHostFn_t f, void* d) { put(s, [=] { f(d); }, "host"); return cudaSuccess; }
cudaError_t cudaGetLastError() { const cudaError_t e = last_error; last_error = cudaSuccess; return e; }
cudaError_t cudaPeekAtLastError() { return last_error; }
const char* cudaGetErrorString(cudaError_t e) {
  static thread_local std::string s;
  s = e == cudaSuccess ? "no error" : e == cudaErrorMemoryAllocation ? "out of memory" : "CUDA error " + std::to_string(e);
  return s.c_str();
}
const char* cudaGetErrorName(cudaError_t e) { return cudaGetErrorString(e); }
cudaError_t cudaGetDeviceCount(int* n) { *n = 1; return cudaSuccess; }
cudaError_t cudaGetDevice(int* d) { *d = 0; return cudaSuccess; }
cudaError_t cudaSetDevice(int d) { return d == 0 ? cudaSuccess : result(cudaErrorInvalidDevice); }
cudaError_t cudaDriverGetVersion(int* v) { *v = 13000; return cudaSuccess; }
cudaError_t cudaRuntimeGetVersion(int* v) { *v = 13000; return cudaSuccess; }
cudaError_t cudaDeviceGetAttribute(int* v, cudaDeviceAttr a, int) {
  static const int sms = std::getenv("EMU_SMS") ? std::atoi(std::getenv("EMU_SMS")) : 2;
  switch (a) {
    case cudaDevAttrMultiProcessorCount: *v = sms; break;
    case cudaDevAttrComputeCapabilityMajor: *v = 9; break;
    case cudaDevAttrComputeCapabilityMinor: *v = 0; break;
    case cudaDevAttrMaxSharedMemoryPerBlockOptin: *v = 227 * 1024; break;
    case cudaDevAttrMaxSharedMemoryPerMultiprocessor: *v = 228 * 1024; break;
    case cudaDevAttrMaxSharedMemoryPerBlock: *v = 48 * 1024; break;
    case cudaDevAttrMaxThreadsPerMultiProcessor: *v = 2048; break;
    case cudaDevAttrConcurrentManagedAccess: *v = 1; break;
    default: *v = 0; break;
  }
  return cudaSuccess;
}
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* p, int) {
  *p = {};
  std::strcpy(p->name, "emulated");
  p->major = 9;
  p->multiProcessorCount = 2;
  p->totalGlobalMem = kDeviceBytes;
  return cudaSuccess;
}
cudaError_t cudaFuncSetAttribute(const void*, cudaFuncAttribute, int) { return cudaSuccess; }
}
