// Requests of other threads to the detection thread, and what wakes it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/steady_time.h"
#include "monitor/rules/contact_rules.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// All requests since the detection thread last took them.
struct Requests {
  bool reset = false;
  std::shared_ptr<const AllowedContacts> allowed_contacts;  // all rules in force; null: unchanged
  std::shared_ptr<const AttachedObjects> attached;          // all attachments; null: unchanged
  std::optional<LiveParameters> live;                       // nothing: unchanged
  bool disabled = false;                                    // perhaps enabled again meanwhile
  bool enabled = true;                                      // as last asked for
  std::uint64_t epoch = 0;  // how often everything known was to be discarded, since the start
};

// What is in force, for threads that look at bodies by the same rules.
struct InForce {
  std::uint64_t revision = 0;  // grows with every change of the next three
  std::shared_ptr<const AllowedContacts> allowed_contacts;
  std::shared_ptr<const AttachedObjects> attached;
  std::optional<LiveParameters> live;  // nothing: as at the start
  bool enabled = true;
  // The detection thread has not yet taken the request to discard everything known.
  bool discards = false;
};

// Collects what services, rqt_reconfigure and the robot source ask of the detection thread, and
// wakes that thread. Any thread may call every function at any time; only the detection thread
// calls wait() and take().
class LoopRequests {
 public:
  // `allowed` are the rules in force at the start.
  explicit LoopRequests(AllowedContacts allowed);

  // Changes the allowed contacts and returns all rules that are in force then. Throws
  // std::invalid_argument, and changes nothing, if AllowedContacts rejects a part of the change.
  std::vector<AllowedContact> changeAllowedContacts(const AllowedContactsChange& change);

  // Attaches the object, or this part of it, to these links, and detaches it from all others; no
  // links: from all. A rigid object has a grip. Returns all attachments then.
  AttachedObjects attach(const std::string& object, std::vector<std::string> links,
                         std::shared_ptr<const HeldPart> part = nullptr,
                         std::shared_ptr<const RigidGrip> grip = nullptr);
  // Returns what is in force now. It never waits for a change that takes long.
  InForce inForce();
  // Returns all attachments.
  AttachedObjects attached();
  // Detaches each of these objects whose same part is attached still. Returns them in words.
  std::vector<std::string> endHolds(const AttachedObjects& ended);
  // Detaches all objects from those that are not among `holders`, the robot's links and the rigid
  // objects; and a rigid object from all if the link that carries it is not. Returns what was
  // detached, as "cloth by hand" each.
  std::vector<std::string> releaseFromOthers(const std::set<std::string>& holders);

  void change(const LiveParameters& live);
  // Either function, unless it enables, asks that everything known is discarded. Returns the epoch
  // that begins with it: what was found in a cycle of an earlier one must not become known any more
  // (ContactStateTracker::discard()), also if that cycle is still running.
  std::uint64_t requestReset();
  std::uint64_t setEnabled(bool enabled);

  // Ends wait(), as a new mesh or robot waits elsewhere.
  void wake();
  // Ends this wait() and every later one.
  void stop();
  // Returns the flag that stop() sets. Long computations poll it.
  const std::atomic<bool>& stopped() const { return stopped_; }

  // Waits until `then`, or until one of the functions above was called, before or meanwhile.
  // Returns false once stop() was called.
  bool wait(SteadyTime then);

  // Returns what was asked for since the last call.
  Requests take();

 private:
  void wakeLocked();
  void useAttached(AttachedObjects attached);

  // Guards the next two members. It is held while rules are changed, which may take long.
  std::mutex change_mutex_;
  std::shared_ptr<const AllowedContacts> allowed_;
  AttachedObjects attached_;

  std::mutex mutex_;  // guards the members below; never held for long
  std::condition_variable wake_;
  Requests requests_;
  InForce in_force_;
  bool woken_ = false;
  std::atomic<bool> stopped_{false};
};

}  // namespace deformable_contact_monitor
