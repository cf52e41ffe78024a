// Published vertex-face and edge-edge queries with their verdicts: those in `published`, and those
// in $DCM_SWEPT_QUERIES, a folder with files NAME/edge-edge/*.csv and NAME/vertex-face/*.csv.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/predicates/swept_exact.h"
#include "swept/swept_oracle.h"

namespace deformable_contact_monitor {
namespace {

namespace fs = std::filesystem;

struct Query {
  std::array<Trajectory, 4> points;  // the vertex first, or the two edges
  bool is_vertex_face;
  bool published;
};

// Lines of x, y, z as numerator and denominator, and the verdict; four points in state 0, then
// in 1.
std::vector<Query> readQueries(const fs::path& file) {
  std::ifstream in(file);
  const bool is_vertex_face = file.parent_path().filename() == "vertex-face";
  std::vector<Query> queries;
  std::string line;
  for (std::size_t i = 0; std::getline(in, line); ++i) {
    if (i % 8 == 0) queries.push_back({{}, is_vertex_face, false});
    Trajectory& point = queries.back().points[i % 4];
    std::istringstream fields(line);
    std::string numerator, denominator, verdict;
    for (mpq_class& x : i % 8 < 4 ? point.start : point.end) {
      std::getline(fields, numerator, ',');
      std::getline(fields, denominator, ',');
      x = mpq_class(mpz_class(numerator), mpz_class(denominator));
      x.canonicalize();
    }
    if (!std::getline(fields, verdict)) throw std::runtime_error(file.string() + ": " + line);
    queries.back().published = verdict.at(0) == '1';
  }
  return queries;
}

std::vector<fs::path> queryFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string kind = entry.path().parent_path().filename().string();
    if (entry.path().extension() != ".csv") continue;
    if (kind == "edge-edge" || kind == "vertex-face") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

float rounded(const mpq_class& x) { return static_cast<float>(x.get_d()); }

MovingPoint rounded(const Trajectory& t) {
  return {{rounded(t.start[0]), rounded(t.start[1]), rounded(t.start[2])},
          {rounded(t.end[0]), rounded(t.end[1]), rounded(t.end[2])}};
}

Trajectory exactly(const MovingPoint& p) {
  const auto point = [](const Vec3f& v) {
    return RationalPoint{mpq_class(double{v.x}), mpq_class(double{v.y}), mpq_class(double{v.z})};
  };
  return {point(p.from), point(p.to)};
}

// As float32, to the nearest.
struct RoundedQuery {
  explicit RoundedQuery(const Query& query) : is_vertex_face(query.is_vertex_face) {
    for (std::size_t i = 0; i < 4; ++i) {
      points[i] = rounded(query.points[i]);
      exact[i] = exactly(points[i]);
      is_same = is_same && exact[i] == query.points[i];
    }
  }

  std::array<MovingPoint, 4> points;
  std::array<Trajectory, 4> exact;
  bool is_vertex_face;
  bool is_same = true;  // nothing was rounded
};

bool oracleOf(const std::array<Trajectory, 4>& points, bool is_vertex_face) {
  return is_vertex_face ? vertexFaceMeets(points) : edgeEdgeMeets(points);
}

MovingTriangle triangleOf(const MovingPoint& a, const MovingPoint& b, const MovingPoint& c) {
  return {{{a.from, b.from, c.from}}, {{a.to, b.to, c.to}}};
}

// Decides a query as two triangles of two bodies: a vertex becomes a triangle with three equal
// corners, an edge one with two.
bool verdictOf(const RoundedQuery& query, bool wants_time) {
  const auto& [p, q, r, s] = query.points;
  const MovingTriangle a = query.is_vertex_face ? triangleOf(p, p, p) : triangleOf(p, q, p);
  const MovingTriangle b = query.is_vertex_face ? triangleOf(q, r, s) : triangleOf(r, s, s);
  PredicateState state;
  const SweptVerdict verdict =
      sweptVerdict(a, b, SharedVertices(), AdjacentPairs::kSkip, wants_time, state);
  EXPECT_NE(verdict.part, PartVerdict::kOpen);
  return verdict.part == PartVerdict::kMeet;
}

// As one feature, by the exact step alone.
bool featureMeets(const RoundedQuery& query) {
  const auto& [p, q, r, s] = query.points;
  PredicateState state;
  if (query.is_vertex_face) {
    const Triangle face{{q.from, r.from, s.from}};
    return segmentIntersectsTriangle(p.from, p.from, face, state) ||
           exactFeatureTime({FeatureKind::kVertexFace, {q, r, s, p}}, false).happens();
  }
  return segmentsIntersect(p.from, q.from, r.from, s.from, state) ||
         exactFeatureTime({FeatureKind::kEdgeEdge, {p, q, r, s}}, false).happens();
}

struct Figures {
  std::size_t queries = 0, meet = 0, float32 = 0, oracle_differs = 0, verdict_differs = 0,
              rounded_differs = 0;

  std::size_t differences() const { return oracle_differs + verdict_differs + rounded_differs; }
};

std::ostream& operator<<(std::ostream& out, const Figures& f) {
  return out << f.queries << " queries, " << f.meet << " meet; published and oracle differ in "
             << f.oracle_differs << "; " << f.float32
             << " are of float32: published and ours differ in " << f.verdict_differs
             << "; of the others, rounded, oracle and ours differ in " << f.rounded_differs;
}

void check(const Query& query, Figures* figures) {
  ++figures->queries;
  figures->meet += query.published;
  figures->oracle_differs += oracleOf(query.points, query.is_vertex_face) != query.published;
  const RoundedQuery as_floats(query);
  figures->float32 += as_floats.is_same;
  const bool expected =
      as_floats.is_same ? query.published : oracleOf(as_floats.exact, query.is_vertex_face);
  const bool is_wrong = verdictOf(as_floats, false) != expected ||
                        verdictOf(as_floats, true) != expected ||
                        featureMeets(as_floats) != expected;
  (as_floats.is_same ? figures->verdict_differs : figures->rounded_differs) += is_wrong;
}

Figures checkAll(const fs::path& folder) {
  Figures all;
  for (const fs::path& file : queryFiles(folder)) {
    const Figures before = all;
    for (const Query& query : readQueries(file)) check(query, &all);
    EXPECT_EQ(all.differences(), before.differences()) << file;
  }
  return all;
}

TEST(SweptQueries, OfTheRepositoryAsPublished) {
  const Figures figures = checkAll(DCM_PUBLISHED_QUERIES);
  EXPECT_EQ(figures.differences(), 0U) << figures;
  EXPECT_EQ(figures.queries, 324U);
  EXPECT_EQ(figures.float32, 304U);
  EXPECT_EQ(figures.meet, 160U);
}

TEST(SweptQueries, OfTheGivenFolderAsPublished) {
  const char* folder = std::getenv("DCM_SWEPT_QUERIES");
  if (folder == nullptr) return;
  const Figures figures = checkAll(folder);
  EXPECT_GT(figures.queries, 0U);
  EXPECT_EQ(figures.differences(), 0U);
  std::cout << figures << "\n";
}

}  // namespace
}  // namespace deformable_contact_monitor
