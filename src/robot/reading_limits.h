// What reading one foreign mesh file may cost. The largest meshes of the robots we know, 130 000
// triangles together, take 0.1 s and 100 MiB.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace deformable_contact_monitor {

// A robot should be there, or known not to be, before people give up on it; a slow disk and a
// loaded machine still read a million triangles in that time.
constexpr std::chrono::milliseconds kMaxFileTime{20'000};

// Of all files of a robot together, so that fifty bad ones keep nobody waiting for fifty times
// that.
constexpr std::chrono::milliseconds kMaxRobotTime{60'000};

// Of the processor. What is stopped by nothing else, not even by the end of the node, ends by this.
constexpr unsigned kMaxCpuS = 20;

// Of the reader's address space: some ten times what a link of a million triangles takes, and four
// readers at once still fit a small computer of a robot.
constexpr std::size_t kMaxMemoryMib = 2048;

// Of the file. It is read whole.
constexpr std::size_t kMaxFileMib = 512;

// Of vertices and triangles, in the bytes that they take here: 3 million triangles of an STL.
constexpr std::size_t kMaxMeshMib = 256;

// Of all meshes of a robot together, while they are read. A few bytes may ask for many triangles.
constexpr std::size_t kMaxRobotMib = 1024;

// Of the reason why a file is refused. It is for people.
constexpr std::size_t kMaxRefusalBytes = 4096;

// Readers at once, however many cores there are: their memory adds up.
constexpr unsigned kMaxReaders = 4;

constexpr std::size_t kBytesPerMib = std::size_t{1} << 20;

}  // namespace deformable_contact_monitor
