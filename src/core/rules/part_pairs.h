// Which pairs of parts are enabled, as a matrix of bits that host and device read alike.
//
// The parts of all bodies that take part are numbered consecutively (common/part_table.h); a body
// without named parts is one part.
#pragma once

#include <cstdint>

#include "core/host_device.h"

namespace deformable_contact_monitor {

// A view of the matrix. Two triangles are compared only if the pair of their parts is enabled.
struct PartPairs {
  const std::uint32_t* bits;  // a row for each part, of row_words words
  std::uint32_t row_words;

  DCM_HD static std::uint32_t wordsFor(std::uint32_t parts) { return (parts + 31) / 32; }

  DCM_HD bool enabled(std::uint32_t a, std::uint32_t b) const {
    return (bits[a * row_words + b / 32] >> (b % 32) & 1) != 0;
  }
};

}  // namespace deformable_contact_monitor
