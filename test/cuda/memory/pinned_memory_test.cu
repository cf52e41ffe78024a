// Page-locked memory: in pieces of the reserve and beyond it.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <random>
#include <vector>

#include "cuda/device/stream.cuh"
#include "cuda/memory/pinned_memory.cuh"
#include "cuda/memory/pinned_pages.cuh"
#include "device_test.h"

namespace deformable_contact_monitor {
namespace {

__global__ void fill(std::uint32_t* words, std::size_t count, std::uint32_t value) {
  const std::size_t stride = std::size_t{gridDim.x} * blockDim.x;
  for (std::size_t i = blockIdx.x * blockDim.x + threadIdx.x; i < count; i += stride) {
    words[i] = value;
  }
}

struct Piece {
  std::uint32_t* words;
  std::size_t count;
  std::uint32_t value;

  std::size_t bytes() const { return count * sizeof(std::uint32_t); }
  bool isIntact() const {
    return std::all_of(words, words + count, [this](std::uint32_t word) { return word == value; });
  }
};

class PinnedMemoryTest : public DeviceTest {
 protected:
  // Written by the device, at the host's address.
  Piece take(std::size_t bytes, std::uint32_t value) {
    Piece piece{static_cast<std::uint32_t*>(pinnedMemory().allocate(bytes)),
                bytes / sizeof(std::uint32_t), value};
    EXPECT_EQ(reachedAt(piece.words), piece.words);
    EXPECT_EQ(reachedAt(piece.words + piece.count - 1), piece.words + piece.count - 1);
    CudaStream stream;
    fill<<<64, 256, 0, stream.get()>>>(piece.words, piece.count, value);
    stream.synchronise();
    return piece;
  }
  static void giveBack(const Piece& piece) {
    pinnedMemory().deallocate(piece.words, piece.bytes());
  }
};

// Up to 60 MiB at a time, of a reserve of 16.
TEST_F(PinnedMemoryTest, EachPieceKeepsWhatTheDeviceWroteThere) {
  if (!hasDevice()) return;
  std::mt19937 random(5);
  std::vector<Piece> pieces;
  for (std::uint32_t value = 1; value <= 150; ++value) {
    const std::size_t most = value % 3 == 0 ? std::size_t{6} << 20 : 5000;
    pieces.push_back(take(4 + 4 * (random() % (most / 4)), value));
    if (pieces.size() < 20) continue;
    std::swap(pieces[random() % pieces.size()], pieces.back());
    EXPECT_TRUE(pieces.back().isIntact()) << pieces.back().value;
    giveBack(pieces.back());
    pieces.pop_back();
  }
  for (const Piece& piece : pieces) {
    EXPECT_TRUE(piece.isIntact()) << piece.value;
    giveBack(piece);
  }
}

TEST_F(PinnedMemoryTest, MoreThanThereIsIsRefused) {
  if (!hasDevice()) return;
  const std::size_t too_many = std::size_t{1} << 50;
  EXPECT_THROW(take(too_many, 7), CudaError);
  giveBack(take(1 << 20, 7));
}

TEST_F(PinnedMemoryTest, AForkedProcessDoesNotShareThePages) {
  if (!hasDevice()) return;
  const PinnedPages pages(1);
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    const bool has_it = write(ends[1], pages.data(), 1) == 1;
    _exit(has_it || errno != EFAULT ? 1 : 0);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(write(ends[1], pages.data(), 1), 1) << "its own process does";
  close(ends[0]);
  close(ends[1]);
}

}  // namespace
}  // namespace deformable_contact_monitor
