// The parameter `type` of an object, and what each type needs beside a topic.
#pragma once

#include <string>
#include <vector>

#include "monitor/rules/parameter_reader.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// Reads the key `type` of an object and the keys of that type. Files are read at once, so that a
// bad one is a problem at start and not with the first message. Adds unknown keys of maps to
// `warnings`.
void readObjectType(ParameterReader* entry, std::vector<std::string>* warnings,
                    ObjectParameters* object);

// Returns whether the object's type is `rigid`, which readRigid() reads (rigid_parameters.h).
bool isRigid(ParameterReader* entry);

}  // namespace deformable_contact_monitor
