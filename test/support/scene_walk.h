// A scene and its options that change at random, step by step, as nobody would change them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/options.h"
#include "core/scene.h"

namespace deformable_contact_monitor {

// The same seed takes the same steps on every machine. Scenes have up to six bodies of up to some
// hundred triangles each; now and then one has up to two thousand.
class SceneWalk {
 public:
  explicit SceneWalk(std::uint32_t seed);

  // One change: a body added, a mesh replaced (also by none), vertices moved, not finite or far
  // off, a body scaled by a power of ten, posed, given a margin, a pair switched, or options
  // changed, among them what margins are for. Returns what, for messages.
  std::string step();

  const Scene& scene() const { return scene_; }
  const Options& options() const { return options_; }

 private:
  using Change = std::string (SceneWalk::*)();

  std::string addBody();
  std::string replaceMesh();
  std::string moveAll();
  std::string moveOne();
  std::string makeStrange();
  std::string scale();
  std::string pose();
  std::string setMargin();
  std::string switchPair();
  std::string switchAll();
  std::string changeSpeedOptions();
  std::string changeMeaning();
  std::string changeWhatMarginsAreFor();

  TriangleMesh randomMesh();
  void setVertices(BodyId id, const std::vector<float>& vertices);
  BodyId anyBody() { return static_cast<BodyId>(below(scene_.bodyCount())); }
  std::size_t below(std::size_t n) { return random_() % n; }
  float unit() { return static_cast<float>(random_()) * 0x1p-32F; }  // [0, 1]
  bool isOneOf(std::size_t n) { return below(n) == 0; }

  std::mt19937 random_;
  Scene scene_;
  Options options_;
};

}  // namespace deformable_contact_monitor
