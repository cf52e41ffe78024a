// Turns the URIs of mesh files into local paths. Only local files are supported: package:// is
// looked up by rospack, and file:// and absolute paths are used as they are. Other schemes, such as
// http://, are rejected.
#include <ros/package.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "robot/link_mesh_files.h"

namespace deformable_contact_monitor {
namespace {

const std::string kPackageScheme = "package://";
const std::string kFileScheme = "file://";

bool startsWith(const std::string& text, const std::string& start) {
  return text.compare(0, start.size(), start) == 0;
}

// Decodes codes such as %20; a '%' that begins no code is kept.
std::string percentDecoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_code = text[i] == '%' && i + 2 < text.size() &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 1])) != 0 &&
                         std::isxdigit(static_cast<unsigned char>(text[i + 2])) != 0;
    if (is_code) {
      decoded += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  if (decoded.find('\0') != std::string::npos) throw std::runtime_error("%00 in a file name");
  return decoded;
}

// Returns the folder of a ROS package. Throws if rospack does not know the package.
std::string packagePath(const std::string& package) {
  // getPath() prints to stderr for an unknown package and puts the name into a command line, so the
  // name is compared with the list of all packages first.
  std::vector<std::string> packages;
  ros::package::getAll(packages);
  if (std::find(packages.begin(), packages.end(), package) == packages.end()) {
    const char* search_path = std::getenv("ROS_PACKAGE_PATH");
    throw std::runtime_error("package '" + package + "' not found, ROS_PACKAGE_PATH is " +
                             (search_path == nullptr ? "not set" : search_path));
  }
  return ros::package::getPath(package);
}

// Returns the path of a URI, whether or not there is a file.
std::string toPath(const std::string& uri) {
  if (startsWith(uri, kPackageScheme)) {
    const std::size_t slash = std::min(uri.find('/', kPackageScheme.size()), uri.size());
    const std::string package = uri.substr(kPackageScheme.size(), slash - kPackageScheme.size());
    return packagePath(package) + percentDecoded(uri.substr(slash));
  }
  if (startsWith(uri, kFileScheme)) {
    std::string path = uri.substr(kFileScheme.size());
    // A file URI may name this machine as its host (RFC 8089).
    if (startsWith(path, "localhost/")) path.erase(0, std::string("localhost").size());
    if (!startsWith(path, "/")) throw std::runtime_error("file:// must be followed by /");
    return percentDecoded(path);
  }
  if (startsWith(uri, "/")) return uri;
  throw std::runtime_error("neither package://, file:// nor an absolute path");
}

}  // namespace

ResourceResolver makeRosResolver() {
  return [](const std::string& uri) {
    std::string path = toPath(uri);
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
      throw std::runtime_error("no such file: " + path);
    }
    return path;
  };
}

}  // namespace deformable_contact_monitor
