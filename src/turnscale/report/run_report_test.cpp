// SPDX-License-Identifier: MIT
#include "turnscale/report/run_report.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/report/report_page.h"
#include "turnscale/run/run_summary.h"
#include "turnscale/run/run_writer.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

const std::vector<SpeedReading> kSpeeds = {{0, 10, 0.5}, {2.9, 12.5, 0.25}};

class RunReportTest : public ::testing::Test {
 protected:
  RunReportTest() : folder_(ScratchPath("report")) {}
  ~RunReportTest() override { fs::remove_all(folder_); }

  // `warnings`: those before the drive's own.
  void WriteRun(ScaleState state, const DriveFacts& drive = {}, const std::vector<SpeedReading>& speeds = kSpeeds,
                const std::vector<std::string>& warnings = {}) const {
    std::vector<FrameResult> frames(30);
    for (int i = 0; i < 30; ++i) {
      frames[i].frame = i;
      frames[i].time = 0.1 * i;
      frames[i].state = i > 20 && i < 25 ? TrackingState::kBridged : TrackingState::kTracked;
      frames[i].world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, 1.0 * i}};
      frames[i].scale_state = state;
      frames[i].scale_sigma = 0.02;
    }
    RefinedScale scale;
    if (state != ScaleState::kPending) {
      scale.keyframes.emplace_back().state = state;
      scale.estimate.emplace().converged = true;
      scale.estimate->length_sigma = 0.034;
    }
    scale.reason = "no turn was found";
    RunSummary summary = SummaryOf(drive, frames, scale);
    summary.warnings.insert(summary.warnings.begin(), warnings.begin(), warnings.end());
    RunWriter writer({folder_});
    writer.WriteTrajectory(frames, Eigen::Quaterniond::Identity(), state);
    writer.WriteTurns({});
    if (state != ScaleState::kPending) writer.WriteSpeeds(speeds);
    writer.WriteText("summary.json", SummaryJson(summary));
  }

  nlohmann::json Data() const { return nlohmann::json::parse(DataOfPage(TextOf(folder_ / kReportFile), "page")); }

  fs::path folder_;
};

TEST_F(RunReportTest, SaysWhatTheSummarySays) {
  DriveFacts drive;
  drive.given.input = "drives/monday.mp4";
  drive.vehicle.lever_arm = 1.5;
  WriteRun(ScaleState::kHeld, drive, kSpeeds, {"the camera's <calibration> differs"});
  WriteRunReport(folder_);
  const nlohmann::json data = Data();
  EXPECT_EQ(data["title"], "drives/monday.mp4");
  EXPECT_EQ(data["facts"][0]["value"], "29.0 \u00b11.0 m");
  EXPECT_EQ(data["facts"][0]["note"], "\u00b13.4 % (1 sigma)");
  EXPECT_EQ(data["facts"][2]["value"], "45.0 km/h");
  EXPECT_EQ(data["facts"][2]["note"], "\u00b10.9 km/h, at 0:02.9");
  ASSERT_EQ(data["warnings"].size(), 2u);
  EXPECT_EQ(data["warnings"][0], "the camera's <calibration> differs");
  EXPECT_EQ(data["warnings"][1].get<std::string>().find(
                "The path is not measured for 0.4 s of 2.9 s: tracking lost from 0:0"),
            0u)
      << data["warnings"][1];
  const std::string page = TextOf(folder_ / kReportFile);
  WriteRunReport(folder_);
  EXPECT_EQ(TextOf(folder_ / kReportFile), page) << "the same results give the same page";
}

TEST_F(RunReportTest, CountsFromTheFirstFrameOfTheDrive) {
  DriveFacts drive;
  drive.given.first_time = -60;
  WriteRun(ScaleState::kHeld, drive);
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["timeOrigin"], -60);
  EXPECT_EQ(Data()["facts"][2]["note"], "\u00b10.9 km/h, at 1:02.9");
  nlohmann::json earlier = nlohmann::json::parse(TextOf(folder_ / "summary.json"));
  earlier.erase("first_frame_s");
  std::ofstream(folder_ / "summary.json") << earlier;
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["timeOrigin"], 0);
}

TEST_F(RunReportTest, ADriveInReverseHasATopSpeed) {
  WriteRun(ScaleState::kHeld, {}, {{0, 0, 0.5}, {1, -2.5, 0.25}, {2.9, -1, 0.25}});
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["facts"][2]["value"], "9.0 km/h");
  EXPECT_EQ(Data()["facts"][2]["note"], "\u00b10.9 km/h, in reverse, at 0:01.0");
}

TEST_F(RunReportTest, TheLargestSigmaIsGivenWhereItSaysMoreThanThatOfThePath) {
  WriteRun(ScaleState::kHeld);
  nlohmann::json json = nlohmann::json::parse(TextOf(folder_ / "summary.json"));
  for (const auto& [largest, shown] : {std::pair(0.035, false), std::pair(0.07, true)}) {
    json["scale"]["worst_relative_sigma"] = largest;
    json["scale"]["worst_at_s"] = 2.9;
    std::ofstream(folder_ / "summary.json") << json;
    WriteRunReport(folder_);
    EXPECT_EQ(Data()["facts"].dump().find("Largest uncertainty") != std::string::npos, shown) << largest;
  }
}

TEST_F(RunReportTest, ASigmaBeyondTheValueItselfIsNotANumber) {
  WriteRun(ScaleState::kHeld);
  nlohmann::json json = nlohmann::json::parse(TextOf(folder_ / "summary.json"));
  json["path_sigma"] = 6.6;
  std::ofstream(folder_ / "summary.json") << json;
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["facts"][0]["value"], "29.0 m");
  EXPECT_EQ(Data()["facts"][0]["note"], "beyond \u00b1100 % (1 sigma)");
}

TEST_F(RunReportTest, APathUpToScaleSaysWhy) {
  WriteRun(ScaleState::kPending);
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["unit"], "units");
  EXPECT_EQ(Data()["warnings"][0], "The path is not in metres: no lever arm was given (--lever-arm)");
  DriveFacts with_arm;
  with_arm.vehicle.lever_arm = 1.5;
  DriveFacts with_height;
  with_height.vehicle.camera_height = 1.3;
  for (const DriveFacts& drive : {with_arm, with_height}) {
    WriteRun(ScaleState::kPending, drive);
    WriteRunReport(folder_);
    EXPECT_EQ(Data()["warnings"][0], "The path is not in metres: no turn was found");
  }
}

TEST_F(RunReportTest, NeedsResults) {
  fs::create_directories(folder_);
  EXPECT_THROW(WriteRunReport(folder_), InputError);
}

// Of a version, or a failed run, that has written hardly anything.
TEST_F(RunReportTest, WhatIsNotKnownIsLeftOut) {
  DriveFacts drive;
  drive.vehicle.lever_arm = 1.5;
  WriteRun(ScaleState::kHeld, drive);
  nlohmann::json json = nlohmann::json::parse(TextOf(folder_ / "summary.json"));
  for (const char* name : {"path_sigma", "scale", "turns", "frames", "missing", "by_all_turns"}) json.erase(name);
  std::ofstream(folder_ / "summary.json") << json;
  std::ofstream(folder_ / "speed.csv") << "time,speed_mps,sigma_mps\n0,10,nan\n";
  WriteRunReport(folder_);
  const std::string facts = Data()["facts"].dump();
  EXPECT_EQ(facts.find("nan"), std::string::npos) << facts;
  EXPECT_EQ(facts.find("inf"), std::string::npos) << facts;
  EXPECT_NE(facts.find("29.0 m"), std::string::npos) << facts;
}

TEST_F(RunReportTest, KeepsTheTruthOfAnEarlierPage) {
  WriteRun(ScaleState::kHeld);
  const RigidTransform pose;
  const RunReportExtras extras = {
      {{0, 0, 0, pose, pose}, {29, 29, 2.9, pose, pose}}, R"({"as_given": {"path_length_error_percent": -1.5}})", {}};
  WriteRunReport(folder_, extras);
  WriteRunReport(folder_);
  EXPECT_EQ(Data()["errors"][0]["value"], "-1.50 %");
  EXPECT_EQ(Data()["truth"]["time"].size(), 2u);
  std::ofstream(folder_ / kReportFile) << "something else";
  WriteRunReport(folder_);
  EXPECT_TRUE(Data()["truth"].is_null());
}

TEST(ErrorFacts, OfAPathWithoutMetresLeaveItsLengthOut) {
  const std::vector<ReportFact> facts = ErrorFacts(
      R"({"true_path_length_m": 100.0, "as_given": {"path_length_error_percent": -95, "kitti": {"translation_percent": 95}},
          "rescaled": {"kitti": {"translation_percent": 0.5}}, "position_error": {"sim3": {"scale": 20.0, "rmse_m": 0.25}}})",
      false);
  ASSERT_EQ(facts.size(), 4u);
  EXPECT_EQ(facts[1].value, "20");
  EXPECT_EQ(facts[2].value, "0.50 %");
  EXPECT_EQ(facts[3].value, "0.25 m");
}

TEST(ErrorFacts, NamesWhatThereIs) {
  const std::vector<ReportFact> facts = ErrorFacts(
      R"({"true_path_length_m": 100.0, "as_given": {"path_length_error_percent": -1.5}, "position_error": {"sim3": null}})");
  ASSERT_EQ(facts.size(), 1u);
  EXPECT_EQ(facts[0].value, "-1.50 %");
  EXPECT_EQ(facts[0].note, "98.5 m, true 100.0 m");
}

}  // namespace
}  // namespace turnscale
