#include "core/backend_choice.h"

#include <stdexcept>

namespace deformable_contact_monitor {

const char* toString(BackendChoice choice) {
  constexpr const char* kNames[] = {"auto", "cuda", "cpu"};
  return kNames[static_cast<std::size_t>(choice)];
}

BackendChoice toBackendChoice(const std::string& name) {
  for (const BackendChoice choice :
       {BackendChoice::kAuto, BackendChoice::kCuda, BackendChoice::kCpu}) {
    if (name == toString(choice)) return choice;
  }
  throw std::invalid_argument("backend '" + name + "' is none of auto, cuda, cpu");
}

}  // namespace deformable_contact_monitor
