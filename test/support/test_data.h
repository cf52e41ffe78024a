// Finds the test data, and reads the settings of tests from the environment.
// DCM_REQUIRE_TEST_DATA() skips a test if there are no test data.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>

namespace deformable_contact_monitor {

// $DCM_TEST_DATA, or ../shared/data beside the source tree.
std::string testDataDir();

// Path of a file in it; throws std::runtime_error if the folder is there and the file is not.
std::string testDataFile(const std::string& relative_path);

bool testDataIsThere();

// Returns the number in an environment variable, or `otherwise` if it is not set.
std::uint32_t numberFromEnvironment(const char* name, std::uint32_t otherwise);

// Returns whether $DCM_REQUIRE_CUDA is set. If so, a test fails if no CUDA device can be used.
bool isCudaRequired();

}  // namespace deformable_contact_monitor

#define DCM_REQUIRE_TEST_DATA()                                                          \
  do {                                                                                   \
    if (!::deformable_contact_monitor::testDataIsThere()) {                              \
      GTEST_SKIP() << "no test data at " << ::deformable_contact_monitor::testDataDir(); \
    }                                                                                    \
  } while (false)
