// The innermost loop of the sweep: which boxes of a range overlap a row's on the other two axes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/cpu/judge.h"
#include "core/rules/principal_axes.h"

namespace deformable_contact_monitor {

// The arrays may be read, and `hits` written, this much past the range.
constexpr std::uint32_t kScanChunk = 32;

// Writes {row, k} for each k in [begin, end) whose box overlaps `box`, ascending; returns how many.
std::size_t scanRow(std::uint32_t row, PackedBox box, const std::uint32_t* lo,
                    const std::uint32_t* hi, std::uint32_t begin, std::uint32_t end, Hit* hits);

}  // namespace deformable_contact_monitor
