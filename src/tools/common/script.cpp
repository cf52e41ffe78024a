// Python scripts that draw what the tools measured.
#include "tools/common/script.h"

#include <boost/process.hpp>
#include <filesystem>
#include <system_error>

namespace deformable_contact_monitor {

void runScriptBeside(const std::string& name, const std::vector<std::string>& arguments,
                     const std::function<void(const std::string&)>& warn) {
  namespace bp = boost::process;
  const std::string script =
      (std::filesystem::read_symlink("/proc/self/exe").parent_path() / name).string();
  std::error_code error;
  const int code = bp::system(bp::exe = script, bp::args = arguments, error);
  if (error) {
    warn("no plots: " + script + ": " + error.message());
  } else if (code != 0) {
    warn("no plots; the line above says why");
  }
}

}  // namespace deformable_contact_monitor
