// Tests which backend each name selects. The requested device never exists, so machines with and
// without a GPU give the same results.
#include "cuda/detector_choice.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "core/cpu_detector.h"
#include "cuda/cuda_detector.h"
#include "cuda/device/cuda_error.h"
#include "pair_sets.h"
#include "scenes.h"
#include "test_data.h"

namespace deformable_contact_monitor {
namespace {

CudaSettings noSuchDevice() {
  CudaSettings settings;
  settings.device = 1000000;
  return settings;
}

constexpr WithoutCuda kAnswers[] = {WithoutCuda::kTryAgain, WithoutCuda::kFallBack,
                                    WithoutCuda::kRefuse};

struct Made {
  std::unique_ptr<Detector> detector;
  std::vector<std::string> reasons;  // for which the CPU took over
  std::vector<BackendFault> faults;
};

// The settings go before the detector does: what is made later must not need them.
Made make(BackendChoice choice, WithoutCuda without_cuda) {
  Made made;
  made.detector =
      makeDetector(choice, without_cuda, noSuchDevice(), [&made](const BackendState& state) {
        made.reasons.push_back(state.problem);
        made.faults.push_back(state.fault);
      });
  return made;
}

std::string whyNotCuda() {
  try {
    makeCudaDetector(noSuchDevice());
  } catch (const CudaError& error) {
    return error.what();
  }
  return "no CudaError";
}

TEST(DetectorChoice, NamesReadBack) {
  for (const char* name : {"auto", "cuda", "cpu"}) {
    EXPECT_STREQ(toString(toBackendChoice(name)), name);
  }
  for (const char* name : {"", "gpu", "CUDA", "fcl"}) {
    EXPECT_THROW(toBackendChoice(name), std::invalid_argument) << name;
  }
}

TEST(DetectorChoice, CpuAsksForNoCuda) {
  for (const WithoutCuda without_cuda : kAnswers) {
    const Made made = make(BackendChoice::kCpu, without_cuda);
    EXPECT_EQ(made.detector->backend(), "cpu");
    EXPECT_TRUE(made.reasons.empty());
  }
}

TEST(DetectorChoice, AutoFallsBackAndSaysWhyOnce) {
  for (const WithoutCuda without_cuda : kAnswers) {
    const Made made = make(BackendChoice::kAuto, without_cuda);
    EXPECT_EQ(made.detector->backend(), "cpu");
    EXPECT_EQ(made.reasons, std::vector<std::string>{whyNotCuda()});
    EXPECT_EQ(made.faults, std::vector<BackendFault>{BackendFault::kUnavailable});
  }
}

TEST(DetectorChoice, OfSeveralDevicesThoseThatAreThereDo) {
  std::vector<BackendState> told;
  const auto note = [&told](const BackendState& state) { told.push_back(state); };
  CudaSettings settings = noSuchDevice();
  settings.devices = {1000000, 1000001};
  const auto nowhere = makeDetector(BackendChoice::kCuda, WithoutCuda::kTryAgain, settings, note);
  EXPECT_EQ(nowhere->backend(), "cpu");
  ASSERT_EQ(told.size(), 1U);
  EXPECT_FALSE(told[0].partly);

  settings.devices = {1000000, 0};
  told.clear();
  const auto detector = makeDetector(BackendChoice::kCuda, WithoutCuda::kTryAgain, settings, note);
  if (detector->backend() != "cuda") {
    EXPECT_FALSE(isCudaRequired());
    return;
  }
  Scene scene = pairScene(clothGrid(4, 1, 0, 0.2F), clothGrid(4, 1, 0.05F, 0));
  for (int i = 0; i < 2; ++i) {  // the second set of pairs has detectors of its own
    scene.setPairEnabled(0, 0, i == 1);
    EXPECT_TRUE(
        samePairs(makeCpuDetector()->detect(scene).contacts, detector->detect(scene).contacts));
  }
  ASSERT_EQ(told.size(), 1U);
  EXPECT_TRUE(told[0].partly);
  EXPECT_EQ(told[0].problem.find("CUDA device 1000000: "), 0U) << told[0].problem;
}

TEST(DetectorChoice, CudaFallsBackOnlyWhereThatIsAllowed) {
  for (const WithoutCuda without_cuda : {WithoutCuda::kTryAgain, WithoutCuda::kFallBack}) {
    const Made made = make(BackendChoice::kCuda, without_cuda);
    EXPECT_EQ(made.detector->backend(), "cpu");
    EXPECT_EQ(made.reasons, std::vector<std::string>{whyNotCuda()});
  }
  EXPECT_THROW(make(BackendChoice::kCuda, WithoutCuda::kRefuse), CudaError);
}

TEST(DetectorChoice, WhatTookOverDetects) {
  const Made made = make(BackendChoice::kAuto, WithoutCuda::kFallBack);
  const Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  EXPECT_FALSE(made.detector->detect(scene, Options()).contacts.empty());
  EXPECT_EQ(made.reasons.size(), 1U);
}

TEST(DetectorChoice, StatesAreCheckedOnTheCpuWhereCudaIsMissing) {
  const Scene scene = pairScene(clothGrid(2, 1, 0, 0), clothGrid(2, 1, 0, 0));
  const RigidTransform pose;
  for (const WithoutCuda answer : {WithoutCuda::kTryAgain, WithoutCuda::kFallBack}) {
    std::vector<std::string> reasons;
    const auto checker =
        makeStateChecker(BackendChoice::kCuda, answer, noSuchDevice(),
                         [&reasons](const BackendState& s) { reasons.push_back(s.problem); });
    EXPECT_EQ("cpu", checker->backend());
    EXPECT_EQ(std::vector<std::string>{whyNotCuda()}, reasons);
    EXPECT_EQ(PairDecision::kContact,
              checker->check(scene, {{0}, 1, &pose}, {}).states[0].decision);
  }
  EXPECT_EQ("cpu", makeStateChecker(BackendChoice::kCpu)->backend());
  EXPECT_THROW(makeStateChecker(BackendChoice::kCuda, WithoutCuda::kRefuse, noSuchDevice()),
               CudaError);
}

// By default nobody is told, cuda by name is CUDA or an error, and there are contacts all the same.
TEST(DetectorChoice, DefaultsDoWithoutCuda) {
  const Scene scene = pairScene(clothGrid(4, 1, 0, 0.2F), clothGrid(4, 1, 0.05F, 0));
  const auto expected = makeCpuDetector()->detect(scene).contacts;
  EXPECT_FALSE(expected.empty());
  EXPECT_TRUE(samePairs(expected, makeDetector()->detect(scene).contacts));
  for (const WithoutCuda answer : kAnswers) {
    const auto detector = makeDetector(BackendChoice::kAuto, answer, noSuchDevice());
    EXPECT_TRUE(samePairs(expected, detector->detect(scene).contacts));
    EXPECT_EQ(detector->backend(), "cpu");
  }
  std::string why;
  try {
    makeDetector(BackendChoice::kCuda)->detect(scene);
  } catch (const BackendError& error) {
    why = error.what();
  }
  try {
    makeCudaDetector();
    EXPECT_EQ(why, "");
  } catch (const BackendError& error) {
    EXPECT_EQ(why, error.what());
  }
}

}  // namespace
}  // namespace deformable_contact_monitor
