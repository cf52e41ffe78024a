// Requests of other threads to the detection thread. Rules are changed under a lock of their own,
// so that the detection thread never waits for a change, but only for a pointer to its result.
#include "monitor/cycle/loop_requests.h"

#include <algorithm>
#include <utility>

#include "monitor/rules/rule_texts.h"

namespace deformable_contact_monitor {

LoopRequests::LoopRequests(AllowedContacts allowed)
    : allowed_(std::make_shared<const AllowedContacts>(std::move(allowed))) {
  in_force_.allowed_contacts = allowed_;
  in_force_.attached = std::make_shared<const AttachedObjects>();
}

InForce LoopRequests::inForce() {
  const std::lock_guard<std::mutex> lock(mutex_);
  InForce in_force = in_force_;
  in_force.discards = requests_.reset || requests_.disabled;
  return in_force;
}

std::vector<AllowedContact> LoopRequests::changeAllowedContacts(
    const AllowedContactsChange& change) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  AllowedContacts allowed = *allowed_;
  allowed.change(change);
  allowed_ = std::make_shared<const AllowedContacts>(std::move(allowed));
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    requests_.allowed_contacts = allowed_;
    in_force_.allowed_contacts = allowed_;
    ++in_force_.revision;
    wakeLocked();
  }
  return allowed_->rules();
}

AttachedObjects LoopRequests::attach(const std::string& object, std::vector<std::string> links,
                                     std::shared_ptr<const HeldPart> part,
                                     std::shared_ptr<const RigidGrip> grip) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  AttachedObjects attached = attached_;
  if (links.empty()) {
    attached.erase(object);
  } else {
    attached[object] = {std::move(links), std::move(part), std::move(grip)};
  }
  useAttached(attached);
  return attached;
}

AttachedObjects LoopRequests::attached() {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  return attached_;
}

// The detection thread has detached them already, so nothing is requested.
std::vector<std::string> LoopRequests::endHolds(const AttachedObjects& ended) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  std::vector<std::string> texts;
  for (const auto& [object, attachment] : ended) {
    const auto found = attached_.find(object);
    if (found == attached_.end() || found->second.part != attachment.part) continue;
    texts.push_back(describeEndedHold(object, found->second));
    attached_.erase(found);
  }
  if (texts.empty()) return texts;
  const std::lock_guard<std::mutex> lock(mutex_);
  in_force_.attached = std::make_shared<const AttachedObjects>(attached_);
  ++in_force_.revision;
  // A request that waits must not bring them back.
  if (requests_.attached) requests_.attached = in_force_.attached;
  return texts;
}

// Keeps the links that the robot still has.
std::vector<std::string> LoopRequests::releaseFromOthers(const std::set<std::string>& holders) {
  const std::lock_guard<std::mutex> changing(change_mutex_);
  std::vector<std::string> released;
  AttachedObjects left;
  for (const auto& [object, attachment] : attached_) {
    const std::shared_ptr<const RigidGrip>& grip = attachment.grip;
    const bool falls = grip != nullptr && holders.count(grip->link) == 0;
    for (const std::string& link : attachment.links) {
      if (!falls && holders.count(link) > 0) {
        left[object].links.push_back(link);
        left[object].part = attachment.part;
        left[object].grip = grip;
      } else {
        released.push_back(std::string(object).append(" by ").append(link));
      }
    }
  }
  if (!released.empty()) useAttached(std::move(left));
  return released;
}

void LoopRequests::useAttached(AttachedObjects attached) {
  attached_ = std::move(attached);
  const std::lock_guard<std::mutex> lock(mutex_);
  in_force_.attached = std::make_shared<const AttachedObjects>(attached_);
  ++in_force_.revision;
  requests_.attached = in_force_.attached;
  wakeLocked();
}

void LoopRequests::change(const LiveParameters& live) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.live = in_force_.live = live;
  ++in_force_.revision;
  wakeLocked();
}

std::uint64_t LoopRequests::requestReset() {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.reset = true;
  wakeLocked();
  return ++requests_.epoch;
}

std::uint64_t LoopRequests::setEnabled(bool enabled) {
  const std::lock_guard<std::mutex> lock(mutex_);
  requests_.enabled = in_force_.enabled = enabled;
  requests_.disabled = requests_.disabled || !enabled;
  wakeLocked();
  return requests_.epoch += enabled ? 0 : 1;
}

void LoopRequests::wake() {
  const std::lock_guard<std::mutex> lock(mutex_);
  wakeLocked();
}

void LoopRequests::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  stopped_ = true;
  wakeLocked();
}

void LoopRequests::wakeLocked() {
  woken_ = true;
  wake_.notify_one();
}

bool LoopRequests::wait(SteadyTime then) {
  std::unique_lock<std::mutex> lock(mutex_);
  wake_.wait_until(lock, then, [this] { return woken_ || stopped_; });
  woken_ = false;
  return !stopped_;
}

// All requests are events, except `enabled` and `epoch`: they stay as they were last asked for.
Requests LoopRequests::take() {
  const std::lock_guard<std::mutex> lock(mutex_);
  Requests taken = std::exchange(requests_, Requests());
  requests_.enabled = taken.enabled;
  requests_.epoch = taken.epoch;
  return taken;
}

}  // namespace deformable_contact_monitor
