// What service threads ask of the detection thread, and what wakes it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/steady_time.h"
#include "monitor/rules/contact_rules.h"
#include "monitor/rules/live_parameters.h"

namespace deformable_contact_monitor {

struct Requests {
  bool reset = false;
  std::shared_ptr<const AllowedContacts> allowed_contacts;  // all in force; null: not changed
  std::shared_ptr<const AttachedObjects> attached;          // all that are held; null: not changed
  std::optional<LiveParameters> live;                       // nothing: not changed
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

  // The object is held by these links, by no others any more; no link: by none. Returns all objects
  // that are held then.
  AttachedObjects attach(const std::string& object, std::vector<std::string> links);
  // Links that are not among `links` hold nothing any more. Returns what they held, "cloth by
  // hand" each.
  std::vector<std::string> releaseFromOthers(const std::set<std::string>& links);

  void change(const LiveParameters& live);
  void requestReset();
  void setEnabled(bool enabled);

  // Ends wait(): something new lies elsewhere, a mesh or a robot.
  void wake();
  // A wake() will follow soon: wait() stays awake for it, a millisecond at most, for a thread takes
  // its time to get up.
  void expect();
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
  void stayAwake(std::unique_lock<std::mutex>* lock);

  void useAttached(AttachedObjects attached);

  std::mutex change_mutex_;  // one change of the rules at a time; it guards those in force
  std::shared_ptr<const AllowedContacts> allowed_;
  AttachedObjects attached_;

  std::mutex mutex_;  // guards what follows; never held for long
  std::condition_variable wake_;
  Requests requests_;
  bool woken_ = false, expects_ = false;
  std::atomic<bool> stopped_{false};
};

}  // namespace deformable_contact_monitor
