// Prints the oracle's contacts of mesh files, each one body: `bodyA triA bodyB triB` lines.
#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "cgal_oracle.h"
#include "core/mesh_files/mesh_file.h"

int main(int argc, char** argv) {
  using namespace deformable_contact_monitor;
  CLI::App app{"Contacts of mesh files by CGAL's exact predicates"};
  std::vector<std::string> files;
  bool self = false;
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  app.add_option("MESH", files, "one body each, numbered from 0")->required();
  app.add_flag("--self", self, "also contacts of each body with itself");
  app.add_option("--adjacent", adjacent, "pairs that share a vertex")
      ->transform(CLI::CheckedTransformer(std::map<std::string, AdjacentPairs>{
          {"skip", AdjacentPairs::kSkip}, {"beyond_shared", AdjacentPairs::kBeyondShared}}));
  CLI11_PARSE(app, argc, argv);
  try {
    Scene scene;
    for (const std::string& file : files) scene.addBody(file, readMeshFile(file));
    for (BodyId a = 0; a < scene.bodyCount(); ++a) {
      for (BodyId b = a; b < scene.bodyCount(); ++b) {
        scene.setPairEnabled(a, b, a != b || self);
      }
    }
    for (const TrianglePair& p : oracleContacts(scene, adjacent)) {
      std::cout << p.body_a << ' ' << p.triangle_a << ' ' << p.body_b << ' ' << p.triangle_b
                << '\n';
    }
  } catch (const std::exception& e) {
    std::cerr << "oracle_pairs: " << e.what() << '\n';
    return 2;
  }
  return 0;
}
