// Limits of time and memory for reading the mesh files of a robot. For comparison: the largest
// meshes of the robots in our tests, 130 000 triangles together, take 0.1 s and 100 MiB.
#pragma once

#include <chrono>
#include <cstddef>

namespace deformable_contact_monitor {

// Wall time for one file. A slow disk and a loaded machine read a million triangles in that time.
constexpr std::chrono::milliseconds kMaxFileTime{20'000};

// Wall time for all files of a robot together, so that fifty bad files do not take fifty times as
// long as one.
constexpr std::chrono::milliseconds kMaxRobotTime{60'000};

// Processor time for one file [s]. It ends a reader that outlives the node.
constexpr unsigned kMaxCpuS = 20;

// Address space of one reader [MiB]: some ten times what a link of a million triangles takes, and
// four readers at once still fit into the memory of a robot's small computer.
constexpr std::size_t kMaxMemoryMib = 2048;

// Size of one file [MiB], which is read whole.
constexpr std::size_t kMaxFileMib = 512;

// Size of one file's vertices and triangles in memory [MiB]: 3 million triangles of an STL.
constexpr std::size_t kMaxMeshMib = 256;

// Size of all meshes of a robot together while they are read [MiB]. A small COLLADA file may ask
// for very many triangles.
constexpr std::size_t kMaxRobotMib = 1024;

// Length of the message that says why a file was rejected, or what is unusual about it.
constexpr std::size_t kMaxRefusalBytes = 4096;

// Most readers at once, however many cores there are, because their memory adds up.
constexpr unsigned kMaxReaders = 4;

constexpr std::size_t kBytesPerMib = std::size_t{1} << 20;

}  // namespace deformable_contact_monitor
