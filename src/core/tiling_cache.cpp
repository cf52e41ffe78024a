#include "core/tiling_cache.h"

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <vector>

#include "core/common/forks.h"

namespace deformable_contact_monitor {
namespace {

// A tiling that was ordered from the thread. The caller and the thread share it.
struct Order {
  TriangleMesh mesh;                     // only the thread reads it; emptied when it is done
  std::atomic<bool> stop{false};         // set by the caller, who then ignores the result
  std::shared_ptr<const Tiling> tiling;  // null: it is not done, or failed
};

// Makes an ordered tiling. Returns null if there is not enough memory.
std::shared_ptr<const Tiling> tilingOf(const Order& order) {
  Limits limits;
  limits.stop = &order.stop;
  try {
    return std::make_shared<const Tiling>(tilingBySurface(order.mesh, limits));
  } catch (const std::exception&) {
    return nullptr;
  }
}

// Owns the thread that makes the ordered tilings, the newest order first. All public functions are
// called from one thread.
class Worker {
 public:
  ~Worker() {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ends_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }

  // Queues an order. It is dropped if its last other owner is gone before the thread begins it.
  void take(const std::shared_ptr<Order>& order) {
    if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      orders_.push_back(order);
    }
    changed_.notify_all();
  }

  std::shared_ptr<const Tiling> resultOf(const Order& order) {
    const std::lock_guard<std::mutex> lock(mutex_);
    return order.tiling;
  }

  void wait() {
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return orders_.empty() && !works_; });
  }

 private:
  void run() {
    while (const std::shared_ptr<Order> order = next()) {
      std::shared_ptr<const Tiling> tiling = tilingOf(*order);
      order->mesh = {};
      const std::lock_guard<std::mutex> lock(mutex_);
      order->tiling.swap(tiling);
    }
  }

  // Waits for an order. Returns null when the thread must end.
  std::shared_ptr<Order> next() {
    std::unique_lock<std::mutex> lock(mutex_);
    works_ = false;
    while (true) {
      if (orders_.empty()) changed_.notify_all();
      changed_.wait(lock, [this] { return ends_ || !orders_.empty(); });
      if (ends_) return nullptr;
      std::shared_ptr<Order> order = orders_.back().lock();
      orders_.pop_back();
      works_ = order != nullptr;
      if (works_) return order;
    }
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::weak_ptr<Order>> orders_;
  bool works_ = false;  // the thread makes a tiling
  bool ends_ = false;   // the thread must end
  std::thread thread_;  // the last member, because it uses the others
};

// The tilings of one process. All functions are called from one thread.
class Tilings {
 public:
  Tilings() = default;
  Tilings(const Tilings&) = delete;
  Tilings& operator=(const Tilings&) = delete;
  ~Tilings() {
    for (auto& [topology, known] : known_) stop(known);
  }

  std::shared_ptr<const Tiling> of(const Body& body) {
    Known& known = known_[body.topology_revision];
    if (known.round == round_ || ++calls_ > kMostCalls) {
      known.round = ++round_;
      calls_ = 0;
      forget();
    }
    known.round = round_;
    if (known.order != nullptr) return worker_.resultOf(*known.order);
    if (++known.calls < TilingCache::kSettledAfter) return nullptr;
    known.order = std::make_shared<Order>();
    known.order->mesh = body.mesh;
    worker_.take(known.order);
    return nullptr;
  }

  void wait() { worker_.wait(); }

 private:
  // A round ends after so many calls, even if no topology is asked for twice.
  static constexpr std::size_t kMostCalls = 1 << 16;

  struct Known {
    std::uint64_t round = 0;  // the last round in which it was asked for
    std::uint32_t calls = 0;  // how often it was asked for
    std::shared_ptr<Order> order;
  };

  static void stop(const Known& known) {
    if (known.order != nullptr) known.order->stop = true;
  }

  // Forgets what was not asked for in three rounds. A round ends when a topology is asked for that
  // was asked for in it already: callers ask for each body once per cycle.
  void forget() {
    for (auto i = known_.begin(); i != known_.end();) {
      const bool is_old = i->second.round + 3 < round_;
      if (is_old) stop(i->second);
      i = is_old ? known_.erase(i) : std::next(i);
    }
  }

  std::unordered_map<std::uint64_t, Known> known_;  // by topology_revision
  std::uint64_t round_ = 1;
  std::size_t calls_ = 0;  // in this round
  Worker worker_;          // destroyed first, which waits for orders that are stopped
};

}  // namespace

// Owns the tilings. In a forked process, those that were there stay as they are, because they have
// a thread that is gone, which may hold their lock. New ones are made there.
class TilingCache::State {
 public:
  ~State() {
    if (forks_ != forkCount()) static_cast<void>(tilings_.release());
  }

  Tilings& tilings() {
    if (forks_ != forkCount()) {
      static_cast<void>(tilings_.release());
      tilings_ = std::make_unique<Tilings>();
      forks_ = forkCount();
    }
    return *tilings_;
  }

 private:
  unsigned forks_ = forkCount();
  std::unique_ptr<Tilings> tilings_ = std::make_unique<Tilings>();
};

TilingCache::TilingCache() : state_(std::make_unique<State>()) {}
TilingCache::~TilingCache() = default;

std::shared_ptr<const Tiling> TilingCache::of(const Body& body) noexcept {
  try {
    return state_->tilings().of(body);
  } catch (const std::exception&) {
    return nullptr;
  }
}

void TilingCache::wait() { state_->tilings().wait(); }

}  // namespace deformable_contact_monitor
