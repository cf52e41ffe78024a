#include "core/cpu/output.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {
namespace {

// By (a, b): a counting sort, then each triangle's few by comparison.
std::vector<WorkingContact> sorted(const std::vector<WorkingContact>& contacts,
                                   std::size_t triangle_count) {
  std::vector<std::uint32_t> begin(triangle_count + 1, 0);
  for (const WorkingContact& c : contacts) ++begin[c.a.value + 1];
  for (std::size_t i = 0; i < triangle_count; ++i) begin[i + 1] += begin[i];
  std::vector<WorkingContact> in_order(contacts.size());
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const WorkingContact& c : contacts) in_order[next[c.a.value]++] = c;
  for (std::size_t i = 0; i < triangle_count; ++i) {
    std::sort(in_order.begin() + begin[i], in_order.begin() + begin[i + 1],
              [](const WorkingContact& x, const WorkingContact& y) { return x.b < y.b; });
  }
  return in_order;
}

}  // namespace

// The working set's order is that of (body, triangle).
void writeContacts(const Scene& scene, const WorkingSet& set,
                   const std::vector<WorkingContact>& contacts, DetectionResult& result) {
  const std::vector<WorkingContact> in_order = sorted(contacts, set.size());
  const bool margins = scene.anyMargin();
  result.contacts.reserve(in_order.size());
  for (const WorkingContact& c : in_order) {
    const std::uint32_t a = c.a.value, b = c.b.value;
    result.contacts.push_back({set.body[a], set.triangle[a], set.body[b], set.triangle[b]});
    if (margins) result.separations_m.push_back(c.separation_m);
  }
}

}  // namespace deformable_contact_monitor
