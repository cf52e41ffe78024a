// Pieces of a surface that hang together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/bounds/halving.h"
#include "core/common/cycle_limit.h"

namespace deformable_contact_monitor {

struct SurfacePieces {
  std::vector<std::uint32_t> triangle;  // piece by piece
  std::vector<std::uint32_t> begin;     // of each piece; one more

  std::size_t count() const { return begin.size() - 1; }
};

// Each triangle in one of them. Each is grown over edges (edgeNeighbours()) from one triangle up to
// `most`, compact rather than long. Takes n log(most) steps. `triangles`: all, in order. Where the
// limit is over, not all of them are in one.
SurfacePieces surfacePieces(const CycleLimit& limit, const std::vector<PlacedTriangle>& triangles,
                            const std::vector<std::uint32_t>& neighbours, std::size_t most);

}  // namespace deformable_contact_monitor
