// The contacts that were published last, for whoever asks later.
#pragma once

#include <deformable_contact_monitor/ContactArray.h>

#include <mutex>
#include <utility>

namespace deformable_contact_monitor {

// Threads may call every function at any time.
class LatestContacts {
 public:
  void set(boost::shared_ptr<const ContactArray> contacts) {
    const std::lock_guard<std::mutex> lock(mutex_);
    contacts_ = std::move(contacts);
  }

  // Null: nothing was published yet.
  boost::shared_ptr<const ContactArray> get() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return contacts_;
  }

 private:
  mutable std::mutex mutex_;
  boost::shared_ptr<const ContactArray> contacts_;
};

}  // namespace deformable_contact_monitor
