// Where the program read_link_mesh is.
#include "robot/reader_program.h"

#include <dlfcn.h>
#include <link.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

constexpr char kProgram[] = "read_link_mesh";
constexpr char kPackage[] = "deformable_contact_monitor";

// Of the program or shared library that this function is in, without symbolic links; empty if it
// cannot be told.
fs::path thisFolder() {
  std::error_code error;
  Dl_info info;
  link_map* object = nullptr;
  const int found = dladdr1(reinterpret_cast<const void*>(&thisFolder), &info,
                            reinterpret_cast<void**>(&object), RTLD_DL_LINKMAP);
  const bool is_library = found != 0 && object != nullptr && *object->l_name != '\0';
  const fs::path file = is_library ? object->l_name : "/proc/self/exe";
  return fs::canonical(file, error).parent_path();
}

std::vector<fs::path> places() {
  std::vector<fs::path> folders;
  const fs::path here = thisFolder();
  if (!here.empty()) folders = {here, here / kPackage};
  const char* workspaces = std::getenv("CMAKE_PREFIX_PATH");
  std::istringstream list(workspaces == nullptr ? "" : workspaces);
  for (std::string workspace; std::getline(list, workspace, ':');) {
    if (!workspace.empty()) folders.push_back(fs::path(workspace) / "lib" / kPackage);
  }
  return folders;
}

}  // namespace

std::string findReaderProgram() {
  std::string looked;
  for (const fs::path& folder : places()) {
    const fs::path program = folder / kProgram;
    std::error_code error;
    if (fs::is_regular_file(program, error) && access(program.c_str(), X_OK) == 0) return program;
    looked += (looked.empty() ? "" : ", ") + folder.string();
  }
  throw std::runtime_error(std::string("the program ") + kProgram +
                           ", which reads mesh files, is missing; it was looked for in " + looked);
}

}  // namespace deformable_contact_monitor
