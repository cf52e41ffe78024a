// Mesh files that are mostly well-formed, made of an input's bytes: what bytes alone seldom are.
#pragma once

#include <string>

#include "byte_source.h"

namespace deformable_contact_monitor {

// Now and then a number, a count or an index in it is none that belongs there.
std::string objFrom(ByteSource* source);
std::string offFrom(ByteSource* source);
std::string plyFrom(ByteSource* source);  // ascii or binary, of any types
std::string stlFrom(ByteSource* source);  // ascii or binary
std::string daeFrom(ByteSource* source);

}  // namespace deformable_contact_monitor
