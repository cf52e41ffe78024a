#include "core/cpu/output.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/parallel.h"

namespace deformable_contact_monitor {
namespace {

constexpr std::size_t kBlock = 1 << 16;

// visit(contact) for the first `count` of them, until the limit is over.
template <class Hull, class Visit>
void forFirst(const ContactList<Hull>& contacts, std::size_t count, const CycleLimit& limit,
              const Visit& visit) {
  PacedLimit pace(limit, kBlock);
  for (const std::vector<WorkingContact<Hull>>& block : contacts.blocks()) {
    const std::size_t taken = std::min(count, block.size());
    if (pace.over(taken)) return;
    for (std::size_t i = 0; i < taken; ++i) visit(block[i]);
    count -= taken;
  }
}

// The first `count` by (a, b): a counting sort, then each triangle's few by comparison. Where the
// limit was over, they are of no use.
template <class Hull>
std::vector<WorkingContact<Hull>> sorted(const ContactList<Hull>& contacts, std::size_t count,
                                         std::size_t triangle_count, const CycleLimit& limit) {
  using Contact = WorkingContact<Hull>;
  std::vector<std::uint32_t> begin(triangle_count + 1, 0);
  forFirst(contacts, count, limit, [&](const Contact& c) { ++begin[c.a.value + 1]; });
  if (limit.wasOver()) return {};
  for (std::size_t i = 0; i < triangle_count; ++i) begin[i + 1] += begin[i];
  std::vector<Contact> in_order(count);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  forFirst(contacts, count, limit, [&](const Contact& c) { in_order[next[c.a.value]++] = c; });
  PacedLimit pace(limit, kBlock);
  const auto by_b = [](const Contact& x, const Contact& y) { return x.b < y.b; };
  for (std::size_t i = 0; i < triangle_count; ++i) {
    if (pace.over(1 + begin[i + 1] - begin[i])) break;
    sortWithin(limit, begin[i + 1] - begin[i], by_b, [&](const auto& less) {
      std::sort(in_order.begin() + begin[i], in_order.begin() + begin[i + 1], less);
    });
  }
  return in_order;
}

// What of the result's there is beside each contact; empties it.
struct Beside {
  bool separations, first_times, within_pad;

  Beside(const Scene& scene, const Options& options, DetectionResult& result)
      : separations(options.motion == Motion::kInstant && scene.anyMargin()),
        first_times(options.first_times),
        within_pad(options.motion == Motion::kSwept && scene.anyPad()) {
    result.separations_m.clear();
    result.first_times.clear();
    result.within_pad.clear();
  }

  void add(const WorkingContact<Triangle>& contact, DetectionResult& result) const {
    if (separations) result.separations_m.push_back(contact.separation_m);
  }
  void add(const WorkingContact<MovingTriangle>& contact, DetectionResult& result) const {
    if (first_times) result.first_times.push_back(contact.first);
    if (within_pad) result.within_pad.push_back(contact.within_pad ? 1 : 0);
  }
};

// Fills the lists with the first `count`. False if the limit was over before that was done.
template <class Hull>
bool writeFirst(const Scene& scene, const Options& options, const WorkingSet& set,
                const ContactList<Hull>& contacts, std::size_t count, const CycleLimit& limit,
                DetectionResult& result) {
  const std::vector<WorkingContact<Hull>> in_order = sorted(contacts, count, set.size(), limit);
  if (limit.wasOver()) return false;
  const Beside beside(scene, options, result);
  result.contacts.clear();
  result.contacts.reserve(count);
  serialBlocks(limit, count, kBlock, [&](std::size_t first, std::size_t end) {
    // The working set's order is that of (body, triangle).
    for (std::size_t i = first; i < end; ++i) {
      const std::uint32_t a = in_order[i].a.value, b = in_order[i].b.value;
      result.contacts.push_back({set.body[a], set.triangle[a], set.body[b], set.triangle[b]});
      beside.add(in_order[i], result);
    }
  });
  return !limit.wasOver();
}

}  // namespace

template <class Hull>
void writeContacts(const Scene& scene, const Options& options, const WorkingSet& set,
                   const ContactList<Hull>& contacts, const CycleLimit& limit,
                   DetectionResult& result) {
  const std::size_t found = contacts.size();
  const std::size_t few = std::min<std::size_t>(found, kMostListedLate);
  std::size_t listed = found;
  if (found == few || limit.over() ||
      !writeFirst(scene, options, set, contacts, found, limit, result)) {
    listed = few;
    writeFirst(scene, options, set, contacts, few, noLimit(), result);
  }
  result.left_out = contacts.leftOut() + found - listed;
  if (listed < found) result.cutOff(limit.why());
}

template void writeContacts(const Scene&, const Options&, const WorkingSet&,
                            const ContactList<Triangle>&, const CycleLimit&, DetectionResult&);
template void writeContacts(const Scene&, const Options&, const WorkingSet&,
                            const ContactList<MovingTriangle>&, const CycleLimit&,
                            DetectionResult&);

}  // namespace deformable_contact_monitor
