// Declares what the tests of robot geometry have in common.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "robot/robot_geometry.h"
#include "robot/source_mesh.h"

namespace deformable_contact_monitor {

using Corners = std::array<Eigen::Vector3d, 3>;

std::vector<Corners> cornersOf(const SourceMesh& mesh);
std::vector<Corners> cornersOf(const TriangleMesh& mesh);

// The same triangles as a multiset: any order, any corner first, either winding, each coordinate
// within tolerance_m.
::testing::AssertionResult sameTriangles(const std::vector<Corners>& expected,
                                         const std::vector<Corners>& actual, double tolerance_m);

// Every edge belongs to two triangles, once in each direction.
::testing::AssertionResult isClosed(const TriangleMesh& mesh);

// Return the volume and the area of a surface. The volume is that of a closed surface; it is
// negative if the surface is wound inside out.
double signedVolume(const std::vector<Corners>& triangles);
double surfaceArea(const std::vector<Corners>& triangles);

struct Bounds {
  Eigen::Vector3d low, high;
};
Bounds boundsOf(const TriangleMesh& mesh);

// The bytes of an STL file; nine coordinates a triangle.
std::string binaryStl(const std::string& header, const std::vector<float>& corners);

std::string readText(const std::string& path);

// A folder that goes with the test.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();

  // Writes a file, making folders on the way; returns its path.
  std::string write(const std::string& name, const std::string& content) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// A resolver for the packages of the test data, without ROS.
ResourceResolver testDataResolver();

// A robot of one link "l" with these collision elements.
std::string oneLinkUrdf(const std::string& link_content);

}  // namespace deformable_contact_monitor
