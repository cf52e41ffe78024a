#include "core/bounds/merged_contacts.h"

#include <cstddef>
#include <iterator>
#include <utility>

#include "core/cpu/geometry.h"

namespace deformable_contact_monitor {
namespace {

// Moves what belongs to two lists of contacts into one, in the order in which they were merged.
template <class List>
void mergeBeside(const std::vector<bool>& from_second, const List& second, List& first) {
  List merged;
  merged.reserve(from_second.size());
  std::size_t next[2] = {0, 0};
  for (const bool is_second : from_second) {
    merged.push_back(is_second ? second[next[1]++] : first[next[0]++]);
  }
  first = std::move(merged);
}

}  // namespace

void mergeContacts(const Scene& scene, const Options& options,
                   const std::vector<ListedContact>& contacts, DetectionResult& result) {
  // Of pairs without a margin, in a scene that has one.
  if (scene.anyMargin()) result.separations_m.resize(result.contacts.size());
  if (contacts.empty()) return;
  const bool had_all_geometry = result.geometry.size() == result.contacts.size();
  DetectionResult added;
  added.contacts.reserve(contacts.size());
  for (const ListedContact& contact : contacts) {
    added.contacts.push_back(contact.pair);
    if (scene.anyMargin()) added.separations_m.push_back(contact.separation_m);
  }
  if (had_all_geometry) writeGeometry(scene, options, added);
  std::vector<bool> from_second;
  from_second.reserve(result.contacts.size() + contacts.size());
  std::size_t first = 0, second = 0;
  while (first < result.contacts.size() || second < contacts.size()) {
    const bool is_second =
        first == result.contacts.size() ||
        (second < contacts.size() && added.contacts[second] < result.contacts[first]);
    from_second.push_back(is_second);
    ++(is_second ? second : first);
  }
  mergeBeside(from_second, added.contacts, result.contacts);
  if (scene.anyMargin()) mergeBeside(from_second, added.separations_m, result.separations_m);
  if (options.geometry && had_all_geometry && added.geometry.size() == contacts.size()) {
    mergeBeside(from_second, added.geometry, result.geometry);
  } else {
    result.geometry.clear();
  }
}

}  // namespace deformable_contact_monitor
