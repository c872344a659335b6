// SPDX-License-Identifier: MIT
#include "turnscale/report/report_data.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/error.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/report/report_page.h"

namespace turnscale {
namespace {

ReportData DriveData(int frames) {
  ReportData data;
  data.title = "drive </script>";
  data.metric = true;
  for (int i = 0; i < frames; ++i) {
    FrameResult frame;
    frame.frame = i;
    frame.time = 0.1 * i;
    frame.state = i % 100 == 50 ? TrackingState::kBridged : TrackingState::kTracked;
    frame.scale_state = i < 10 ? ScaleState::kObserved : ScaleState::kHeld;
    frame.scale_sigma = 0.02;
    const double heading = 0.001 * i;
    frame.world_from_camera = RigidTransform{RotationFromVector({0, heading, 0}),
                                             {1000 * (1 - std::cos(heading)), 0, 1000 * std::sin(heading)}};
    data.frames.push_back(frame);
    if (i > 0) data.speeds.push_back({frame.time, 10, 0.2});
  }
  return data;
}

nlohmann::json Parsed(const ReportData& data, const ReportLimits& limits = {}) {
  return nlohmann::json::parse(ReportJson(data, limits));
}

TEST(ReportData, PositionsAreRightAheadUp) {
  ReportData data = DriveData(1500);
  data.landmarks = {{5, -1.5F, 20}, {1e6F, 0, 0}};
  const nlohmann::json json = Parsed(data);
  const auto& path = json["path"];
  ASSERT_EQ(path["time"].size(), 1500u);
  EXPECT_NEAR(path["x"][1000].get<double>(), 1000 * (1 - std::cos(1.0)), 0.01);
  EXPECT_NEAR(path["y"][1000].get<double>(), 1000 * std::sin(1.0), 0.01);
  EXPECT_EQ(path["z"][1000], 0);
  EXPECT_TRUE(path["speed"][0].is_null());
  EXPECT_EQ(path["speed"][1], 10);
  EXPECT_EQ(path["scaleState"].get<std::string>().substr(8, 4), "oohh");
  EXPECT_EQ(path["tracking"].get<std::string>().substr(49, 3), "tbt");
  EXPECT_EQ(json["unit"], "m");
  // One landmark is near enough to be shown: three numbers of two bytes.
  EXPECT_EQ(json["landmarks"]["data"].get<std::string>().size(), 8u);
  EXPECT_TRUE(json["truth"].is_null());
}

// The nose keeps its direction where the car backs.
TEST(ReportData, HeadingsAreThoseOfTheCar) {
  ReportData data = DriveData(0);
  // A camera that looks to the left of a car that backs to the right.
  data.vehicle_from_body = RotationFromVector({0, -M_PI / 2, 0});
  for (int i = 0; i < 50; ++i) {
    FrameResult frame;
    frame.frame = i;
    frame.time = 0.1 * i;
    const double heading = 0.5 - 0.01 * i;
    frame.world_from_camera = RigidTransform{RotationFromVector({0, heading - M_PI / 2, 0}),
                                             {-0.2 * i * std::sin(heading), 0, -0.2 * i * std::cos(heading)}};
    data.frames.push_back(frame);
  }
  const auto path = Parsed(data)["path"];
  EXPECT_EQ(path["heading"][0], 0);
  EXPECT_NEAR(path["heading"][40].get<double>(), -0.4 * kDegreesPerRadian, 0.51);
  EXPECT_LT(path["y"][10].get<double>(), -1);
  EXPECT_EQ(path["driven"][0], 0);
  EXPECT_NEAR(path["driven"][40].get<double>(), 8, 0.2);
}

TEST(ReportData, NamesOnlyTheLastFolder) {
  EXPECT_EQ(ShortPath("/home/somebody/drives/monday.mp4"), "drives/monday.mp4");
  EXPECT_EQ(ShortPath("/home/somebody/monday/drive/"), "monday/drive");
  EXPECT_EQ(ShortPath("../monday.mp4"), "monday.mp4");
  EXPECT_EQ(ShortPath("/monday.mp4"), "monday.mp4");
  EXPECT_EQ(ShortPath("monday.mp4"), "monday.mp4");
  EXPECT_EQ(ShortPath(""), "");
  EXPECT_EQ(ShortPath("/"), "/");
  ReportData data = DriveData(3);
  data.title = "/home/somebody/monday/drive";
  EXPECT_EQ(ReportJson(data).find("somebody"), std::string::npos);
}

TEST(ReportData, LongDrivesAreThinned) {
  ReportData data = DriveData(40000);
  for (int i = 0; i < 300000; ++i)
    data.landmarks.emplace_back(static_cast<float>(i % 997), -1.0F, static_cast<float>(i % 1009));
  for (int i = 0; i < 9000; ++i) data.scale.push_back({4 * i, 0.4 * i, 0.25, 0.02});
  const std::string text = ReportJson(data);
  EXPECT_LT(text.size(), 1'250'000u);
  EXPECT_EQ(text.find('<'), std::string::npos) << "could end the element that holds the data";
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["path"]["time"].back(), 3999.9);
  EXPECT_EQ(json["title"], "drive </script>");
  EXPECT_LE(json["scale"]["time"].size(), 2001u);
}

// Every second image is a duplicate, or every second one is lost.
TEST(ReportData, FramesThatAlternateAreThinned) {
  for (const TrackingState other : {TrackingState::kRepeated, TrackingState::kBridged}) {
    ReportData data = DriveData(40000);
    for (size_t i = 0; i < data.frames.size(); ++i) data.frames[i].state = i % 2 == 0 ? TrackingState::kTracked : other;
    const nlohmann::json path = Parsed(data)["path"];
    EXPECT_LE(path["time"].size(), 8000u) << static_cast<int>(other);
    // Those that are kept are of the whole drive.
    EXPECT_NEAR(path["time"][path["time"].size() / 2].get<double>(), 2000, 200) << static_cast<int>(other);
  }
}

TEST(ReportData, WhereTrackingIsLostIsKept) {
  ReportData data = DriveData(40000);
  for (FrameResult& frame : data.frames) frame.state = TrackingState::kTracked;
  data.frames[20001].state = TrackingState::kUnreadable;
  const nlohmann::json path = Parsed(data, {.path_points = 100})["path"];
  const auto at = path["tracking"].get<std::string>().find('u');
  ASSERT_NE(at, std::string::npos);
  EXPECT_EQ(path["frame"][at], 20001);
  EXPECT_EQ(path["frame"][at - 1], 20000);
  EXPECT_EQ(path["frame"][at + 1], 20002);
}

// Seconds since 1970: the page counts from the first frame.
TEST(ReportData, TimesOfAClockBeginAtTheFirstFrame) {
  constexpr double kStart = 1774160045.25;
  ReportData data = DriveData(50);
  for (FrameResult& frame : data.frames) frame.time += kStart;
  for (SpeedReading& reading : data.speeds) reading.time += kStart;
  TurnResult turn;
  turn.first_frame = 10;
  turn.last_frame = 20;
  data.turns = {turn};
  data.scale = {{0, kStart, 0.25, 0.02}};
  data.rotations = {{0, kStart, {}, {}}};
  data.thumbnails = {{30, kStart + 3, ThumbnailReason::kDrive, "x"}};
  for (int i = 0; i < 50; ++i)
    data.truth.push_back(
        {i, i, data.frames[i].time, *data.frames[i].world_from_camera, *data.frames[i].world_from_camera});
  const nlohmann::json json = Parsed(data);
  EXPECT_EQ(json["timeOrigin"], kStart);
  EXPECT_EQ(json["path"]["time"][0], 0);
  EXPECT_EQ(json["path"]["time"][49], 4.9);
  EXPECT_EQ(json["path"]["speed"][49], 10);
  EXPECT_EQ(json["turns"][0]["from"], 1);
  EXPECT_EQ(json["scale"]["time"][0], 0);
  EXPECT_EQ(json["rotation"]["time"][1], 4.9);
  EXPECT_EQ(json["thumbnails"][0]["time"], 3);
  EXPECT_EQ(json["truth"]["time"][49], 4.9);
  EXPECT_EQ(TimeOrigin(DriveData(50).frames), 0);
}

TEST(ReportData, PosesAlone) {
  ReportData data = DriveData(20);
  data.timed = false;
  data.has_tracking = false;
  data.has_scale_state = false;
  const nlohmann::json json = Parsed(data);
  EXPECT_EQ(json["timed"], false);
  EXPECT_EQ(json["path"]["tracking"], "");
  EXPECT_EQ(json["path"]["scaleState"], "");
}

TEST(ReportData, TheTruthIsLaidOnTheFirstPose) {
  ReportData data = DriveData(200);
  const RigidTransform elsewhere{RotationFromVector({0.1, 0.5, 0}), {7, 8, 9}};
  for (int i = 0; i < 200; ++i) {
    const RigidTransform& estimate = *data.frames[i].world_from_camera;
    RigidTransform truth = estimate;
    truth.translation.x() += i == 0 ? 0 : 0.5;
    data.truth.push_back({i, i, data.frames[i].time, estimate, elsewhere * truth});
  }
  const auto json = Parsed(data)["truth"];
  EXPECT_EQ(json["error"][0], 0);
  EXPECT_NEAR(json["error"][100].get<double>(), 0.5, 1e-3);
}

// Its scale is arbitrary: only its shape can be compared.
TEST(ReportData, TheTruthIsScaledToAPathWithoutMetres) {
  ReportData data = DriveData(200);
  data.metric = false;
  const RigidTransform elsewhere{RotationFromVector({0.1, 0.5, 0}), {7, 8, 9}};
  for (int i = 0; i < 200; ++i) {
    RigidTransform& estimate = *data.frames[i].world_from_camera;
    RigidTransform truth = elsewhere * estimate;
    estimate.translation *= 0.1;
    // One pose is wrong by a metre, upwards.
    if (i == 100) estimate.translation.y() -= 0.1;
    data.truth.push_back({i, i, data.frames[i].time, estimate, truth});
  }
  const auto json = Parsed(data);
  EXPECT_NEAR(json["truth"]["metresPerUnit"].get<double>(), 10, 0.01);
  EXPECT_NEAR(json["truth"]["error"][100].get<double>(), 1, 0.02) << "metres";
  EXPECT_NEAR(json["truth"]["error"][50].get<double>(), 0, 0.02);
  EXPECT_NEAR(json["truth"]["y"][199].get<double>(), json["path"]["y"][199].get<double>(), 0.02) << "in units";
}

TEST(ReportData, TheTruthIsScaledToAStraightPathToo) {
  ReportData data;
  for (int i = 0; i < 20; ++i) {
    FrameResult frame;
    frame.frame = i;
    frame.time = i;
    frame.world_from_camera = RigidTransform{Eigen::Quaterniond::Identity(), {0, 0, 0.5 * i}};
    data.frames.push_back(frame);
    data.truth.push_back(
        {i, i, frame.time, *frame.world_from_camera, {Eigen::Quaterniond::Identity(), {3, 0, 4.0 * i}}});
  }
  const auto truth = Parsed(data)["truth"];
  EXPECT_NEAR(truth["metresPerUnit"].get<double>(), 8, 1e-9);
  for (const auto& error : truth["error"]) EXPECT_NEAR(error.get<double>(), 0, 1e-9);
}

TEST(ReportData, TheTruthOfAnEarlierPageIsKept) {
  ReportData data = DriveData(50);
  for (int i = 0; i < 50; ++i)
    data.truth.push_back(
        {i, i, data.frames[i].time, *data.frames[i].world_from_camera, *data.frames[i].world_from_camera});
  data.errors = {{"Path length error", "0.10 %", ""}};
  data.outlines = {{{0, 0}, {1, 0}, {1, 1}}};
  const std::string before = ReportJson(data);
  ReportData again = DriveData(50);
  again.earlier = before;
  EXPECT_EQ(ReportJson(again), before);
  // Another truth takes its place; what is no data has none.
  data.errors = {{"Path length error", "0.20 %", ""}};
  data.earlier = before;
  EXPECT_EQ(Parsed(data)["errors"][0]["value"], "0.20 %");
  again.earlier = "{";
  EXPECT_TRUE(Parsed(again)["truth"].is_null());
}

TEST(ReportData, APathWithoutPosesIsAnEmptyPage) {
  ReportData data;
  EXPECT_TRUE(Parsed(data)["path"]["time"].empty());
  data.frames.resize(3);
  EXPECT_TRUE(Parsed(data)["path"]["time"].empty());
}

TEST(ReportPage, HoldsItsData) {
  const std::string json = ReportJson(DriveData(20));
  const std::string page = ReportPage("a & b", json);
  EXPECT_EQ(DataOfPage(page, "page"), json);
  EXPECT_NE(page.find("<title>a &amp; b - turnscale</title>"), std::string::npos);
  EXPECT_TRUE(DataOfPage(ReportPage("live", ""), "page").empty());
  EXPECT_THROW(DataOfPage("<html></html>", "page"), InputError);
}

TEST(ReportPage, RefersToNoOtherFile) {
  const std::string page = ReportPage("page", "{}");
  for (const char* loaded : {"<script src", "<link rel=\"stylesheet\"", "@import", "url(http", "src=\"http"})
    EXPECT_EQ(page.find(loaded), std::string::npos) << loaded;
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

}  // namespace
}  // namespace turnscale
