// Prints the oracle's contacts of mesh files, each one body: `bodyA triA bodyB triB` lines.
#include <iostream>
#include <string>
#include <vector>

#include "cgal_oracle.h"
#include "core/mesh_file.h"
#include "tools/common/command_line.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

int run(int argc, char** argv) {
  CommandLine line("oracle_pairs", "Contacts of mesh files by CGAL's exact predicates");
  std::vector<std::string> files;
  bool self = false;
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  line.addPositionals("MESH", &files, true, "one body each, numbered from 0");
  line.addFlag("--self", &self, "also contacts of each body with itself");
  line.add("--adjacent", &adjacent, "pairs that share a vertex");
  if (!line.parse(argc, argv)) return 0;
  Scene scene;
  for (const std::string& file : files) scene.addBody(file, readMeshFile(file));
  for (BodyId a = 0; a < scene.bodyCount(); ++a) {
    for (BodyId b = a; b < scene.bodyCount(); ++b) scene.setPairEnabled(a, b, a != b || self);
  }
  for (const TrianglePair& p : oracleContacts(scene, adjacent)) {
    std::cout << p.body_a << ' ' << p.triangle_a << ' ' << p.body_b << ' ' << p.triangle_b << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("oracle_pairs", [argc, argv] { return dcm::run(argc, argv); });
}
