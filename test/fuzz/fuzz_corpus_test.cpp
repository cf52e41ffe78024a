// Replays each target's corpus, then simple mutations of it: what was found once stays mended, and
// targets stay alive. libFuzzer's runs, which find, are test/fuzz/run's.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <random>

#include "core/common/stopwatch.h"
#include "fuzz_target.h"

namespace deformable_contact_monitor {

void PrintTo(const FuzzTarget& target, std::ostream* out) { *out << target.name; }

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr double kMostMs = 3000;  // of a target's mutations

int mutationCount() {
  const char* const wanted = std::getenv("DCM_FUZZ_MUTATIONS");
  return wanted == nullptr ? 300 : std::atoi(wanted);
}

std::vector<Bytes> corpusOf(const std::string& target) {
  std::vector<std::filesystem::path> files;
  const std::filesystem::path folder = std::filesystem::path(DCM_FUZZ_CORPUS) / target;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());  // a run is like any other
  std::vector<Bytes> corpus;
  for (const std::filesystem::path& path : files) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  return corpus;
}

class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}

  // One to three of: a bit flipped, a byte set, a cut, a stretch repeated.
  Bytes mutated(Bytes bytes) {
    for (std::size_t left = 1 + below(3); left > 0 && !bytes.empty(); --left) {
      const std::size_t at = below(bytes.size());
      const std::size_t end = at + below(std::min<std::size_t>(bytes.size() - at, 64)) + 1;
      switch (below(4)) {
        case 0:
          bytes[at] ^= static_cast<std::uint8_t>(1U << below(8));
          break;
        case 1:
          bytes[at] = static_cast<std::uint8_t>(below(256));
          break;
        case 2:
          bytes.erase(bytes.begin() + at, bytes.begin() + end);
          break;
        default: {
          const Bytes stretch(bytes.begin() + at, bytes.begin() + end);
          bytes.insert(bytes.begin() + at, stretch.begin(), stretch.end());
        }
      }
    }
    return bytes;
  }

  std::size_t below(std::size_t count) { return random_() % count; }

 private:
  std::mt19937 random_;
};

class FuzzCorpus : public ::testing::TestWithParam<FuzzTarget> {};

// Harm would end the program.
TEST_P(FuzzCorpus, AndItsMutationsDoNoHarm) {
  const FuzzTarget& target = GetParam();
  const std::vector<Bytes> corpus = corpusOf(target.name);
  ASSERT_FALSE(corpus.empty());
  int passed_whole = 0;
  for (const Bytes& input : corpus) passed_whole += target.try_input(input.data(), input.size());
  EXPECT_GT(passed_whole, 0) << "no seed gets past the first check";
  Mutator mutator(1);
  int passed = 0;
  const Stopwatch stopwatch;
  for (int i = 0; i < mutationCount(); ++i) {
    if (passed > 0 && stopwatch.elapsedMs() > kMostMs) break;  // some start processes
    const Bytes input = mutator.mutated(corpus[mutator.below(corpus.size())]);
    passed += target.try_input(input.data(), input.size());
  }
  EXPECT_GT(passed, 0) << "no mutation gets past the first check";
  RecordProperty("passed", passed);
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzCorpus, ::testing::ValuesIn(fuzzTargets()),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace deformable_contact_monitor
