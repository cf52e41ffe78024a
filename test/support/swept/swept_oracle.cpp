// The definition of a contact between two states, in exact integers.
#include "swept_oracle.h"

#include <algorithm>
#include <map>

#include "moving_hulls.h"
#include "scenes.h"
#include "swept_triangle.h"

namespace deformable_contact_monitor {
namespace {

constexpr unsigned long kTimeBits = 30;  // of an interval of time

SweptTriangle pathOf(BodyId body, const Triangle& state0, const Triangle& state1) {
  return {body, 0, {state0, state1}, {state0, state1}};
}

bool areInContact(const SweptTriangle& a, const SweptTriangle& b, AdjacentPairs adjacent) {
  return isJudged(a, b, adjacent) && meetEver(hullsOf(a, b));
}

std::optional<SweptTime> firstContact(const SweptTriangle& a, const SweptTriangle& b) {
  std::optional<MeetingTime> first = firstMeeting(hullsOf(a, b));
  if (!first) return std::nullopt;
  first->time.refineTo(kTimeBits);
  return SweptTime{toRational(first->time.low()), toRational(first->time.high()),
                   first->is_attained};
}

std::optional<SweptTime> firstContact(const SweptTriangle& a, const SweptTriangle& b,
                                      AdjacentPairs adjacent) {
  if (!isJudged(a, b, adjacent)) return std::nullopt;
  return firstContact(a, b);
}

}  // namespace

bool sweptContact(const Triangle& a0, const Triangle& a1, const Triangle& b0, const Triangle& b1) {
  return areInContact(pathOf(0, a0, a1), pathOf(1, b0, b1), AdjacentPairs::kSkip);
}

std::optional<SweptTime> firstSweptContact(const Triangle& a0, const Triangle& a1,
                                           const Triangle& b0, const Triangle& b1) {
  return firstContact(pathOf(0, a0, a1), pathOf(1, b0, b1), AdjacentPairs::kSkip);
}

bool sweptContact(const Triangle& a0, const Triangle& a1, const Triangle& b0, const Triangle& b1,
                  AdjacentPairs adjacent) {
  return areInContact(pathOf(0, a0, a1), pathOf(0, b0, b1), adjacent);
}

std::optional<SweptTime> firstSweptContact(const Triangle& a0, const Triangle& a1,
                                           const Triangle& b0, const Triangle& b1,
                                           AdjacentPairs adjacent) {
  return firstContact(pathOf(0, a0, a1), pathOf(0, b0, b1), adjacent);
}

bool vertexFaceMeets(const std::array<Trajectory, 4>& points) {
  return meetEver({{points.begin(), points.end()}, 0b0001, 0b1110});
}

bool edgeEdgeMeets(const std::array<Trajectory, 4>& points) {
  return meetEver({{points.begin(), points.end()}, 0b0011, 0b1100});
}

std::vector<TrianglePair> oracleSweptContacts(const Scene& state0, const Scene& state1,
                                              AdjacentPairs adjacent) {
  const std::vector<SweptTriangle> triangles = sweptTriangles(state0, state1);
  std::vector<TrianglePair> contacts;
  for (const auto& [a, b] : sweptBoxPairs(state1, triangles, adjacent)) {
    if (!meetEver(hullsOf(*a, *b))) continue;
    contacts.emplace_back(a->body, a->triangle, b->body, b->triangle);
  }
  std::sort(contacts.begin(), contacts.end());
  return contacts;
}

std::vector<SweptTime> oracleFirstTimes(const Scene& state0, const Scene& state1,
                                        const std::vector<TrianglePair>& contacts) {
  std::map<std::pair<BodyId, std::uint32_t>, SweptTriangle> triangles;
  for (const SweptTriangle& t : sweptTriangles(state0, state1)) {
    triangles.emplace(std::make_pair(t.body, t.triangle), t);
  }
  std::vector<SweptTime> times;
  for (const TrianglePair& p : contacts) {
    times.push_back(
        firstContact(triangles.at({p.body_a, p.triangle_a}), triangles.at({p.body_b, p.triangle_b}))
            .value());
  }
  return times;
}

std::set<std::pair<std::uint32_t, std::uint32_t>> sweptPairs(const TriangleMesh& state0,
                                                             const TriangleMesh& state1,
                                                             AdjacentPairs adjacent) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const TrianglePair& p :
       oracleSweptContacts(selfScene(state0), selfScene(state1), adjacent)) {
    pairs.emplace(p.triangle_a, p.triangle_b);
  }
  return pairs;
}

}  // namespace deformable_contact_monitor
