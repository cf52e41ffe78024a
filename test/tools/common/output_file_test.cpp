// A file has its name only once it is whole, and what was there before stays until then.
#include "tools/common/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

// As if the disk were full, until this goes.
class FullDisk {
 public:
  explicit FullDisk(rlim_t most_bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = most_bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

class OutputFileTest : public testing::Test {
 protected:
  OutputFileTest() {
    std::string pattern = (fs::temp_directory_path() / "output_file_XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~OutputFileTest() override { fs::remove_all(folder_); }

  std::string path(const std::string& name = "file") const { return folder_ / name; }

  static std::string textOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      names.push_back(entry.path().filename());
    }
    return names;
  }

  fs::path folder_;
};

TEST_F(OutputFileTest, IsWrittenAndNothingElseIsLeft) {
  OutputFile(path()).write("whole");
  EXPECT_EQ(textOf(path()), "whole");
  EXPECT_EQ(names(), std::vector<std::string>{"file"});
}

TEST_F(OutputFileTest, WhatIsNeverWrittenLeavesAllAsItWas) {
  { const OutputFile file(path()); }
  EXPECT_TRUE(names().empty());
  OutputFile(path()).write("earlier");
  OutputFile again(path());
  EXPECT_EQ(textOf(path()), "earlier");
  EXPECT_EQ(names().size(), 1U) << "a tool that is killed meanwhile leaves nothing behind";
  again.write("later");
  EXPECT_EQ(textOf(path()), "later");
}

TEST_F(OutputFileTest, AFailureLeavesNoHalfOfIt) {
  const std::string text(1 << 20, 'x');
  for (const bool there_before : {false, true}) {
    if (there_before) OutputFile(path()).write("earlier");
    {
      const FullDisk full(5000);
      EXPECT_THROW(OutputFile(path()).write(text), std::system_error);
    }
    EXPECT_EQ(names().size(), there_before ? 1U : 0U);
    EXPECT_EQ(textOf(path()), there_before ? "earlier" : "");
  }
}

TEST_F(OutputFileTest, AFolderThatIsNotThereIsNamed) {
  try {
    const OutputFile file(path("none/file"));
    ADD_FAILURE() << "not refused";
  } catch (const std::system_error& error) {
    EXPECT_EQ(error.code(), std::errc::no_such_file_or_directory);
    EXPECT_NE(std::string(error.what()).find("none/file: cannot be written"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find(".part"), std::string::npos);
  }
}

TEST_F(OutputFileTest, ALinkStaysALink) {
  OutputFile(path("target")).write("earlier");
  fs::create_symlink("target", path("link"));
  OutputFile(path("link")).write("later");
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(textOf(path("target")), "later");
}

TEST_F(OutputFileTest, WhatIsNoPlainFileIsWrittenTo) {
  ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
  const int reader = ::open(path("pipe").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  OutputFile(path("pipe")).write("whole");
  char text[6] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 5);
  EXPECT_STREQ(text, "whole");
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  EXPECT_EQ(names(), std::vector<std::string>{"pipe"});
}

TEST_F(OutputFileTest, APartHasItsNameFromTheEndOn) {
  for (const bool finished : {false, true}) {
    AtomicFile part(path());
    std::ofstream(part.writtenAs()) << "whole";
    EXPECT_FALSE(fs::exists(path()));
    EXPECT_EQ(names().size(), 1U);
    if (finished) part.finish();
  }
  EXPECT_EQ(textOf(path()), "whole");
  EXPECT_EQ(names(), std::vector<std::string>{"file"});
}

TEST_F(OutputFileTest, ASignalLeavesNoPart) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    const auto end = [&] {
      const AtomicFile finished(path("first"));
      AtomicFile part(path());
      TableFile table(path("table"));
      table.line("a");
      std::ofstream(part.writtenAs()) << "half";
      if (names().size() != 2) _exit(1);
      std::raise(signal);
    };
    EXPECT_EXIT(end(), testing::KilledBySignal(signal), "");
    EXPECT_EQ(names(), std::vector<std::string>{});
  }
}

TEST_F(OutputFileTest, ASignalThatIsHandledEndsNothing) {
  void (*const before)(int) = std::signal(SIGTERM, SIG_IGN);
  AtomicFile part(path());
  std::ofstream(part.writtenAs()) << "whole";
  std::raise(SIGTERM);
  EXPECT_EQ(names().size(), 1U);
  part.finish();
  std::signal(SIGTERM, before);
  EXPECT_EQ(textOf(path()), "whole");
}

}  // namespace
}  // namespace deformable_contact_monitor
