// Embree's rtcCollide, on boxes.
#include <embree3/rtcore.h>

#include <stdexcept>

#include "rivals.h"
#include "triangle_box.h"

namespace deformable_contact_monitor {
namespace {

void bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& mesh = *static_cast<const TriangleMesh*>(arguments->geometryUserPtr);
  RTCBounds* out = arguments->bounds_o;
  triangleBox(mesh, arguments->primID, &out->lower_x, &out->upper_x);
}

void count(void* user, RTCCollision* collisions, unsigned int number) {
  for (unsigned int i = 0; i < number; ++i) {
    *static_cast<std::size_t*>(user) += collisions[i].primID0 < collisions[i].primID1;
  }
}

}  // namespace

std::size_t embreeBoxPairs(const TriangleMesh& mesh) {
  static const RTCDevice kDevice = rtcNewDevice("threads=1");
  if (kDevice == nullptr) throw std::runtime_error("Embree does not start");
  const RTCScene scene = rtcNewScene(kDevice);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_DYNAMIC);
  const RTCGeometry geometry = rtcNewGeometry(kDevice, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned int>(mesh.triangleCount()));
  rtcSetGeometryUserData(geometry, const_cast<TriangleMesh*>(&mesh));
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  std::size_t pairs = 0;
  rtcCollide(scene, scene, count, &pairs);
  rtcReleaseScene(scene);
  return pairs;
}

}  // namespace deformable_contact_monitor
