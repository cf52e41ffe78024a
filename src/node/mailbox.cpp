// What service threads ask of the detection thread, and what wakes it.
#include "node/mailbox.h"

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

void Mailbox::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  stopped_ = true;
  wakeLocked();
}

void Mailbox::wakeLocked() {
  woken_ = true;
  wake_.notify_one();
}

bool Mailbox::wait(SteadyTime then) {
  std::unique_lock<std::mutex> lock(mutex_);
  wake_.wait_until(lock, then, [this] { return woken_ || stopped_; });
  woken_ = false;
  return !stopped_;
}

Requests Mailbox::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  Requests taken = std::exchange(requests_, Requests());
  requests_.enabled = taken.enabled;
  return taken;
}

}  // namespace deformable_contact_monitor
