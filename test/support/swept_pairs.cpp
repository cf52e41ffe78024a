// Prints the swept oracle's contacts of a mesh in two states with itself, as `triA triB` lines; or
// those of two meshes in two states each, with the first time: `triA triB low high`.
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/common/posed_body.h"
#include "core/mesh_file.h"
#include "scenes.h"
#include "swept/moving_hulls.h"
#include "swept/swept_oracle.h"
#include "swept/swept_triangle.h"
#include "tools/common/command_line.h"
#include "tools/common/run_tool.h"

namespace deformable_contact_monitor {
namespace {

struct Arguments {
  std::vector<std::string> files;
  AdjacentPairs adjacent = AdjacentPairs::kBeyondShared;
  int sample = 0, seed = 0, part = 0, parts = 1;
};

Scene pairOf(const std::string& a, const std::string& b) {
  Scene scene;
  const BodyId first = scene.addBody("a", readMeshFile(a));
  const BodyId second = scene.addBody("b", readMeshFile(b));
  scene.setPairEnabled(first, second, true);
  return scene;
}

int printPairsOfTwo(const std::vector<std::string>& files) {
  const Scene state0 = pairOf(files[0], files[2]), state1 = pairOf(files[1], files[3]);
  std::cout.precision(17);
  for (const TrianglePair& pair :
       oracleSweptContacts(state0, state1, AdjacentPairs::kBeyondShared)) {
    const auto of = [](const Scene& scene, BodyId body, std::uint32_t triangle) {
      return PosedBody(scene.body(body)).triangle(triangle);
    };
    const std::optional<SweptTime> time =
        firstSweptContact(of(state0, 0, pair.triangle_a), of(state1, 0, pair.triangle_a),
                          of(state0, 1, pair.triangle_b), of(state1, 1, pair.triangle_b));
    std::cout << pair.triangle_a << ' ' << pair.triangle_b << ' ' << time->low.get_d() << ' '
              << time->high.get_d() << '\n';
  }
  return 0;
}

int run(int argc, char** argv) {
  CommandLine line("swept_pairs",
                   "Contacts of a mesh with itself, or of two meshes, between two states, exactly");
  Arguments arguments;
  line.addPositionals("MESH", &arguments.files, true,
                      "state 0, state 1; of two meshes: A0 A1 B0 B1");
  line.add("--adjacent", &arguments.adjacent, "pairs that share a vertex");
  line.add("--sample", &arguments.sample,
           "judge so many of the pairs with boxes that overlap; 0: all");
  line.add("--seed", &arguments.seed, "of the sample");
  line.add("--part", &arguments.part, "judge this part of them alone, from 0");
  line.add("--parts", &arguments.parts, "of so many, each from everywhere");
  if (!line.parse(argc, argv)) return 0;
  if (arguments.files.size() == 4) return printPairsOfTwo(arguments.files);
  if (arguments.files.size() != 2) throw std::invalid_argument("needs two mesh files, or four");
  if (arguments.part < 0 || arguments.part >= arguments.parts) {
    throw std::invalid_argument("--part is no part of --parts");
  }
  const Scene state0 = selfScene(readMeshFile(arguments.files[0]));
  const Scene state1 = selfScene(readMeshFile(arguments.files[1]));
  const std::vector<SweptTriangle> triangles = sweptTriangles(state0, state1);
  auto pairs = sweptBoxPairs(state1, triangles, arguments.adjacent);
  std::sort(pairs.begin(), pairs.end());
  std::cerr << pairs.size() << " pairs of boxes\n";
  if (arguments.sample > 0) {
    std::mt19937 generator(static_cast<unsigned>(arguments.seed));
    std::shuffle(pairs.begin(), pairs.end(), generator);
    pairs.resize(std::min(pairs.size(), static_cast<std::size_t>(arguments.sample)));
    std::sort(pairs.begin(), pairs.end());
  }
  std::size_t judged = 0, contacts = 0;
  const auto step = static_cast<std::size_t>(arguments.parts);
  for (auto i = static_cast<std::size_t>(arguments.part); i < pairs.size(); i += step) {
    const auto& [a, b] = pairs[i];
    ++judged;
    if (!meetEver(hullsOf(*a, *b))) continue;
    ++contacts;
    std::cout << a->triangle << ' ' << b->triangle << '\n';
  }
  std::cerr << judged << " judged, " << contacts << " contacts\n";
  return 0;
}

}  // namespace
}  // namespace deformable_contact_monitor

int main(int argc, char** argv) {
  namespace dcm = deformable_contact_monitor;
  return dcm::runTool("swept_pairs", [argc, argv] { return dcm::run(argc, argv); });
}
