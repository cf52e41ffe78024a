// Parses XML texts of robots: URDF, SRDF and COLLADA.
#pragma once

#include <tinyxml2.h>

#include <optional>
#include <string>

namespace deformable_contact_monitor {

// Why a text could not be parsed.
struct XmlError {
  int line = 1;
  std::string what;
};

// Parses the text. Returns nothing, or the error, which says so if the text looks like something
// else: a Git LFS pointer, an HTML page, UTF-16. Comments ahead of the XML declaration are allowed,
// as robot_state_publisher's parser and others allow them, although XML does not. Line numbers are
// those of the text.
std::optional<XmlError> parseXml(const std::string& text, tinyxml2::XMLDocument* document);

}  // namespace deformable_contact_monitor
