// The papers' rule for which clusters a triangle belongs to: one radius for all.
#pragma once

#include "core/cpu/assign.h"
#include "core/cpu/cluster.h"
#include "core/cpu/size_split.h"
#include "core/cpu/transform.h"

namespace deformable_contact_monitor {

// Every cluster whose Voronoi cell, its borders moved outwards by the largest radius of all regular
// triangles about their centroids, holds the triangle's centroid. In that reading ("overlap between
// clusters >= max_i max_k |C_i - vertex_i,k|") the papers' rule loses no contact: where two
// triangles meet, the centroid of neither is farther than that from the cell of the place.
ClusterAssignment<Triangle> assignByGlobalRadius(const WorkingSet& set, const SizeSplit& split,
                                                 const Prototypes& prototypes);

}  // namespace deformable_contact_monitor
