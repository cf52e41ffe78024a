// How every tool of ours reads its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <stdexcept>
#include <string>

#include "core/options.h"

namespace deformable_contact_monitor {

// Bad usage: throws std::invalid_argument, one line.
[[noreturn]] inline void refuseUsage(const std::string& what) {
  throw std::invalid_argument(what + " (see --help)");
}

// Adds --adjacent.
inline void addAdjacent(CLI::App* app, AdjacentPairs* adjacent) {
  const auto set = [adjacent](const std::string& name) {
    *adjacent = name == "skip" ? AdjacentPairs::kSkip : AdjacentPairs::kBeyondShared;
  };
  app->add_option_function<std::string>(
         "--adjacent", set,
         "Triangles of one body that share a vertex: skip them, or report those that meet beyond "
         "what they share")
      ->check(CLI::IsMember({"skip", "beyond_shared"}))
      ->default_str(toString(*adjacent));
}

// False if --help or --version was asked for and is printed. Throws as refuseUsage() does.
inline bool parsed(CLI::App* app, int argc, char** argv) {
  try {
    app->parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    app->exit(asked);
    return false;
  } catch (const CLI::ParseError& error) {
    refuseUsage(error.what());
  }
  return true;
}

}  // namespace deformable_contact_monitor
