// What service threads ask of the detection thread, and what wakes it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "node/pair_table.h"

namespace deformable_contact_monitor {

struct Requests {
  bool reset = false;
  std::shared_ptr<const AllowedContacts> allowed_contacts;  // all in force; null: not changed
  bool enabled = true;                                      // as it was last asked for
};

// Threads may call every function at any time; one thread waits and takes.
class Mailbox {
 public:
  explicit Mailbox(AllowedContacts allowed)
      : allowed_(std::make_shared<const AllowedContacts>(std::move(allowed))) {}

  // Returns all rules in force then. Throws std::invalid_argument, and then changes none, if
  // AllowedContacts refuses a part of it. The thread that takes does not wait for it.
  std::vector<AllowedContact> changeAllowedContacts(const AllowedContactsChange& change);
  void requestReset();
  void setEnabled(bool enabled);

  // Ends wait(): something new lies elsewhere, a mesh or a robot.
  void wake();
  // Ends this wait() and every later one.
  void stop();
  // Set by stop(): for who works long between two looks at this.
  const std::atomic<bool>& stopped() const { return stopped_; }

  // Waits until `then`, or until one of the functions above is called, before or meanwhile. Returns
  // false once stop() was called.
  bool wait(SteadyTime then);

  // What was asked for since the last call.
  Requests take();

 private:
  void wakeLocked();

  std::mutex change_mutex_;                         // one change of the rules at a time
  std::shared_ptr<const AllowedContacts> allowed_;  // all in force, guarded by it

  std::mutex mutex_;  // guards what follows; never held for long
  std::condition_variable wake_;
  Requests requests_;
  bool woken_ = false;
  std::atomic<bool> stopped_{false};
};

}  // namespace deformable_contact_monitor
