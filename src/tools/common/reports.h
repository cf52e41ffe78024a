// Helpers for the reports of all tools: text for JSON and CSV, the machine, and plots.
//
// The functions do not print anything. Callers decide where their text goes.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace deformable_contact_monitor {

// Returns the text as a field of comma-separated values, quoted where RFC 4180 asks for it.
std::string csvField(const std::string& text);

// Returns fields as a row of comma-separated values, without a line end. A field is a text or an
// integer.
template <class... Fields>
std::string csvRow(const Fields&... fields) {
  std::string row;
  const auto add = [&row](const auto& field) {
    if constexpr (std::is_integral_v<std::decay_t<decltype(field)>>) {
      row += "," + std::to_string(field);
    } else {
      row += "," + csvField(field);
    }
  };
  (add(fields), ...);
  return row.substr(1);
}

// Returns indented JSON with keys in alphabetical order and a line end. File names and names in a
// bag need not be UTF-8, but JSON must be: invalid bytes become U+FFFD.
std::string jsonText(const nlohmann::json& json);

// The machine that something was measured on, as Linux describes it. Unknown entries are empty.
struct Machine {
  std::string system;  // for example "Debian GNU/Linux 12 (bookworm)"
  std::string cpu;     // model name
  unsigned cores = 0;  // logical cores
  std::string gpu_driver;
  std::vector<std::string> gpus;
};

// Describes the machine that this process runs on.
Machine thisMachine();

// Returns thisMachine() and the compiler as JSON.
nlohmann::json machineJson();

// Runs a Python script that lies beside this program, and waits for its end. The scripts draw plots
// of what was measured, so a failure (no Python, a missing module) only calls warn(why).
void runPlotScript(const std::string& name, const std::vector<std::string>& arguments,
                   const std::function<void(const std::string&)>& warn);

}  // namespace deformable_contact_monitor
