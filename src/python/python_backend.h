// What the Python classes Detector and StateChecker share: they use a backend of the core, from one
// thread at a time and without Python's global lock.
#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/common/forks.h"
#include "cuda/detector_choice.h"
#include "python/others_run.h"
#include "python/python_scene.h"

namespace deformable_contact_monitor {

// The names of a Python class in messages: of the class, of its objects, and of what they do.
struct PythonNames {
  std::string type, object, call;
};

// Owns a `Backend`: a Detector or a StateChecker. Callers must hold Python's global lock, which is
// released while the backend works. A call from another thread in that time throws
// std::runtime_error. So does a call in a process that was forked in that time.
template <class Backend>
class PythonBackend {
 public:
  PythonBackend(const PythonBackend&) = delete;
  PythonBackend& operator=(const PythonBackend&) = delete;

  // Makes the next call a cold start.
  void reset() {
    requireUnused();
    used_->reset();
  }

  // Returns the name of the backend that ran last.
  const std::string& backend() const { return backend_; }
  // Returns why CUDA is not used, or not for every scene, in one line. Empty: it is used, or was
  // not asked for.
  const std::string& backendProblem() const { return backend_problem_; }
  // Returns the text of repr().
  std::string describe() const { return "<" + names_.type + ": backend " + backend_ + ">"; }

 protected:
  // A backend that was asked for by name must work; "auto" tries CUDA again later. `make` makes it
  // from WithoutCuda and from what takes its BackendState.
  template <class Make>
  PythonBackend(PythonNames names, BackendChoice choice, const Make& make)
      : names_(std::move(names)),
        used_(make(choice == BackendChoice::kCuda ? WithoutCuda::kRefuse : WithoutCuda::kTryAgain,
                   [this](const BackendState& state) { state_ = state; })) {
    update();
  }
  ~PythonBackend() = default;

  // Throws std::runtime_error if another thread's call uses the backend, or did so when this
  // process was forked.
  void requireUnused() const {
    if (working_.isInherited()) {
      throw std::runtime_error("this process was forked while another thread was in the " +
                               names_.object + "'s " + names_.call + ": make another " +
                               names_.type);
    }
    if (working_.isSet()) {
      throw std::runtime_error("the " + names_.object + " is in use by another thread's " +
                               names_.call);
    }
  }

  // Returns copy(work(backend)). During both, the scene cannot change and the backend is in use;
  // during the work other Python threads run. The copy counts because Python may let other threads
  // run while it makes objects. Asks requireUnused() itself, because reading arguments may have let
  // other threads run.
  template <class Work, class Copy>
  auto run(PythonScene* scene, const Work& work, const Copy& copy) {
    const AtWork at_work;  // which may let other threads run, so the question comes after it
    requireUnused();
    const PythonScene::Looking looking(scene);
    // Ends with the global lock taken again, whatever the work throws.
    struct Working {
      PythonBackend* self;
      ~Working() {
        self->working_.clear();
        self->update();
      }
    } const working{this};
    working_.set();
    const auto& result = [&]() -> decltype(auto) {
      const pybind11::gil_scoped_release others_run;
      return work(used_.get());
    }();
    update();
    return copy(result);
  }

 private:
  // Copies backend and problem while nothing runs, so that Python may read them at any time.
  void update() {
    backend_ = used_->backend();
    backend_problem_ = state_.problem;
  }

  const PythonNames names_;
  BackendState state_;  // written while the backend works
  std::unique_ptr<Backend> used_;
  ProcessMark working_;
  std::string backend_, backend_problem_;
};

// Adds what they share to the Python class of a PythonBackend.
template <class Class>
void bindBackend(Class* bound, const char* reset_text) {
  using Self = typename Class::type;
  bound->def("reset", &Self::reset, reset_text)
      .def_property_readonly("backend", &Self::backend,
                             "What ran last, or will run first: 'cpu' or 'cuda'.")
      .def_property_readonly("backend_problem", &Self::backendProblem,
                             "Why 'auto' does not use CUDA, one line; empty: it does, or the CPU "
                             "was asked for.")
      .def("__repr__", &Self::describe);
}

}  // namespace deformable_contact_monitor
