// Finds the test data in the file system and reads the environment variables of the tests.
#include "test_data.h"

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

namespace deformable_contact_monitor {

std::string testDataDir() {
  const char* dir = std::getenv("DCM_TEST_DATA");
  return dir != nullptr && *dir != '\0' ? dir : DCM_TEST_DATA_DIR;
}

bool testDataIsThere() { return std::filesystem::is_directory(testDataDir()); }

std::string testDataFile(const std::string& relative_path) {
  const std::filesystem::path path = std::filesystem::path(testDataDir()) / relative_path;
  if (!std::filesystem::exists(path)) {
    throw std::runtime_error(path.string() + ": not there, though the test data are");
  }
  return path.string();
}

std::uint32_t numberFromEnvironment(const char* name, std::uint32_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

bool isCudaRequired() { return std::getenv("DCM_REQUIRE_CUDA") != nullptr; }

}  // namespace deformable_contact_monitor
