// A folder of its own for a test's mesh files, and comparison of floats bit by bit.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/mesh_file.h"

namespace deformable_contact_monitor {

class MeshFileTest : public testing::Test {
 protected:
  MeshFileTest() {
    std::string pattern = (std::filesystem::temp_directory_path() / "mesh_file_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = pattern;
  }
  ~MeshFileTest() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string write(const std::string& name, const std::string& content) const {
    std::ofstream(path(name), std::ios::binary) << content;
    return path(name);
  }

  TriangleMesh read(const std::string& name, const std::string& content) const {
    return readMeshFile(write(name, content));
  }

  // Returns the reader's error message. Fails the test if the file is read without an error.
  static std::string errorOf(const std::string& file) {
    try {
      readMeshFile(file);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    ADD_FAILURE() << file << " was read";
    return {};
  }

 private:
  std::filesystem::path folder_;
};

// -0 differs from 0 here, and NaN equals NaN.
inline std::vector<std::uint32_t> bitsOf(const std::vector<float>& values) {
  std::vector<std::uint32_t> bits(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] == values[i]) {
      std::memcpy(&bits[i], &values[i], sizeof(float));
    } else {
      bits[i] = 0x7FC00000;
    }
  }
  return bits;
}

}  // namespace deformable_contact_monitor
