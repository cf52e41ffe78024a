// Questions about a cycle's report that several readers ask.
#include "monitor/cycle_report.h"

#include <algorithm>

#include "core/common/scene_queries.h"
#include "core/limits.h"

namespace deformable_contact_monitor {

namespace {

// Returns whether the piece has no triangle because a hold took them, or because named parts cover
// all of the object. Before the first mesh no piece has any triangle, and that says nothing.
bool isEmptied(const BodyParts& parts, PartId piece) {
  const std::vector<std::size_t>& triangles = parts.triangles;
  const auto has_some = [](std::size_t count) { return count > 0; };
  if (std::none_of(triangles.begin(), triangles.end(), has_some)) return false;
  if (parts.isHeld(piece) || triangles.at(piece) > 0) return false;
  return std::binary_search(parts.held_of.begin(), parts.held_of.end(), piece) ||
         (piece == 0 && parts.problem.empty());
}

}  // namespace

std::string nameOf(const BodyStatus& body, PartId part) {
  return part == 0 ? body.name : body.name + ":" + body.parts->names[part - 1U];
}

std::vector<PartId> piecesOf(const BodyStatus& body, PartId part) {
  std::vector<PartId> pieces;
  for (std::size_t i = 0; i < body.pieceCount(); ++i) {
    const auto piece = static_cast<PartId>(i);
    if (part != 0 && !body.parts->has(part, piece)) continue;
    if (body.parts == nullptr || !isEmptied(*body.parts, piece)) pieces.push_back(piece);
  }
  return pieces;
}

bool hasName(const BodyStatus& body, const std::string& name) {
  for (std::size_t part = 0; part <= body.partCount(); ++part) {
    if (nameOf(body, static_cast<PartId>(part)) == name) return true;
  }
  return false;
}

bool hasGeometry(const CycleReport& report) {
  return report.options.geometry && report.result != nullptr &&
         report.result->geometry.size() == report.result->contacts.size();
}

void noteRejected(CycleReport* report) {
  // To count them takes a pass over all triangles, so it is done only where there are any.
  if (report->result->counters.rejected == 0) return;
  const std::vector<RejectedTriangles> rejected = rejectedTriangles(*report->scene);
  for (BodyId id = 0; id < report->bodies.size(); ++id) {
    BodyStatus& body = report->bodies[id];
    body.rejected = rejected[id].count;
    body.rejected_by_part.assign(rejected[id].by_part.begin(), rejected[id].by_part.end());
    if (rejected[id].by_pose) body.unknown_because = "its pose makes vertices infinite";
  }
}

std::string stepProblem(const CycleReport& report) {
  for (const SweepReport& sweep : report.sweeps) {
    if (!sweep.problem.empty()) return "of a step: " + sweep.problem;
  }
  return "";
}

bool isOutOfTime(const CycleReport& report) {
  const bool is_interval_cut_off =
      std::any_of(report.sweeps.begin(), report.sweeps.end(), [](const SweepReport& sweep) {
        return sweep.result != nullptr && sweep.result->detection.isOutOfTime();
      });
  return is_interval_cut_off || (report.result != nullptr && report.result->isOutOfTime()) ||
         (report.containment != nullptr && report.containment->cut_off_because == kNoTime);
}

}  // namespace deformable_contact_monitor
