// Who says what touches in the cycles of an evaluation.
#pragma once

#include <memory>
#include <string>

#include "core/analysis/containment.h"
#include "core/detector.h"
#include "core/tiling_cache.h"
#include "monitor/cycle/step_runner.h"
#include "monitor/cycle_report.h"

namespace deformable_contact_monitor {

// A detector, or the records of one.
class ContactSource {
 public:
  ContactSource() = default;
  ContactSource(const ContactSource&) = delete;
  ContactSource& operator=(const ContactSource&) = delete;
  virtual ~ContactSource() = default;

  // As Detector::backend(): of what ran.
  virtual std::string backend() const = 0;

  // Sets what a detection finds: the report's result and containment, and its steps' results,
  // problems, times and rejected triangles. The options are set already, the rest is as BagCycles
  // made it; `scene` is the report's. What it points to is valid until the next call.
  virtual void find(Scene* scene, CycleReport* cycle) = 0;
};

class DetectedContacts : public ContactSource {
 public:
  // looks_within: for what is within what. swept_tolerance_m: of links' ways, as StepRunner takes
  // it. tilings: those that the detector is bounded by, made before each cycle; null: it is exact.
  explicit DetectedContacts(std::unique_ptr<Detector> detector, bool looks_within = false,
                            double swept_tolerance_m = 0,
                            std::shared_ptr<TilingCache> tilings = nullptr);

  std::string backend() const override { return detector_->backend(); }
  void find(Scene* scene, CycleReport* cycle) override;

 private:
  const std::unique_ptr<Detector> detector_;
  const bool looks_within_;
  const double swept_tolerance_m_;
  const std::shared_ptr<TilingCache> tilings_;
  ContainmentFinder containment_;
  StepRunner steps_;
};

}  // namespace deformable_contact_monitor
