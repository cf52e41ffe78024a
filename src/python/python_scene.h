// The scene of the Python module.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/scene.h"

namespace deformable_contact_monitor {

// A scene whose changes are refused (std::runtime_error) while a detector in another thread looks
// at it. Ids are as callers give them: what is no body is refused by name. For threads that hold
// Python's global lock.
class PythonScene {
 public:
  BodyId addBody(const std::string& name, pybind11::handle vertices, pybind11::handle triangles);
  void setMesh(std::int64_t id, pybind11::handle vertices, pybind11::handle triangles);
  void setVertices(std::int64_t id, pybind11::handle vertices);
  // The array lives until the body has other vertices.
  void setDeviceVertices(std::int64_t id, pybind11::object vertices,
                         std::optional<std::uintptr_t> stream);
  void setPose(std::int64_t id, pybind11::handle rotation, pybind11::handle translation);
  void setMargin(std::int64_t id, float margin_m);
  // None: as it is now.
  void setEarlier(std::int64_t id, pybind11::handle vertices, pybind11::handle rotation,
                  pybind11::handle translation);
  void clearEarlier(std::int64_t id);
  void setPad(std::int64_t id, float pad_m);
  void setPairEnabled(std::int64_t a, std::int64_t b, bool enabled);

  bool pairEnabled(std::int64_t a, std::int64_t b) const;
  std::vector<std::pair<BodyId, BodyId>> enabledPairs() const { return scene_.enabledPairs(); }
  std::size_t bodyCount() const { return scene_.bodyCount(); }
  std::size_t triangleCount() const { return scene_.triangleCount(); }
  std::vector<std::string> names() const;

  // While one of these lives, the scene is looked at and stays as it is.
  class Looking {
   public:
    explicit Looking(PythonScene* scene) : scene_(scene) { ++scene_->lookers_; }
    Looking(const Looking&) = delete;
    Looking& operator=(const Looking&) = delete;
    ~Looking() { --scene_->lookers_; }

   private:
    PythonScene* scene_;
  };

  const Scene& scene() const { return scene_; }

 private:
  // Throws std::runtime_error if somebody looks at it.
  Scene& changeable();
  BodyId checkedId(std::int64_t id) const;
  const std::string& nameOf(std::int64_t id) const { return scene_.body(checkedId(id)).name; }

  Scene scene_;
  std::map<BodyId, pybind11::object> device_arrays_;  // that the scene's bodies point into
  int lookers_ = 0;
};

// Adds the class Scene.
void bindScene(pybind11::module& module);  // NOLINT(google-runtime-references): pybind11's custom

}  // namespace deformable_contact_monitor
