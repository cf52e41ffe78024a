// Robot descriptions that are mostly well-formed, made of an input's bytes.
#pragma once

#include <string>

#include "byte_source.h"

namespace deformable_contact_monitor {

std::string urdfFrom(ByteSource* source);

}  // namespace deformable_contact_monitor
