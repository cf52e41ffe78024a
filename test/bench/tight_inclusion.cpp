#include "tight_inclusion.h"

#include <tight_inclusion/ccd.hpp>

namespace deformable_contact_monitor {
namespace {

ticcd::Vector3 vector(const Vec3f& p) { return {p.x, p.y, p.z}; }

}  // namespace

bool meetsByTightInclusion(const Feature& feature) {
  const ticcd::Array3 no_scene(-1, -1, -1);
  constexpr double kTolerance = 1e-6;
  constexpr long kMostSteps = 1000000;
  double time = 0, reached = 0;
  ticcd::Vector3 from[4], to[4];
  for (int i = 0; i < 4; ++i) {
    from[i] = vector(feature.x[i].from);
    to[i] = vector(feature.x[i].to);
  }
  if (feature.kind == FeatureKind::kVertexFace) {
    return ticcd::vertexFaceCCD(from[3], from[0], from[1], from[2], to[3], to[0], to[1], to[2],
                                no_scene, 0, time, kTolerance, 1, kMostSteps, reached);
  }
  return ticcd::edgeEdgeCCD(from[0], from[1], from[2], from[3], to[0], to[1], to[2], to[3],
                            no_scene, 0, time, kTolerance, 1, kMostSteps, reached);
}

}  // namespace deformable_contact_monitor
