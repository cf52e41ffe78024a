// A foreign file, whole.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Throws std::runtime_error, without the file's name, if it is no regular file, is larger than
// kMaxFileMib or cannot be read. A FIFO or a device is not opened, so that nothing waits for it.
std::string readRegularFile(const std::string& path);

}  // namespace deformable_contact_monitor
