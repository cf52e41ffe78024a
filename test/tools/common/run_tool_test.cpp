// Tests the exit codes and the error messages of tools.
#include "tools/common/run_tool.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace deformable_contact_monitor {
namespace {

TEST(RunTool, ReturnsTheExitCode) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(runTool("tool", [] { return 0; }), 0);
  EXPECT_EQ(runTool("tool", [] { return 1; }), 1);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(RunTool, AnErrorIsOneLineAndExitCodeTwo) {
  testing::internal::CaptureStderr();
  const int code =
      runTool("tool", []() -> int { throw std::runtime_error("a\nb\x1b[31m.obj: no mesh"); });
  EXPECT_EQ(code, 2);
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "tool: a?b?[31m.obj: no mesh\n");
}

}  // namespace
}  // namespace deformable_contact_monitor
