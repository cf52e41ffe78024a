// CGAL's hybrid of streaming and segment trees, on boxes.
#include <CGAL/box_intersection_d.h>

#include <vector>

#include "rivals.h"
#include "triangle_box.h"

namespace deformable_contact_monitor {

std::size_t cgalBoxPairs(const TriangleMesh& mesh) {
  using Box = CGAL::Box_intersection_d::Box_d<float, 3>;
  std::vector<Box> boxes;
  boxes.reserve(mesh.triangleCount());
  for (std::size_t t = 0; t < mesh.triangleCount(); ++t) {
    float low[3], high[3];
    triangleBox(mesh, t, low, high);
    boxes.emplace_back(low, high);
  }
  std::size_t count = 0;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                [&count](const Box&, const Box&) { ++count; });
  return count;
}

}  // namespace deformable_contact_monitor
