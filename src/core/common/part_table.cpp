#include "core/common/part_table.h"

#include <algorithm>

namespace deformable_contact_monitor {

PartTable::PartTable(const Scene& scene) : scene_(&scene) {
  numberParts();
  enablePairs();
  findIdleParts();
}

void PartTable::numberParts() {
  std::uint32_t count = 0;
  numbers_.resize(scene_->bodyCount());
  for (BodyId id = 0; id < scene_->bodyCount(); ++id) {
    if (!scene_->takesPart(id)) continue;
    const std::vector<PartId>& listed = scene_->body(id).listed_parts;
    numbers_[id].resize(std::size_t{listed.back()} + 1);
    for (const PartId part : listed) numbers_[id][part] = count++;
  }
  row_words_ = PartPairs::wordsFor(count);
  bits_.resize(std::size_t{count} * row_words_);
  takes_part_.resize(count);
}

// Enables all parts of enabled bodies, and then disables single pairs.
void PartTable::enablePairs() {
  const auto place = [this](std::uint32_t a, std::uint32_t b) {
    return std::size_t{a} * row_words_ + b / 32;
  };
  const auto bit = [](std::uint32_t b) { return 1U << b % 32; };
  for (const auto& [a, b] : scene_->enabledPairs()) {
    for (const PartId part_a : scene_->body(a).listed_parts) {
      for (const PartId part_b : scene_->body(b).listed_parts) {
        const std::uint32_t i = numberOf(a, part_a), j = numberOf(b, part_b);
        bits_[place(i, j)] |= bit(j);
        bits_[place(j, i)] |= bit(i);
      }
    }
  }
  const auto has = [this](BodyId id, PartId part) {
    const std::vector<PartId>& listed = scene_->body(id).listed_parts;
    return !numbers_[id].empty() && std::binary_search(listed.begin(), listed.end(), part);
  };
  for (const PartPair& pair : scene_->disabledParts()) {
    if (!has(pair.body_a, pair.part_a) || !has(pair.body_b, pair.part_b)) continue;
    const std::uint32_t i = numberOf(pair.body_a, pair.part_a);
    const std::uint32_t j = numberOf(pair.body_b, pair.part_b);
    bits_[place(i, j)] &= ~bit(j);
    bits_[place(j, i)] &= ~bit(i);
  }
}

void PartTable::findIdleParts() {
  for (std::uint32_t i = 0; i < count(); ++i) {
    const auto row = bits_.begin() + static_cast<std::ptrdiff_t>(std::size_t{i} * row_words_);
    takes_part_[i] =
        std::any_of(row, row + row_words_, [](std::uint32_t word) { return word != 0; });
  }
  all_take_part_.assign(scene_->bodyCount(), true);
  for (BodyId id = 0; id < scene_->bodyCount(); ++id) {
    if (!scene_->takesPart(id)) continue;
    for (const PartId part : scene_->body(id).listed_parts) {
      if (!takesPart(numberOf(id, part))) all_take_part_[id] = false;
    }
  }
}

void listRejectedParts(const Scene& scene, Motion motion, DetectionResult& result) {
  result.rejected_parts.clear();
  const bool any_parts = std::any_of(scene.bodies().begin(), scene.bodies().end(),
                                     [](const Body& body) { return !body.parts.empty(); });
  if (!any_parts || result.counters.rejected == 0) return;
  listRejectedParts(rejectedTriangles(scene, motion), result);
}

void listRejectedParts(const std::vector<RejectedTriangles>& rejected, DetectionResult& result) {
  result.rejected_parts.clear();
  for (BodyId id = 0; id < rejected.size(); ++id) {
    for (std::size_t part = 0; part < rejected[id].by_part.size(); ++part) {
      const std::uint64_t count = rejected[id].by_part[part];
      if (count > 0) result.rejected_parts.push_back({id, static_cast<PartId>(part), count});
    }
  }
}

}  // namespace deformable_contact_monitor
