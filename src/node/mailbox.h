// What service threads ask of the detection thread, and what wakes it.
#pragma once

#include <deformable_contact_monitor/AllowedContact.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

#include "node/pair_table.h"

namespace deformable_contact_monitor {

struct Requests {
  bool reset = false;
  std::optional<AllowedContacts> allowed_contacts;  // all rules in force, if they were changed
  bool enabled = true;                              // as it was last asked for
};

// Threads may call every function at any time; one thread waits and takes.
class Mailbox {
 public:
  explicit Mailbox(AllowedContacts allowed) : allowed_(std::move(allowed)) {}

  // Adds all of `rules` and returns all in force. Throws std::invalid_argument, and then adds none,
  // if AllowedContacts refuses one.
  std::vector<AllowedContact> addAllowedContacts(const std::vector<AllowedContact>& rules);
  void requestReset();
  void setEnabled(bool enabled);

  // Ends wait(): something new lies elsewhere, a mesh or a robot.
  void wake();
  // Ends this wait() and every later one.
  void stop();

  // Waits until `then`, or until one of the functions above is called, before or meanwhile. Returns
  // false once stop() was called.
  bool wait(std::chrono::steady_clock::time_point then);

  // What was asked for since the last call.
  Requests take();

 private:
  void wakeLocked();

  std::mutex mutex_;  // guards what follows
  std::condition_variable wake_;
  Requests requests_;
  AllowedContacts allowed_;  // all rules in force
  bool woken_ = false, stopped_ = false;
};

}  // namespace deformable_contact_monitor
