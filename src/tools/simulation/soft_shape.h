// The soft object that a simulation starts with: a cloth, a rope, a ball or a mesh file, as nodes,
// springs and triangles. No Bullet.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace deformable_contact_monitor {

// A distance between two nodes that the object tries to keep.
struct SoftSpring {
  std::uint32_t a, b;
  bool bends = false;  // across two cells or an edge: weak, and only against folding
};

// A soft object at rest.
struct SoftShape {
  std::vector<Eigen::Vector3d> nodes;  // [m]
  std::vector<SoftSpring> springs;     // in the order in which they are solved
  std::vector<std::uint32_t> pinned;   // nodes that never move, ascending
  // The triangles on the nodes. Those of a rope are its segments: (i, i + 1, i + 1).
  std::vector<std::uint32_t> triangles;
  // The node of each vertex of the mesh. Vertices of a file with equal coordinates share a node.
  std::vector<std::uint32_t> node_of_vertex;
  // The triangles as they are published, on vertices.
  std::vector<std::uint32_t> mesh_triangles;
  bool is_rope = false;
  bool is_volume = false;  // a closed surface that keeps its volume and shape
};

// What a shape is made from.
struct SoftShapeOptions {
  std::string object = "cloth";  // cloth, rope, volume, or the path of a mesh file
  std::string pinned = "edge";   // edge, corners or none; see softShape()
  int vertices = 900;            // about, for a cloth, a rope and a volume
  double size_m = 1;             // cloth's edge, rope's length, volume's diameter; factor of a file
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // [m]
  std::uint32_t seed = 1;                            // of a small unevenness
};

// Makes a shape. A cloth is a square that lies flat, from the middle of its first edge at `offset`
// towards -x; a rope lies along -x from there; a volume is a ball about `offset`; the vertices of a
// file are scaled and then moved by `offset`. What `pinned` selects:
//   edge     cloth: its first edge; rope: its first end; volume: what it stands on, the lowest
//            twentieth of its height; file: the same of a closed surface, else the highest
//   corners  cloth: its four corners; rope: both ends; not for other objects
//   none     nothing
// The same options give the same shape, bit by bit. Throws std::invalid_argument, one line, if the
// options make no object, and std::runtime_error as readMeshFile() does.
SoftShape softShape(const SoftShapeOptions& options);

}  // namespace deformable_contact_monitor
