// Python scripts that draw what the tools measured.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// Runs the script that lies beside this program, to its end. Without Python or a module that it
// needs there is nothing to look at, and nothing else is lost: then warn(why).
void runScriptBeside(const std::string& name, const std::vector<std::string>& arguments,
                     const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
