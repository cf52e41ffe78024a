// The parts of all bodies of a scene that take part, numbered consecutively, and which pairs of
// them are enabled. All backends ask it, so that they leave out the same pairs of triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/common/scene_queries.h"
#include "core/detector.h"
#include "core/export.h"
#include "core/rules/part_pairs.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// Valid until bodies, parts or enabled pairs of the scene change. Parts are numbered by (body,
// part); only those that triangles have are numbered, and all of a body without named parts is one
// part. Any number of threads may ask it.
class DCM_EXPORT PartTable {
 public:
  explicit PartTable(const Scene& scene);

  // Returns the number of a part that the body has. The body must take part.
  std::uint32_t numberOf(BodyId body, PartId part) const { return numbers_[body][part]; }
  // Returns the number of a triangle's part.
  std::uint32_t of(BodyId body, std::size_t triangle) const {
    const std::vector<PartId>& parts = scene_->body(body).parts;
    return numberOf(body, parts.empty() ? PartId{0} : parts[triangle]);
  }
  // Returns whether two triangles are compared, as far as their parts decide.
  bool enabled(BodyId a, std::size_t triangle_a, BodyId b, std::size_t triangle_b) const {
    return pairs().enabled(of(a, triangle_a), of(b, triangle_b));
  }
  PartPairs pairs() const { return {bits_.data(), row_words_}; }
  const std::vector<std::uint32_t>& bits() const { return bits_; }

  std::uint32_t count() const { return static_cast<std::uint32_t>(takes_part_.size()); }
  // Returns whether a part, given by its number, is in some enabled pair. Triangles of other parts
  // are left out.
  bool takesPart(std::uint32_t number) const { return takes_part_[number]; }
  // Returns whether all parts of a body are in some enabled pair.
  bool allTakePart(BodyId body) const { return all_take_part_[body]; }

 private:
  void numberParts();
  void enablePairs();
  void findIdleParts();

  const Scene* scene_;
  std::vector<std::vector<std::uint32_t>> numbers_;  // per body, for its parts from 0 on
  std::uint32_t row_words_ = 0;
  std::vector<std::uint32_t> bits_;  // see PartPairs
  std::vector<bool> takes_part_;     // per number
  std::vector<bool> all_take_part_;  // per body
};

// Fills result.rejected_parts. Reads every vertex of bodies with parts, if any triangle was
// rejected; the vertices must be on the host.
DCM_EXPORT void listRejectedParts(const Scene& scene, Motion motion, DetectionResult& result);
// Does the same with what rejectedTriangles() has counted.
void listRejectedParts(const std::vector<RejectedTriangles>& rejected, DetectionResult& result);

}  // namespace deformable_contact_monitor
