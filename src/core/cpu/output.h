// Stage `output`: contacts of the working set as the result's sorted list.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/cycle_limit.h"
#include "core/cpu/contact_list.h"
#include "core/cpu/transform.h"
#include "core/detector.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Keeps its buffers from call to call. Hull: as in hull.h.
template <class Hull>
class ContactWriter {
 public:
  // Fills result.contacts, result.left_out and what there is beside each contact: separations_m if
  // scene.anyMargin(), or, of what moves, first_times and within_pad as the options and the scene
  // ask; all were empty. Once the limit is over, no more contacts than are sorted in little time:
  // then others are left out, and the result says that it was cut off.
  void write(const Scene& scene, const Options& options, const WorkingSet& set,
             const ContactList<Hull>& contacts, const CycleLimit& limit, DetectionResult& result);

 private:
  // Some of one of the list's blocks.
  struct Part {
    const WorkingContact<Hull>* begin;
    std::size_t size;
  };

  bool writeFirst(const Scene& scene, const Options& options, const WorkingSet& set,
                  const ContactList<Hull>& contacts, std::size_t count, const CycleLimit& limit,
                  DetectionResult& result);
  void takeFirst(const ContactList<Hull>& contacts, std::size_t count);
  void intoBuckets(std::size_t triangle_count, const CycleLimit& limit);

  std::vector<Part> parts_;
  std::vector<WorkingContact<Hull>> in_order_;
  // Contacts whose first triangles are in one range of 2^bucket_shift_ are a bucket: where each
  // begins, at last the end.
  unsigned bucket_shift_ = 0;
  std::vector<std::uint32_t> bucket_begin_;
  std::vector<std::uint32_t> place_;  // for each bucket, of each batch of parts: the next one's
};

}  // namespace deformable_contact_monitor
