// What was published last, for whoever asks later.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>
#include <deformable_contact_monitor/ContactStates.h>

#include <mutex>
#include <utility>

namespace deformable_contact_monitor {

struct PublishedCycle {
  boost::shared_ptr<const ContactArray> contacts;  // null: nothing published yet
  boost::shared_ptr<const ContactStates> states;
};

// Threads may call every function at any time.
class LatestCycle {
 public:
  void set(PublishedCycle cycle) {
    const std::lock_guard<std::mutex> lock(mutex_);
    cycle_ = std::move(cycle);
  }

  PublishedCycle get() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return cycle_;
  }

 private:
  mutable std::mutex mutex_;
  PublishedCycle cycle_;
};

}  // namespace deformable_contact_monitor
