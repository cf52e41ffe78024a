// What is said of a backend that is not the one asked for.
#include "monitor/diagnostics/backend_status.h"

#include <diagnostic_msgs/DiagnosticStatus.h>
#include <gtest/gtest.h>

#include <string>

namespace deformable_contact_monitor {
namespace {

using diagnostic_msgs::DiagnosticStatus;

int levelOf(BackendChoice asked, BackendFault fault) {
  return backendStatus(asked, {"why", fault, false}).level;
}

std::string summaryOf(BackendFault fault, bool tried_again) {
  return backendStatus(BackendChoice::kAuto, {"out of memory", fault, tried_again}).summary;
}

TEST(BackendStatus, NothingIsSaidWhileAllIsWell) {
  for (const BackendChoice asked :
       {BackendChoice::kAuto, BackendChoice::kCuda, BackendChoice::kCpu}) {
    const BackendStatus status = backendStatus(asked, BackendState());
    EXPECT_EQ(status.level, DiagnosticStatus::OK);
    EXPECT_EQ(status.summary, "");
  }
}

TEST(BackendStatus, TheLevelGoesByTheCause) {
  const BackendChoice any = BackendChoice::kAuto, cuda = BackendChoice::kCuda;
  EXPECT_EQ(levelOf(any, BackendFault::kUnavailable), DiagnosticStatus::OK) << "it is a choice";
  EXPECT_EQ(levelOf(cuda, BackendFault::kUnavailable), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kTransient), DiagnosticStatus::WARN);
  EXPECT_EQ(levelOf(cuda, BackendFault::kTransient), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kSticky), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(cuda, BackendFault::kSticky), DiagnosticStatus::ERROR);
  EXPECT_EQ(levelOf(any, BackendFault::kSceneTooLarge), DiagnosticStatus::WARN);
  EXPECT_EQ(levelOf(cuda, BackendFault::kSceneTooLarge), DiagnosticStatus::WARN);
}

TEST(BackendStatus, ADeviceOfSeveralIsAWarning) {
  BackendState state{"CUDA device 1: out of memory", BackendFault::kSticky, false};
  state.partly = true;
  const BackendStatus status = backendStatus(BackendChoice::kCuda, state);
  EXPECT_EQ(status.level, DiagnosticStatus::WARN);
  EXPECT_EQ(status.summary,
            "contacts are found without one of the CUDA devices, until this process starts again: "
            "CUDA device 1: out of memory");
}

TEST(BackendStatus, TheSummarySaysWhyAndWhatHelps) {
  const std::string why = "contacts are found on the CPU, for CUDA cannot be used: out of memory";
  EXPECT_EQ(summaryOf(BackendFault::kTransient, true),
            why + "; CUDA is tried again, at least once a minute");
  EXPECT_EQ(summaryOf(BackendFault::kSticky, false),
            why + "; CUDA needs a restart of this process");
  EXPECT_EQ(summaryOf(BackendFault::kSceneTooLarge, true), why + "; smaller scenes run on CUDA");
  EXPECT_EQ(summaryOf(BackendFault::kUnavailable, false), why);
}

}  // namespace
}  // namespace deformable_contact_monitor
