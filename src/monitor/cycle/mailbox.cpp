// What service threads ask of the detection thread, and what wakes it.
#include "monitor/cycle/mailbox.h"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

namespace deformable_contact_monitor {

std::vector<AllowedContact> Mailbox::changeAllowedContacts(const AllowedContactsChange& change) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  AllowedContacts allowed = *allowed_;
  allowed.change(change);
  allowed_ = std::make_shared<const AllowedContacts>(std::move(allowed));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_.allowed_contacts = allowed_;
    wakeLocked();
  }
  return allowed_->rules();
}

AttachedObjects Mailbox::attach(const std::string& object, std::vector<std::string> links) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  AttachedObjects attached = attached_;
  if (links.empty()) {
    attached.erase(object);
  } else {
    attached[object] = std::move(links);
  }
  useAttached(attached);
  return attached;
}

std::vector<std::string> Mailbox::releaseFromOthers(const std::set<std::string>& links) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  std::vector<std::string> released;
  AttachedObjects left;
  for (const auto& [object, holders] : attached_) {
    for (const std::string& link : holders) {
      if (links.count(link) > 0) {
        left[object].push_back(link);
      } else {
        released.push_back(std::string(object).append(" by ").append(link));
      }
    }
  }
  if (!released.empty()) useAttached(std::move(left));
  return released;
}

void Mailbox::useAttached(AttachedObjects attached) {
  attached_ = std::move(attached);
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.attached = std::make_shared<const AttachedObjects>(attached_);
  wakeLocked();
}

void Mailbox::change(const LiveParameters& live) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.live = live;
  wakeLocked();
}

void Mailbox::requestReset() {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.reset = true;
  wakeLocked();
}

void Mailbox::setEnabled(bool enabled) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.enabled = enabled;
  wakeLocked();
}

void Mailbox::wake() {
  const std::lock_guard<std::mutex> lock(mutex_);
  wakeLocked();
}

void Mailbox::expect() {
  const std::lock_guard<std::mutex> lock(mutex_);
  expects_ = true;
  wake_.notify_one();
}

void Mailbox::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  stopped_ = true;
  wakeLocked();
}

void Mailbox::wakeLocked() {
  woken_ = true;
  expects_ = false;
  wake_.notify_one();
}

bool Mailbox::wait(SteadyTime then) {
  std::unique_lock<std::mutex> lock(mutex_);
  const auto is_over = [this] { return woken_ || stopped_; };
  while (!is_over() && wake_.wait_until(lock, then, [&] { return is_over() || expects_; })) {
    if (expects_) stayAwake(&lock);
  }
  woken_ = false;
  return !stopped_;
}

void Mailbox::stayAwake(std::unique_lock<std::mutex>* lock) {
  constexpr std::chrono::milliseconds kMost(1);
  const auto end = std::chrono::steady_clock::now() + kMost;
  while (expects_ && !stopped_ && std::chrono::steady_clock::now() < end) {
    lock->unlock();
    std::this_thread::yield();
    lock->lock();
  }
  expects_ = false;
}

Requests Mailbox::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  Requests taken = std::exchange(requests_, Requests());
  requests_.enabled = taken.enabled;
  return taken;
}

}  // namespace deformable_contact_monitor
