// What rosbag does not ask about a bag's index.
#pragma once

#include <string>

namespace deformable_contact_monitor {

// A bag says twice how many messages, chunks and connections there are: in numbers, and by what is
// there. rosbag's library believes the numbers, so that a damaged one would silently cost messages.
// Reads the records' headers alone. Throws std::runtime_error, one line, if the two differ or a
// record does not end where it should.
void checkBagIndex(const std::string& path);

}  // namespace deformable_contact_monitor
