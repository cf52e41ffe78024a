// Finds out which triangles of an object's meshes its named parts are, and which of them are held.
#include "monitor/cycle/part_chooser.h"

#include <ros/console.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace deformable_contact_monitor {
namespace {

// Returns whether the centroid of the triangle with these corners lies in the box.
bool isInside(const PartBox& box, const std::vector<float>& vertices,
              const std::uint32_t* corners) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += vertices[3 * std::size_t{corners[i]} + axis];
    if (!(sum >= 3 * box.min[axis] && sum <= 3 * box.max[axis])) return false;
  }
  return true;
}

bool haveSameTriangles(const Topology& a, const Topology& b) {
  return a.vertex_count == b.vertex_count && a.triangles == b.triangles;
}

}  // namespace

PartChooser::PartChooser(const ObjectParameters& object)
    : object_(object.name), given_(object.parts), parts_(bodyOf(object).parts) {
  has_box_ = std::any_of(given_.begin(), given_.end(),
                         [](const PartParameters& part) { return part.box.has_value(); });
}

// While boxes wait for a mesh with finite vertices, each mesh may be the one.
void PartChooser::update(const IncomingMesh& mesh) {
  const bool is_waiting = has_box_ && boxes_topology_ == nullptr;
  if (mesh.topology == topology_ && !is_waiting) return;
  topology_ = mesh.topology;
  if (given_.empty() && held_ == nullptr) return;
  named_.clear();
  try {
    if (!given_.empty()) choose(mesh);
    problem_.clear();
  } catch (const std::invalid_argument& error) {
    named_.clear();
    if (problem_ != error.what()) {
      ROS_WARN_STREAM("parts are UNKNOWN: " << error.what() << "; see config/README.md#parts");
    }
    problem_ = error.what();
  }
  makePieces();
}

void PartChooser::hold(std::shared_ptr<const HeldPart> held) {
  if (held == held_) return;
  held_ = std::move(held);
  makePieces();
}

void PartChooser::makePieces() {
  BodyParts parts = partsOf(given_);
  parts.problem = problem_;
  of_triangles_ = named_;
  const bool fits =
      held_ != nullptr && topology_ != nullptr &&
      (held_->topology == topology_ || haveSameTriangles(*held_->topology, *topology_));
  if (fits) splitHeld(&parts);
  parts.triangles.resize(parts.pieceCount());
  for (const PartId piece : of_triangles_) ++parts.triangles[piece];
  parts_ = parts.names.empty() ? nullptr : std::make_shared<const BodyParts>(std::move(parts));
}

// Gives the held triangles pieces of their own, one for each part that they were of.
void PartChooser::splitHeld(BodyParts* parts) {
  of_triangles_.resize(topology_->triangles.size() / 3);
  std::set<PartId> taken_from;
  for (const std::uint32_t t : held_->triangles) taken_from.insert(of_triangles_[t]);
  parts->names.emplace_back(kHeldPart);
  parts->held_of.assign(taken_from.begin(), taken_from.end());
  std::size_t piece = parts->names.size();
  std::map<PartId, PartId> piece_of;
  for (const PartId part : taken_from) piece_of[part] = static_cast<PartId>(piece++);
  for (const std::uint32_t t : held_->triangles) of_triangles_[t] = piece_of[of_triangles_[t]];
}

// What is held of a part keeps its margin.
std::map<PartId, float> PartChooser::marginsOfPieces() const {
  std::map<PartId, float> of_pieces;
  const std::size_t pieces = parts_ == nullptr ? 0 : parts_->pieceCount();
  for (std::size_t i = 1; i < pieces; ++i) {
    const auto piece = static_cast<PartId>(i);
    for (const auto& [part, margin_m] : parts_->margins_m) {
      if (parts_->has(part, piece)) of_pieces[piece] = margin_m;
    }
  }
  return of_pieces;
}

void PartChooser::choose(const IncomingMesh& mesh) {
  const std::size_t count = mesh.topology->triangles.size() / 3;
  named_.assign(count, 0);
  for (std::size_t part = 0; part < given_.size(); ++part) {
    requireSameTriangles(part, *mesh.topology);
    for (const auto& [first, last] : given_[part].ranges) {
      if (last >= count) {
        throw std::invalid_argument(name(part) + " has triangle " + std::to_string(last) +
                                    ", but the mesh of topology_id " +
                                    std::to_string(mesh.topology->id) + " has " +
                                    std::to_string(count) + " triangles");
      }
      for (std::size_t triangle = first; triangle <= last; ++triangle) add(part, triangle);
    }
  }
  if (has_box_) chooseBoxes(mesh);
}

// Parts of one file share its mesh, which is compared once.
void PartChooser::requireSameTriangles(std::size_t part, const Topology& topology) const {
  const TriangleMesh* const of = given_[part].mesh.get();
  if (of == nullptr || (part > 0 && given_[part - 1].mesh.get() == of)) return;
  if (of->vertexCount() == topology.vertex_count &&
      std::equal(of->triangles.begin(), of->triangles.end(), topology.triangles.begin(),
                 topology.triangles.end())) {
    return;
  }
  throw std::invalid_argument(name(part) + " is a group of a mesh file with " +
                              std::to_string(of->vertexCount()) + " vertices and " +
                              std::to_string(of->triangleCount()) +
                              " triangles, and the mesh of topology_id " +
                              std::to_string(topology.id) + " has other triangles");
}

void PartChooser::chooseBoxes(const IncomingMesh& mesh) {
  const std::vector<float>& vertices = mesh.message->vertices;
  const std::vector<std::uint32_t>& triangles = mesh.topology->triangles;
  if (boxes_topology_ == nullptr) {
    if (!std::all_of(vertices.begin(), vertices.end(), [](float x) { return std::isfinite(x); })) {
      throw std::invalid_argument(object_ +
                                  ": boxes of parts wait for a mesh whose vertices are all "
                                  "finite");
    }
    boxes_topology_ = mesh.topology;
    of_boxes_.resize(given_.size());
    for (std::size_t part = 0; part < given_.size(); ++part) {
      if (!given_[part].box) continue;
      for (std::size_t t = 0; t < triangles.size() / 3; ++t) {
        if (isInside(*given_[part].box, vertices, &triangles[3 * t])) of_boxes_[part].push_back(t);
      }
    }
  } else if (!haveSameTriangles(*boxes_topology_, *mesh.topology)) {
    throw std::invalid_argument(object_ + ": boxes of parts were taken in a mesh of topology_id " +
                                std::to_string(boxes_topology_->id) +
                                ", and this mesh has other triangles");
  }
  for (std::size_t part = 0; part < given_.size(); ++part) {
    if (given_[part].box && of_boxes_[part].empty()) {
      throw std::invalid_argument(name(part) + " has a box without a triangle of the first mesh");
    }
    for (const std::size_t triangle : of_boxes_[part]) add(part, triangle);
  }
}

void PartChooser::add(std::size_t part, std::size_t triangle) {
  PartId& of_triangle = named_[triangle];
  if (of_triangle != 0 && of_triangle != part + 1) {
    throw std::invalid_argument(name(of_triangle - 1U) + " and " + name(part) +
                                " both have triangle " + std::to_string(triangle));
  }
  of_triangle = static_cast<PartId>(part + 1);
}

}  // namespace deformable_contact_monitor
