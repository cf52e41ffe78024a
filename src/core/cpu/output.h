// Stage `output`: writes the contacts of the working set as the result's sorted list.
//
// Contacts come in blocks, in any order. They are first put into buckets by their first triangle,
// then each bucket is sorted on its own thread.
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

// Writes a result's contacts. It keeps its buffers from call to call.
template <class Primitive>
class ContactWriter {
 public:
  // Fills in result.contacts, result.left_out, and the arrays parallel to the contacts:
  // separations_m if scene.anyMargin(), or, in continuous detection, first_times and within_pad as
  // the options and the scene ask for. All of them must be empty before. Once the limit is over, it
  // writes only as many contacts as can be sorted in little time; the others are counted in
  // left_out, and the result says that it was cut off.
  void write(const Scene& scene, const Options& options, const WorkingSet& set,
             const ContactList<Primitive>& contacts, const CycleLimit& limit,
             DetectionResult& result);

 private:
  // A part of one of the list's blocks.
  struct Part {
    const WorkingContact<Primitive>* begin;
    std::size_t size;
  };

  bool writeFirst(const Scene& scene, const Options& options, const WorkingSet& set,
                  const ContactList<Primitive>& contacts, std::size_t count,
                  const CycleLimit& limit, DetectionResult& result);
  void takeFirst(const ContactList<Primitive>& contacts, std::size_t count);
  void intoBuckets(std::size_t triangle_count, const CycleLimit& limit);

  std::vector<Part> parts_;
  std::vector<WorkingContact<Primitive>> in_order_;
  // A bucket holds the contacts whose first triangles are in one range of 2^bucket_shift_. These
  // are the places where buckets begin, and the end of the last one.
  unsigned bucket_shift_ = 0;
  std::vector<std::uint32_t> bucket_begin_;
  std::vector<std::uint32_t> place_;  // next free place of each bucket, for each batch of parts
};

}  // namespace deformable_contact_monitor
