// Implements the functions that the tests of robot geometry have in common.
#include "robot_test_support.h"

#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

Eigen::Vector3d centroid(const Corners& t) { return (t[0] + t[1] + t[2]) / 3; }

bool near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance_m) {
  return (a - b).cwiseAbs().maxCoeff() <= tolerance_m;
}

bool near(const Corners& a, const Corners& b, double tolerance_m) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (const auto& order : kOrders) {
    bool all = true;
    for (int i = 0; i < 3; ++i) all = all && near(a[i], b[order[i]], tolerance_m);
    if (all) return true;
  }
  return false;
}

using Cell = std::tuple<long, long, long>;

}  // namespace

std::vector<Corners> cornersOf(const SourceMesh& mesh) {
  std::vector<Corners> corners;
  for (const auto& [a, b, c] : mesh.triangles) {
    corners.push_back({mesh.vertices.at(a), mesh.vertices.at(b), mesh.vertices.at(c)});
  }
  return corners;
}

std::vector<Corners> cornersOf(const TriangleMesh& mesh) {
  std::vector<Corners> corners;
  const auto vertex = [&](std::size_t i) {
    const std::size_t first = 3 * std::size_t{mesh.triangles[i]};
    return Eigen::Vector3d(mesh.vertices.at(first), mesh.vertices.at(first + 1),
                           mesh.vertices.at(first + 2));
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    corners.push_back({vertex(i), vertex(i + 1), vertex(i + 2)});
  }
  return corners;
}

::testing::AssertionResult sameTriangles(const std::vector<Corners>& expected,
                                         const std::vector<Corners>& actual, double tolerance_m) {
  if (expected.size() != actual.size()) {
    return ::testing::AssertionFailure()
           << actual.size() << " triangles instead of " << expected.size();
  }
  const auto cell = [&](const Eigen::Vector3d& p, int dx, int dy, int dz) {
    const Eigen::Vector3d scaled = p / (4 * tolerance_m);
    return Cell(std::lround(std::floor(scaled.x())) + dx, std::lround(std::floor(scaled.y())) + dy,
                std::lround(std::floor(scaled.z())) + dz);
  };
  std::multimap<Cell, std::size_t> grid;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    grid.emplace(cell(centroid(expected[i]), 0, 0, 0), i);
  }
  const auto take = [&](const Corners& triangle) {
    for (int n = 0; n < 27; ++n) {
      const auto [first, last] =
          grid.equal_range(cell(centroid(triangle), n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
      for (auto it = first; it != last; ++it) {
        if (!near(expected[it->second], triangle, tolerance_m)) continue;
        grid.erase(it);
        return true;
      }
    }
    return false;
  };
  for (std::size_t i = 0; i < actual.size(); ++i) {
    if (take(actual[i])) continue;
    return ::testing::AssertionFailure()
           << "triangle " << i << " (" << actual[i][0].transpose() << "), ("
           << actual[i][1].transpose() << "), (" << actual[i][2].transpose()
           << ") is not among the expected ones";
  }
  return ::testing::AssertionSuccess();
}

::testing::AssertionResult isClosed(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      ++directed[{mesh.triangles[i + k], mesh.triangles[i + (k + 1) % 3]}];
    }
  }
  for (const auto& [edge, count] : directed) {
    const auto opposite = directed.find({edge.second, edge.first});
    if (count != 1 || opposite == directed.end()) {
      return ::testing::AssertionFailure() << "edge " << edge.first << "-" << edge.second
                                           << " is open, or there " << count << " times";
    }
  }
  return ::testing::AssertionSuccess();
}

double signedVolume(const std::vector<Corners>& triangles) {
  double volume = 0;
  for (const Corners& t : triangles) volume += t[0].dot(t[1].cross(t[2])) / 6;
  return volume;
}

double surfaceArea(const std::vector<Corners>& triangles) {
  double area = 0;
  for (const Corners& t : triangles) area += (t[1] - t[0]).cross(t[2] - t[0]).norm() / 2;
  return area;
}

Bounds boundsOf(const TriangleMesh& mesh) {
  const Eigen::Map<const Eigen::Matrix3Xf> points(mesh.vertices.data(), 3,
                                                  static_cast<long>(mesh.vertexCount()));
  return {points.rowwise().minCoeff().cast<double>(), points.rowwise().maxCoeff().cast<double>()};
}

std::string readText(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be opened");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TemporaryFolder::TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "robot_test_XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error(name + ": cannot be made");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

std::string TemporaryFolder::write(const std::string& name, const std::string& content) const {
  const std::filesystem::path path = path_ / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
  return path.string();
}

std::string binaryStl(const std::string& header, const std::vector<float>& corners) {
  std::string text = header;
  text.resize(80, ' ');
  const auto append = [&](const void* data, std::size_t size) {
    text.append(static_cast<const char*>(data), size);
  };
  const auto count = static_cast<std::uint32_t>(corners.size() / 9);
  append(&count, 4);
  for (std::size_t i = 0; i < corners.size(); i += 9) {
    const float normal[3] = {0, 0, 0};
    append(normal, 12);
    append(&corners[i], 36);
    text.append(2, '\0');
  }
  return text;
}

ResourceResolver testDataResolver() {
  return [](const std::string& uri) {
    const std::string scheme = "package://";
    const std::size_t slash = uri.find('/', scheme.size());
    std::string package = uri.substr(scheme.size(), slash - scheme.size());
    if (package == "moveit_resources_panda_description") package = "panda_description";
    return testDataFile("robots/" + package + uri.substr(slash));
  };
}

std::string oneLinkUrdf(const std::string& link_content) {
  return "<robot name=\"r\"><link name=\"l\">" + link_content + "</link></robot>";
}

}  // namespace deformable_contact_monitor
