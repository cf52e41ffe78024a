#include <deformable_contact_monitor/core/cpu_detector.h>
#include <deformable_contact_monitor/core/mesh_file.h>

#include <iostream>

namespace dcm = deformable_contact_monitor;

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  dcm::Scene scene;
  const dcm::BodyId gripper = scene.addBody("gripper", dcm::readMeshFile(argv[1]));
  const dcm::BodyId cloth = scene.addBody("cloth", dcm::readMeshFile(argv[2]));
  scene.setPairEnabled(gripper, cloth, true);
  scene.setPairEnabled(cloth, cloth, true);

  const auto detector = dcm::makeCpuDetector();
  const dcm::DetectionResult& result = detector->detect(scene);
  for (const dcm::TrianglePair& pair : result.contacts) {
    std::cout << scene.body(pair.body_a).name << " " << pair.triangle_a << " "
              << scene.body(pair.body_b).name << " " << pair.triangle_b << "\n";
  }
}
