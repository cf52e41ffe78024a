// Reads a whole file that is not trusted.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// Returns the bytes of a regular file. Throws std::runtime_error, without the file's name, if it is
// no regular file, is larger than kMaxFileMib or cannot be read. A FIFO or a device is not opened,
// so that the call does not wait for it.
std::string readRegularFile(const std::string& path);

}  // namespace deformable_contact_monitor
