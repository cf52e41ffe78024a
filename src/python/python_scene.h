// The class Scene of the Python module.
//
// The class follows the C++ Scene. Arguments are checked before anything changes, so a failed call
// leaves the scene as it was.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/common/forks.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// A scene that cannot change while a detector in another thread uses it: changes throw
// std::runtime_error then. Ids are checked, and errors name a wrong one. Callers must hold Python's
// global lock.
class PythonScene {
 public:
  // Adds a body and returns its id. Ids count up from 0. Arrays are as in array_arguments.h. Throws
  // std::invalid_argument if a body has that name already.
  BodyId addBody(const std::string& name, pybind11::handle vertices, pybind11::handle triangles);
  // Replaces vertices [m] and triangles.
  void setMesh(std::int64_t id, pybind11::handle vertices, pybind11::handle triangles);
  // Replaces the vertices [m]. Their number must stay the same.
  void setVertices(std::int64_t id, pybind11::handle vertices);
  // Replaces the vertices by an array in device memory, which is read but not copied (see
  // array_arguments.h). Keeps the array alive until the body gets other vertices.
  void setDeviceVertices(std::int64_t id, pybind11::object vertices,
                         std::optional<std::uintptr_t> stream);
  // Sets the pose: p_scene = rotation p_body + translation [m].
  void setPose(std::int64_t id, pybind11::handle rotation, pybind11::handle translation);
  // Sets margins of named parts [m], by the numbers of the parts.
  void setPartMargins(std::int64_t id, const std::map<std::int64_t, float>& margins_m);
  // Sets where the body was at the beginning of the interval: vertices [m] in the body's frame, and
  // the pose. None means the body's present value. Rotation and translation must be given together.
  void setEarlier(std::int64_t id, pybind11::handle vertices, pybind11::handle rotation,
                  pybind11::handle translation);
  // Calls a function of Scene that changes a body, which checks the values.
  template <auto function, class... Values>
  void change(std::int64_t id, Values... values) {
    (changeable().*function)(checkedId(id), values...);
  }
  // Enables or disables contacts of two bodies; a == b is self-contact.
  void setPairEnabled(std::int64_t a, std::int64_t b, bool enabled);
  // Sets the part of each triangle, or removes the parts (None).
  void setParts(std::int64_t id, pybind11::handle parts);
  // Enables or disables a pair of parts, given by their numbers.
  void setPartPairEnabled(std::int64_t a, std::int64_t part_a, std::int64_t b, std::int64_t part_b,
                          bool enabled);

  // These functions only read, so they also work during a detection.
  bool pairEnabled(std::int64_t a, std::int64_t b) const;
  std::vector<std::pair<BodyId, BodyId>> enabledPairs() const { return scene_.enabledPairs(); }
  std::size_t bodyCount() const { return scene_.bodyCount(); }
  std::size_t triangleCount() const { return scene_.triangleCount(); }
  std::vector<std::string> names() const;

  // Locks the scene against changes as long as it lives. Several detectors may hold such locks at
  // once. The counter needs no mutex, because Python's global lock protects it.
  class Looking {
   public:
    explicit Looking(PythonScene* scene) : scene_(scene) { ++scene_->lookers(); }
    Looking(const Looking&) = delete;
    Looking& operator=(const Looking&) = delete;
    ~Looking() { --scene_->lookers(); }

   private:
    PythonScene* scene_;
  };

  // Returns the scene for reading. Hold a Looking while another thread may run Python code.
  const Scene& scene() const { return scene_; }

 private:
  // Returns how many detections of this process look at the scene.
  int& lookers();
  // Throws std::runtime_error if a detector uses the scene.
  Scene& changeable();
  // Returns the id, or throws std::invalid_argument if no body has it.
  BodyId checkedId(std::int64_t id) const;
  // Returns a copy: while numpy converts arguments, Python code may add bodies.
  std::string nameOf(std::int64_t id) const { return scene_.body(checkedId(id)).name; }

  Scene scene_;
  std::map<BodyId, pybind11::object> device_arrays_;  // that the scene's bodies point into
  int lookers_ = 0;
  unsigned lookers_forks_ = 0;  // forkCount() of their process
};

// Adds the class Scene.
void bindScene(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
