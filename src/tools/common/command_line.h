// How every tool of ours reads its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>

namespace deformable_contact_monitor {

// False if --help or --version was asked for and is printed. Throws std::invalid_argument, one
// line, on bad usage.
inline bool parsed(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    app->exit(asked);
    return false;
  } catch (const CLI::ParseError& error) {
    throw std::invalid_argument(std::string(error.what()) + " (see --help)");
  }
  return true;
}

}  // namespace deformable_contact_monitor
