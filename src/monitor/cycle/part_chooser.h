// Finds out which triangles of an object's meshes its named parts are, and which of them are held.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/scene.h"
#include "monitor/cycle_report.h"
#include "monitor/input/incoming_mesh.h"
#include "monitor/rules/parameters.h"

namespace deformable_contact_monitor {

// The parts of one object. Parts that are given by their triangles fit every mesh that has these
// triangles. Parts that are groups of a mesh file fit meshes with the triangles of that file. Parts
// that are given by a box are chosen once, in the first mesh whose vertices are all finite, and
// hold for meshes with the triangles of that mesh. So does the part that is held. One thread at a
// time.
class PartChooser {
 public:
  explicit PartChooser(const ObjectParameters& object);

  // Takes the object's mesh, which must have been accepted. Finds the parts anew if its triangles
  // are others than those of the mesh before. Logs a warning when parts become unknown.
  void update(const IncomingMesh& mesh);

  // Holds this part from now on, in place of an earlier one; null: holds nothing.
  void hold(std::shared_ptr<const HeldPart> held);
  const std::shared_ptr<const HeldPart>& held() const { return held_; }
  // Returns whether the last mesh has the triangles that are held.
  bool fitsHeld() const { return parts_ != nullptr && parts_->heldPart() != 0; }

  // Returns the piece (BodyParts) of each triangle; an empty list if the object has no parts, or if
  // nobody knows which triangles they are.
  const std::vector<PartId>& ofTriangles() const { return of_triangles_; }
  // Returns the margins [m] of the pieces whose part has one of its own.
  std::map<PartId, float> marginsOfPieces() const;
  // Returns the parts as they are now, another object whenever they have changed; null if the
  // object has none.
  const std::shared_ptr<const BodyParts>& parts() const { return parts_; }

 private:
  // They throw std::invalid_argument, naming the part, if the parts do not fit.
  void choose(const IncomingMesh& mesh);
  void requireSameTriangles(std::size_t part, const Topology& topology) const;
  void chooseBoxes(const IncomingMesh& mesh);
  void add(std::size_t part, std::size_t triangle);
  void makePieces();
  void splitHeld(BodyParts* parts);
  std::string name(std::size_t part) const { return object_ + ":" + given_[part].name; }

  const std::string object_;
  const std::vector<PartParameters> given_;
  bool has_box_ = false;
  std::shared_ptr<const Topology> topology_;        // of the last mesh
  std::shared_ptr<const Topology> boxes_topology_;  // in which boxes were chosen; null: not yet
  std::vector<std::vector<std::size_t>> of_boxes_;  // triangles by part; empty without a box
  std::shared_ptr<const HeldPart> held_;
  std::vector<PartId> named_;  // the given part of each triangle; empty: not known
  std::string problem_;        // why it is not
  std::vector<PartId> of_triangles_;
  std::shared_ptr<const BodyParts> parts_;
};

}  // namespace deformable_contact_monitor
