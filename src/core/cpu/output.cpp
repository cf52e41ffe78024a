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
template <class Visit>
void forFirst(const ContactList& contacts, std::size_t count, const CycleLimit& limit,
              const Visit& visit) {
  PacedLimit pace(limit, kBlock);
  for (const std::vector<WorkingContact>& block : contacts.blocks()) {
    const std::size_t taken = std::min(count, block.size());
    if (pace.over(taken)) return;
    for (std::size_t i = 0; i < taken; ++i) visit(block[i]);
    count -= taken;
  }
}

// The first `count` by (a, b): a counting sort, then each triangle's few by comparison. Where the
// limit was over, they are of no use.
std::vector<WorkingContact> sorted(const ContactList& contacts, std::size_t count,
                                   std::size_t triangle_count, const CycleLimit& limit) {
  std::vector<std::uint32_t> begin(triangle_count + 1, 0);
  forFirst(contacts, count, limit, [&](const WorkingContact& c) { ++begin[c.a.value + 1]; });
  if (limit.wasOver()) return {};
  for (std::size_t i = 0; i < triangle_count; ++i) begin[i + 1] += begin[i];
  std::vector<WorkingContact> in_order(count);
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  forFirst(contacts, count, limit,
           [&](const WorkingContact& c) { in_order[next[c.a.value]++] = c; });
  PacedLimit pace(limit, kBlock);
  const auto by_b = [](const WorkingContact& x, const WorkingContact& y) { return x.b < y.b; };
  for (std::size_t i = 0; i < triangle_count; ++i) {
    if (pace.over(1 + begin[i + 1] - begin[i])) break;
    sortWithin(limit, begin[i + 1] - begin[i], by_b, [&](const auto& less) {
      std::sort(in_order.begin() + begin[i], in_order.begin() + begin[i + 1], less);
    });
  }
  return in_order;
}

// Fills the lists with the first `count`. False if the limit was over before that was done.
bool writeFirst(const Scene& scene, const WorkingSet& set, const ContactList& contacts,
                std::size_t count, const CycleLimit& limit, DetectionResult& result) {
  const std::vector<WorkingContact> in_order = sorted(contacts, count, set.size(), limit);
  if (limit.wasOver()) return false;
  const bool margins = scene.anyMargin();
  result.contacts.clear();
  result.separations_m.clear();
  result.contacts.reserve(count);
  serialBlocks(limit, count, kBlock, [&](std::size_t first, std::size_t end) {
    // The working set's order is that of (body, triangle).
    for (std::size_t i = first; i < end; ++i) {
      const std::uint32_t a = in_order[i].a.value, b = in_order[i].b.value;
      result.contacts.push_back({set.body[a], set.triangle[a], set.body[b], set.triangle[b]});
      if (margins) result.separations_m.push_back(in_order[i].separation_m);
    }
  });
  return !limit.wasOver();
}

}  // namespace

void writeContacts(const Scene& scene, const WorkingSet& set, const ContactList& contacts,
                   const CycleLimit& limit, DetectionResult& result) {
  const std::size_t found = contacts.size();
  const std::size_t few = std::min<std::size_t>(found, kMostListedLate);
  std::size_t listed = found;
  if (found == few || limit.over() || !writeFirst(scene, set, contacts, found, limit, result)) {
    listed = few;
    writeFirst(scene, set, contacts, few, noLimit(), result);
  }
  result.left_out = contacts.leftOut() + found - listed;
  if (listed < found) result.cutOff(limit.why());
}

}  // namespace deformable_contact_monitor
