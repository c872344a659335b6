// SPDX-License-Identifier: MIT
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <signal.h>
#include <sys/stat.h>

#include "command_line.h"
#include "rendered_room.h"
#include "turnscale/base/test_files.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/frames/test_video.h"
#include "turnscale/io/trajectory_file.h"
#include "turnscale/run/settings.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kRoomFrames = 20;

class ErrorsTest : public ::testing::Test {
 protected:
  ErrorsTest() : folder_(ScratchPath("folder")) {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    WriteRoomDrive(Drive(), kRoomFrames);
  }
  ~ErrorsTest() override { fs::remove_all(folder_); }

  fs::path Drive() const { return folder_ / "drive"; }
  fs::path Out() const { return folder_ / "out"; }
  fs::path Image(int number) const {
    return Drive() / "image_0" /
           (number < 10 ? "00000" + std::to_string(number) : "0000" + std::to_string(number)).append(".png");
  }

  fs::path Text(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  std::vector<std::string> Arguments(std::vector<std::string> more) const {
    more.insert(more.begin(), {"run", Drive().string(), "--out", Out().string()});
    return more;
  }

  CommandResult Run(const std::vector<std::string>& more = {}) const { return RunCommand(Arguments(more), folder_); }

  // The drive's images as a video; gives the size of the file.
  uintmax_t Video(const fs::path& path, int first = 0, int last = kRoomFrames, double pixel_aspect = 1) const {
    std::vector<cv::Mat> images;
    for (int i = first; i < last; ++i) images.push_back(cv::imread(Image(i).string(), cv::IMREAD_GRAYSCALE));
    WriteTestVideo(path, images, {.codec = "mjpeg", .ticks_per_second = 10, .pixel_aspect = pixel_aspect});
    return fs::file_size(path);
  }

  nlohmann::json Summary() const { return nlohmann::json::parse(TextOf(Out() / "summary.json")); }

  fs::path folder_;
};

TEST_F(ErrorsTest, GoodDriveSucceeds) {
  const CommandResult result = Run({"--lever-arm", "1.5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.Complaints().empty()) << result.err;
  EXPECT_NE(result.out.find("files   " + Out().string()), std::string::npos) << result.out;
  EXPECT_EQ(Summary()["frames"]["total"], kRoomFrames);
  for (const char* name : {"trajectory.tum", "trajectory.kitti.txt", "live.tum", "trajectory.csv", "turns.csv",
                           "map.ply", "settings.yaml", "summary.json", "report.html"}) {
    EXPECT_TRUE(fs::exists(Out() / name)) << name;
  }
}

TEST_F(ErrorsTest, QuietPrintsNothing) {
  const CommandResult result = Run({"--quiet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out + result.err, "");
}

TEST_F(ErrorsTest, RotatedImagesBringTheirCalibration) {
  ASSERT_EQ(Run({"--quiet", "--no-report"}).exit_code, 0);
  const std::string plain = TextOf(Out() / "trajectory.tum");
  CameraModel camera = ReadCameraFile(Drive() / "calib.txt");
  for (int i = 0; i < kRoomFrames; ++i) {
    cv::Mat image;
    cv::rotate(cv::imread(Image(i).string(), cv::IMREAD_GRAYSCALE), image, cv::ROTATE_180);
    cv::imwrite(Image(i).string(), image);
    camera.width = image.cols;
    camera.height = image.rows;
  }
  const Pinhole& pinhole = camera.pinhole;
  std::ofstream(Drive() / "calib.txt") << "P0: " << pinhole.fx << " 0 " << camera.width - 1 - pinhole.cx << " 0 0 "
                                       << pinhole.fy << " " << camera.height - 1 - pinhole.cy << " 0 0 0 1 0\n";
  ASSERT_EQ(Run({"--quiet", "--no-report", "--rotate", "180"}).exit_code, 0);
  EXPECT_EQ(TextOf(Out() / "trajectory.tum"), plain);
  EXPECT_EQ(Summary()["rotate_deg"], 180);
  ExpectComplaint(Run({"--rotate", "45"}), 2, {"--rotate 45", "90, 180 or 270"});
}

TEST_F(ErrorsTest, WithoutLeverArmTheRunSaysItIsUpToScale) {
  EXPECT_NE(Run().out.find("without --lever-arm, --camera-height or --vehicle the trajectory is up to scale"),
            std::string::npos);
}

TEST_F(ErrorsTest, AFileOfACarWithoutALengthIsNamed) {
  const std::string car = Text("c.yaml", "yaw_deg: 0\npitch_deg: 0\nroll_deg: 0\n").string();
  const std::string why =
      "the trajectory is up to scale: " + car + " has neither lever arm nor height; give --lever-arm";
  EXPECT_NE(Run({"--vehicle", car}).out.find("scale   pending, " + why), std::string::npos);
  EXPECT_NE(Run({"--vehicle", car, "--quiet"}).err.find("warning: " + why), std::string::npos);
}

TEST_F(ErrorsTest, SettingsAreThoseInEffect) {
  ASSERT_EQ(Run({"--quiet"}).exit_code, 0);
  EXPECT_TRUE(ReadSettings(Out() / "settings.yaml").odometry.lens.enabled);
  EXPECT_GT(Summary()["lens"]["sigma"], 0);
  const std::string fisheye = Text("fisheye.yaml",
                                   "cam0:\n  camera_model: pinhole\n  intrinsics: [200, 200, 159.5, 119.5]\n"
                                   "  resolution: [320, 240]\n  distortion_model: equidistant\n"
                                   "  distortion_coeffs: [0, 0, 0, 0]\n")
                                  .string();
  ASSERT_EQ(Run({"--quiet", "--camera", fisheye}).exit_code, 0);
  EXPECT_FALSE(ReadSettings(Out() / "settings.yaml").odometry.lens.enabled) << "a fisheye has no radial correction";
  EXPECT_TRUE(Summary()["lens"].is_null());
}

TEST_F(ErrorsTest, NamesThatAreNoUtf8) {
  const fs::path renamed = folder_ / "caf\xe9";
  fs::rename(Drive(), renamed);
  const CommandResult result = RunCommand({"run", renamed.string(), "--out", Out().string(), "--quiet"}, folder_);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(Summary()["input"].get<std::string>().ends_with("caf\xef\xbf\xbd"));
}

TEST_F(ErrorsTest, MissingAndEmptyFolders) {
  ExpectComplaint(RunCommand({"run", (folder_ / "nowhere").string()}, folder_), 2, {"nowhere: no such file or folder"});
  fs::create_directories(folder_ / "empty");
  ExpectComplaint(RunCommand({"run", (folder_ / "empty").string()}, folder_), 2, {"empty: holds no images"});
}

TEST_F(ErrorsTest, BrokenVideo) {
  const std::string video = Text("drive.mp4", "this is no video").string();
  const std::string camera = (Drive() / "calib.txt").string();
  ExpectComplaint(RunCommand({"run", video, "--camera", camera}, folder_), 2,
                  {"drive.mp4: is not a video, or is damaged"});
}

TEST_F(ErrorsTest, AVideoThatEndsFarTooEarlyIsIncomplete) {
  const fs::path video = folder_ / "drive.avi";
  const std::vector<std::string> arguments = {"run",   video.string(), "--camera", (Drive() / "calib.txt").string(),
                                              "--out", Out().string(), "--quiet"};
  fs::resize_file(video, Video(video) * 6 / 10);
  const CommandResult cut = RunCommand(arguments, folder_);
  EXPECT_EQ(cut.exit_code, 0) << cut.err;
  EXPECT_NE(cut.err.find("drive.avi: the video ends after"), std::string::npos) << cut.err;
  EXPECT_FALSE(Summary()["complete"].get<bool>());
  EXPECT_NE(Summary()["stopped"].get<std::string>().find("of 20 frames"), std::string::npos);

  // A frame or two less than the header says: headers may estimate.
  fs::resize_file(video, Video(video) * 93 / 100);
  const CommandResult nearly_whole = RunCommand(arguments, folder_);
  EXPECT_EQ(nearly_whole.exit_code, 0);
  EXPECT_EQ(nearly_whole.err, "");
  EXPECT_LT(Summary()["frames"]["total"], kRoomFrames);
  EXPECT_TRUE(Summary()["complete"].get<bool>());
}

TEST_F(ErrorsTest, ADriveWithoutItsFirstClipIsIncomplete) {
  const fs::path first = folder_ / "1.avi";
  const fs::path second = folder_ / "2.avi";
  std::ofstream(first) << "this is no video";
  Video(second);
  const CommandResult result = RunCommand({"run", first.string(), second.string(), "--camera",
                                           (Drive() / "calib.txt").string(), "--out", Out().string(), "--quiet"},
                                          folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "warning: " + first.string() +
                            ": is not a video, or is damaged; the clip is left out: the beginning of the drive is "
                            "missing, and times count from 2.avi\n");
  EXPECT_FALSE(Summary()["complete"].get<bool>());
  EXPECT_EQ(Summary()["stopped"], "1.avi: cannot be decoded: the beginning of the drive is missing");
}

TEST_F(ErrorsTest, AVideoThatLacksFramesIsComplete) {
  const fs::path video = folder_ / "drive.avi";
  std::vector<cv::Mat> images;
  TestVideo lacking{.codec = "mjpeg", .ticks_per_second = 10};
  for (int i = 0; i < kRoomFrames; ++i) {
    if (i == 6 || i == 11 || i == 15) continue;
    images.push_back(cv::imread(Image(i).string(), cv::IMREAD_GRAYSCALE));
    lacking.stamps.push_back(i);
  }
  WriteTestVideo(video, images, lacking);
  const CommandResult result = RunCommand(
      {"run", video.string(), "--camera", (Drive() / "calib.txt").string(), "--out", Out().string(), "--quiet"},
      folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "warning: drive.avi: 3 of 20 frames are missing or cannot be decoded\n");
  EXPECT_TRUE(Summary()["complete"].get<bool>());
  EXPECT_EQ(Summary()["frames"]["total"], kRoomFrames - 3);
  EXPECT_NEAR(Summary()["clips"][0]["end_s"].get<double>(), 1.9, 1e-9);
}

TEST_F(ErrorsTest, ACalibrationForPixelsOfAnotherShapeIsNamed) {
  const auto err = [&](double pixel_aspect) {
    const fs::path video = folder_ / "drive.mkv";
    Video(video, 0, kRoomFrames, pixel_aspect);
    return RunCommand({"run", video.string(), "--camera", (Drive() / "calib.txt").string(), "--out", Out().string(),
                       "--quiet", "--no-report"},
                      folder_)
        .err;
  };
  EXPECT_EQ(err(1), "");
  EXPECT_NE(err(1.25).find("fy / fx is 1.000, but it is 1.250 by the pixel aspect ratio that the video states"),
            std::string::npos);
}

TEST_F(ErrorsTest, ClipsAreOneDrive) {
  const fs::path clips = folder_ / "DCIM";
  fs::create_directories(clips);
  Video(clips / "20230501_120000.avi", 0, 12);
  Video(clips / "20230501_120001.avi", 12, kRoomFrames);
  fs::copy(Drive() / "calib.txt", clips);
  const auto run = [&](std::vector<std::string> inputs, const std::vector<std::string>& more = {}) {
    inputs.insert(inputs.begin(), "run");
    inputs.insert(inputs.end(), {"--out", Out().string(), "--quiet"});
    inputs.insert(inputs.end(), more.begin(), more.end());
    return RunCommand(inputs, folder_);
  };
  const CommandResult folder = run({clips.string()});
  EXPECT_EQ(folder.exit_code, 0);
  EXPECT_EQ(folder.err, "");
  EXPECT_EQ(Summary()["frames"]["total"], kRoomFrames);
  EXPECT_EQ(Summary()["frames"]["tracked"], kRoomFrames);
  ASSERT_EQ(Summary()["clips"].size(), 2u);
  EXPECT_EQ(Summary()["clips"][1]["frames"], kRoomFrames - 12);
  EXPECT_NEAR(Summary()["clips"][1]["start_s"].get<double>(), 1.2, 1e-9);
  EXPECT_EQ(Summary()["missing"]["seconds"], 0);
  EXPECT_EQ(Summary()["recorded_from"], "2023-05-01T12:00:00");
  const std::string trajectory = TextOf(Out() / "trajectory.tum");

  const std::string first = (clips / "20230501_120000.avi").string();
  const std::string second = (clips / "20230501_120001.avi").string();
  const std::vector<std::string> camera = {"--camera", (clips / "calib.txt").string()};
  EXPECT_EQ(run({first, second}, camera).exit_code, 0);
  EXPECT_EQ(TextOf(Out() / "trajectory.tum"), trajectory);

  const fs::path later = clips / "20230501_120006.avi";
  fs::rename(second, later);
  const CommandResult gap = run({clips.string()});
  EXPECT_EQ(gap.exit_code, 0);
  const std::string warning =
      "gap of 4.8 s between 20230501_120000.avi and 20230501_120006.avi (at 1.2 s of the drive)";
  EXPECT_EQ(gap.err, "warning: " + warning + "\n");
  EXPECT_EQ(Summary()["warnings"][0], warning);
  EXPECT_NEAR(Summary()["clips"][1]["start_s"].get<double>(), 6, 1e-9);
  EXPECT_NEAR(Summary()["missing"]["seconds"].get<double>(), 4.8, 1e-9) << "as long as the gap";

  const fs::path rear = clips / "20230501_115951.avi";
  Video(rear, 0, 5);
  ExpectComplaint(run({later.string(), rear.string()}, camera), 2,
                  {"20230501_115951.avi: begins", "in the order of time"});
  ExpectComplaint(run({first, first}, camera), 2, {"is given twice"});
}

TEST_F(ErrorsTest, AClipThatEndsTooEarlyIsNamed) {
  const fs::path first = folder_ / "first.avi";
  const fs::path second = folder_ / "second.avi";
  Video(first, 0, 10);
  fs::resize_file(second, Video(second, 10) * 6 / 10);
  const CommandResult result = RunCommand({"run", first.string(), second.string(), "--camera",
                                           (Drive() / "calib.txt").string(), "--out", Out().string(), "--quiet"},
                                          folder_);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_TRUE(result.err.starts_with("warning: second.avi: the video ends after ")) << result.err;
  EXPECT_TRUE(Summary()["stopped"].get<std::string>().starts_with("second.avi: the video ends after "));
  ASSERT_EQ(Summary()["warnings"].size(), 1u);
  EXPECT_EQ(Summary()["warnings"][0], Summary()["stopped"]);
}

TEST_F(ErrorsTest, ADriveWhoseMiddleCannotBeDecodedIsIncomplete) {
  const fs::path clips = folder_ / "DCIM";
  fs::create_directories(clips);
  const fs::path first = clips / "20230501_120000.avi";
  Video(first, 0, 10);
  std::ofstream(clips / "20230501_120001.avi") << "this is no video";
  Video(clips / "20230501_120003.avi", 10, kRoomFrames);
  fs::copy(Drive() / "calib.txt", clips);
  const std::vector<std::string> arguments = {"run", clips.string(), "--out", Out().string(), "--quiet"};
  EXPECT_EQ(RunCommand(arguments, folder_).exit_code, 0);
  EXPECT_EQ(Summary()["stopped"], "20230501_120001.avi: cannot be decoded: a part of the drive is missing");
  EXPECT_FALSE(Summary()["complete"].get<bool>());

  fs::remove(clips / "20230501_120001.avi");
  fs::resize_file(first, fs::file_size(first) * 6 / 10);
  EXPECT_EQ(RunCommand(arguments, folder_).exit_code, 0);
  EXPECT_TRUE(Summary()["stopped"].get<std::string>().starts_with("20230501_120000.avi: the video ends after "));
  EXPECT_FALSE(Summary()["complete"].get<bool>());
}

TEST_F(ErrorsTest, APartOfTheDrive) {
  EXPECT_EQ(Run({"--start", "0:00.5", "--end", "1.5", "--quiet"}).exit_code, 0);
  EXPECT_EQ(Summary()["frames"]["total"], 10);
  EXPECT_EQ(Summary()["part"]["start"], "0:00.5");
  EXPECT_TRUE(Summary()["complete"].get<bool>());
  EXPECT_EQ(Summary()["scale"]["pending_reason"], "no lever arm given");
  EXPECT_EQ(ReadTrajectory(Out() / "trajectory.tum").front().time, 0.5);
  for (const std::string option : {"--end", "--max-frames"}) {
    EXPECT_EQ(Run({"--lever-arm", "1.5", option, option == "--end" ? "1.5" : "15", "--quiet"}).exit_code, 0);
    const std::string reason = Summary()["scale"]["pending_reason"].get<std::string>();
    EXPECT_TRUE(reason.starts_with("no turn; ")) << reason;
    EXPECT_TRUE(reason.ends_with("; only a part of the drive was processed, process more of it")) << reason;
  }
  EXPECT_EQ(Run({"--lever-arm", "1.5", "--start", "0", "--end", "1:00:00", "--quiet"}).exit_code, 0);
  EXPECT_EQ(Summary()["scale"]["pending_reason"].get<std::string>().find("only a part"), std::string::npos);
  ExpectComplaint(Run({"--start", "1:2:3:4"}), 2, {"--start 1:2:3:4: is not a time; give HH:MM:SS"});
  ExpectComplaint(Run({"--end", "soon"}), 2, {"--end soon: is not a time"});
  ExpectComplaint(Run({"--start", "10"}), 2, {"--start 10 s: the drive ends at 1.9 s"});
  ExpectComplaint(Run({"--start", "1", "--end", "0.5"}), 2, {"--end 0.5 s: has to be after --start 1 s"});
}

TEST_F(ErrorsTest, ARunWithoutAPoseLeavesEarlierResultsAsTheyAre) {
  ASSERT_EQ(Run({"--quiet"}).exit_code, 0);
  std::ofstream(Out() / "path.gpx") << "exported";
  const auto contents = [&] {
    std::map<std::string, std::string> texts;
    for (const auto& entry : fs::recursive_directory_iterator(Out()))
      if (entry.is_regular_file()) texts[entry.path().string()] = TextOf(entry.path());
    return texts;
  };
  const auto before = contents();
  const auto expect_kept = [&](const CommandResult& result, int exit_code, const std::string& why) {
    EXPECT_EQ(result.exit_code, exit_code);
    EXPECT_NE(result.err.find(Out().string() + " keeps those of an earlier run\n"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find(why), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("the results so far are in"), std::string::npos) << result.err;
    EXPECT_EQ(contents(), before);
  };
  expect_kept(Run({"--quiet", "--max-frames", "1"}), 2, "nothing could be tracked in 1 image ");
  for (int i = 0; i < kRoomFrames; ++i)
    cv::imwrite(Image(i).string(), cv::Mat(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(5)));
  expect_kept(Run({"--quiet"}), 2, "nothing could be tracked in 20 images");
  for (int i = 0; i < kRoomFrames; ++i) Text("drive/image_0/" + Image(i).filename().string(), "no image");
  expect_kept(Run({"--quiet"}), 2, "not one of 20 frames could be read");
}

TEST_F(ErrorsTest, ExportsOfAnEarlierPathAreNamed) {
  ASSERT_EQ(Run({"--quiet"}).exit_code, 0);
  for (const char* name : {"path.gpx", "path.gltf"}) std::ofstream(Out() / name) << "exported";
  EXPECT_EQ(Run({"--quiet"}).err, "warning: " + Out().string() +
                                      ": made from an earlier path: path.gpx, path.gltf; run turnscale export again\n");
  EXPECT_EQ(Summary()["warnings"].size(), 1u);
}

TEST_F(ErrorsTest, WhatAKilledRunLeftIsKept) {
  fs::create_directories(Out());
  std::ofstream(Out() / "live.tum.part") << "0 0 0 0 0 0 0 1\n";
  EXPECT_EQ(Run({"--quiet", "--max-frames", "1"}).exit_code, 2);
  EXPECT_TRUE(fs::exists(Out() / "live.tum.part"));
  EXPECT_FALSE(fs::exists(Out() / "summary.json"));
}

TEST_F(ErrorsTest, AResultFolderThatIsALinkToNowhereStays) {
  const fs::path link = folder_ / "link";
  fs::create_directory_symlink(folder_ / "unmounted", link);
  for (const fs::path& out : {link, link / "drive"}) {
    ExpectComplaint(RunCommand({"run", Drive().string(), "--fps", "10", "--quiet", "--out", out.string()}, folder_), 2,
                    {link.string() + ": is a link to a place that is not there; choose another --out"});
    EXPECT_TRUE(fs::is_symlink(link));
  }
}

TEST_F(ErrorsTest, ADriveOfWhichNothingCanBeTracked) {
  for (int i = 0; i < kRoomFrames; ++i)
    cv::imwrite(Image(i).string(), cv::Mat(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(5)));
  ExpectComplaint(Run({"--quiet"}), 2,
                  {Drive().string() + ": nothing could be tracked in 20 images (1.9 s): the images are dark; check"});
  for (const char* name : {"trajectory.tum", "trajectory.kitti.txt", "live.tum", "live.tum.part", "trajectory.csv",
                           "turns.csv", "map.ply"}) {
    EXPECT_FALSE(fs::exists(Out() / name)) << name;
  }
  EXPECT_FALSE(Summary()["complete"].get<bool>());
  EXPECT_EQ(Summary()["missing"]["longest"][0]["reason"], "before initialisation");
}

TEST_F(ErrorsTest, AMapThatStartsLateIsExplained) {
  constexpr int kDark = 13;
  for (int i = 0; i < kDark; ++i)
    cv::imwrite(Image(i).string(), cv::Mat(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(5)));
  const CommandResult result = Run({"--fps", "5", "--lever-arm", "1.5"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("warning: no map could be started before 2."), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("of 20 frames): the images are dark; check the exposure"), std::string::npos) << result.err;
  EXPECT_NE(result.out.find("the path begins only at 2."), std::string::npos) << result.out;
}

TEST_F(ErrorsTest, MaxFramesStopsEarlyAndSaysSo) {
  EXPECT_EQ(Run({"--max-frames", "5"}).exit_code, 0);
  EXPECT_EQ(Summary()["frames"]["total"], 5);
  EXPECT_EQ(Summary()["stopped"], "--max-frames 5");
  EXPECT_FALSE(Summary()["complete"].get<bool>());
  fs::remove_all(Out());
  const CommandResult one = Run({"--max-frames", "1", "--quiet"});
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_EQ(
      one.err,
      "warning: nothing could be tracked in 1 image (0.0 s): the part of the drive (--max-frames 1) is too short; "
      "widen it\n");
  EXPECT_EQ(Run({"--max-frames", std::to_string(kRoomFrames)}).exit_code, 0);
  EXPECT_TRUE(Summary()["stopped"].is_null()) << "that was the whole drive";

  // JPEG images one after another: a video that does not tell how many it holds.
  std::string stream;
  for (int i = 0; i < kRoomFrames; ++i) {
    cv::imwrite((folder_ / "image.jpg").string(), cv::imread(Image(i).string(), cv::IMREAD_GRAYSCALE));
    stream += TextOf(folder_ / "image.jpg");
  }
  const std::string video = Text("drive.mjpeg", stream).string();
  const auto run_stream = [&](const std::string& most) {
    return RunCommand({"run", video, "--camera", (Drive() / "calib.txt").string(), "--out", Out().string(), "--fps",
                       "10", "--max-frames", most},
                      folder_);
  };
  const CommandResult result = run_stream("5");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("frame 5/5,"), std::string::npos) << result.err;
  EXPECT_EQ(Summary()["stopped"], "--max-frames 5");
  EXPECT_EQ(run_stream("50").exit_code, 0);
  EXPECT_TRUE(Summary()["complete"].get<bool>()) << "nothing promised 50 frames";
}

TEST_F(ErrorsTest, DamagedImagesAreNamedAndSkipped) {
  for (const int damaged : {0, kRoomFrames / 2, kRoomFrames - 1}) {
    fs::remove_all(Drive());
    WriteRoomDrive(Drive(), kRoomFrames);
    fs::resize_file(Image(damaged), fs::file_size(Image(damaged)) / 2);
    const CommandResult result = Run({"--quiet"});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const std::string name = Image(damaged).filename().string();
    EXPECT_EQ(result.err, "warning: frame " + std::to_string(damaged) + ": " + name + ": is truncated; skipped\n");
    const auto summary = Summary();
    EXPECT_EQ(summary["frames"]["total"], kRoomFrames);
    ASSERT_EQ(summary["unreadable"].size(), 1u);
    EXPECT_EQ(summary["unreadable"][0]["frame"], damaged);
    EXPECT_EQ(summary["warnings"][0],
              "1 image cannot be used: frame " + std::to_string(damaged) + " (the first: " + name + ": is truncated)");
  }
}

TEST_F(ErrorsTest, UnreadableImageIsNamedAndSkipped) {
  std::ofstream(Image(4)) << "this is no image";
  const CommandResult result = Run({"--quiet"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "warning: frame 4: 000004.png: is not a readable image; skipped\n");
}

TEST_F(ErrorsTest, NotOneReadableImage) {
  for (int i = 0; i < kRoomFrames; ++i) std::ofstream(Image(i)) << "this is no image";
  const CommandResult result = Run({"--quiet"});
  EXPECT_EQ(result.exit_code, 2);
  ASSERT_EQ(result.Complaints().size(), 1u);
  EXPECT_NE(result.Complaints()[0].find("not one of 20 frames could be read"), std::string::npos);
}

TEST_F(ErrorsTest, ImageSizeThatContradictsTheCamera) {
  const std::string camera =
      Text("cam.yaml",
           "%YAML:1.0\nCamera.fx: 200\nCamera.fy: 200\nCamera.cx: 320\nCamera.cy: 240\nCamera.width: 640\n"
           "Camera.height: 480\n")
          .string();
  ExpectComplaint(Run({"--camera", camera}), 2, {"000000.png: is 320x240 pixels, but", "cam.yaml says 640x480"});
  EXPECT_FALSE(fs::exists(Out())) << "nothing was computed";
}

TEST_F(ErrorsTest, AMaskLeavesPixelsOutAndStaysWhatItIs) {
  const std::string path = (folder_ / "mask.png").string();
  cv::Mat mask(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(255));
  mask.rowRange(200, kRoomHeight).setTo(0);
  cv::imwrite(path, mask);
  EXPECT_EQ(Run({"--mask", path}).exit_code, 0);
  const cv::Mat written = cv::imread((Out() / "mask.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(written.size(), mask.size());
  EXPECT_EQ(cv::countNonZero(written.rowRange(200, kRoomHeight)), 0);
  ExpectComplaint(Run({"--mask", (Out() / "mask.png").string()}), 2, {"mask.png: is also an input file"});
  EXPECT_EQ(Run().exit_code, 0);
  EXPECT_FALSE(fs::exists(Out() / "mask.png")) << "nothing stands still in this drive";
}

TEST_F(ErrorsTest, ARunTakesNoFileAwayThatItReads) {
  fs::create_directories(Out());
  const auto refuses = [&](const std::string& option, const char* name, const std::string& text) {
    const fs::path file = Out() / name;
    std::ofstream(file) << text;
    ExpectComplaint(Run({option, file.string()}), 2, {"--out " + file.string() + ": is also an input file"});
    EXPECT_EQ(TextOf(file), text) << option;
    fs::remove(file);
  };
  std::string times;
  std::string poses;
  for (int i = 0; i < kRoomFrames; ++i) {
    times += std::to_string(0.1 * i) + "\n";
    poses += TumLine({0.1 * i, {Eigen::Quaterniond::Identity(), {0, 0, 0.1 * i}}});
  }
  const std::string rotation = "yaw_deg: 1\npitch_deg: 2\nroll_deg: 3\n";
  refuses("--settings", "settings.yaml", "corners:\n  min_distance: 5\n");
  refuses("--settings", "turns.csv", "corners:\n  min_distance: 5\n");
  refuses("--camera-rotation", "car.yaml", rotation);
  refuses("--vehicle", "car.yaml", rotation);
  refuses("--truth", "trajectory.tum", poses);
  refuses("--truth", "live.tum.part", poses);
  refuses("--timestamps", "speed.csv", times);
}

TEST_F(ErrorsTest, ARunIsRepeatedWithItsOwnSettings) {
  ASSERT_EQ(Run({"--quiet", "--lever-arm", "1.5"}).exit_code, 0);
  const std::string settings = (Out() / "settings.yaml").string();
  const std::string text = TextOf(settings);
  const CommandResult again = Run({"--quiet", "--settings", settings});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(TextOf(settings), text);
  ExpectComplaint(Run({"--quiet", "--settings", settings, "--lever-arm", "1.6"}), 2,
                  {"--out " + settings + ": is also an input file, and would change; give --settings a copy of it"});
  EXPECT_EQ(TextOf(settings), text);
  // As an earlier version wrote it, which did not have this setting.
  const size_t lens = text.find("\nlens:\n");
  const size_t line = text.find("\n  step:", lens);
  ASSERT_NE(line, std::string::npos);
  std::ofstream(settings) << text.substr(0, line) << text.substr(text.find('\n', line + 1));
  ExpectComplaint(Run({"--quiet", "--settings", settings, "--lever-arm", "1.6"}), 2, {"and would change"});
  const CommandResult older = Run({"--quiet", "--settings", settings});
  EXPECT_EQ(older.exit_code, 0) << older.err;
  EXPECT_EQ(TextOf(settings), text);
}

TEST_F(ErrorsTest, ACalibrationReplacesNoFileThatItReads) {
  const auto refuses = [&](std::vector<std::string> more, const fs::path& file) {
    const std::string text = TextOf(file);
    more.insert(more.begin(), {"calibrate", Drive().string()});
    ExpectComplaint(RunCommand(more, folder_), 2, {file.string() + ": is also an input file"});
    EXPECT_EQ(TextOf(file), text);
  };
  const fs::path settings = Text("s.yaml", "corners:\n  min_distance: 5\n");
  refuses({"--settings", settings.string(), "--out", settings.string()}, settings);
  refuses({"--out", (Drive() / "calib.txt").string()}, Drive() / "calib.txt");
  const fs::path speeds = Text("history.svg", "0 8\n1000 8\n");
  refuses({"--speed", speeds.string(), "--history", (folder_ / "history.csv").string()}, speeds);
}

TEST_F(ErrorsTest, FilesOfTheUsersAreNotReplaced) {
  fs::create_directories(Out());
  const fs::path camera = Out() / "camera.yaml";
  fs::copy_file(Drive() / "calib.txt", camera);
  ExpectComplaint(Run(), 2, {camera.string() + ": would be replaced, but is not of an earlier run; choose another"});
  EXPECT_EQ(TextOf(camera), TextOf(Drive() / "calib.txt"));
  EXPECT_EQ(std::distance(fs::directory_iterator(Out()), {}), 1);
}

TEST_F(ErrorsTest, TheCameraOfAnEarlierRunIsTakenAwayUnlessItIsGiven) {
  ASSERT_EQ(Run().exit_code, 0);
  const fs::path camera = Out() / "camera.yaml";
  fs::copy_file(Drive() / "calib.txt", camera);
  ExpectComplaint(Run({"--camera", camera.string()}), 2, {"camera.yaml: is also an input file"});
  EXPECT_TRUE(fs::exists(camera));
  EXPECT_EQ(Run().exit_code, 0);
  EXPECT_FALSE(fs::exists(camera));
}

TEST_F(ErrorsTest, ACalibrationBesideAVideoThatIsNotUsedIsNamed) {
  const fs::path video = folder_ / "drive.avi";
  Video(video);
  const fs::path camera = folder_ / "calib.txt";
  fs::copy_file(Drive() / "calib.txt", camera);
  for (const std::string command : {"run", "calibrate"}) {
    const std::string out = (folder_ / ("of_" + command)).string();
    const CommandResult result =
        RunCommand({command, video.string(), "--out", out, "--max-frames", "4", "--quiet"}, folder_);
    EXPECT_NE(result.err.find("warning: " + camera.string() + ": is not used; give --camera"), std::string::npos)
        << result.err;
  }
}

TEST_F(ErrorsTest, ACalibrationBesideAFolderOfImagesThatIsNotUsedIsNamed) {
  const std::string camera = (Drive() / "calib.txt").string();
  const auto warned = [&](const fs::path& input, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"run", input.string(), "--out", Out().string(), "--fps",
                                          "10",  "--max-frames", "4",     "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = RunCommand(arguments, folder_);
    return result.err.find("calib.txt: is not used; give --camera ") != std::string::npos;
  };
  EXPECT_TRUE(warned(Drive() / "image_0"));
  EXPECT_TRUE(warned(Drive() / "image_0" / ""));
  EXPECT_FALSE(warned(Drive() / "image_0", {"--camera", camera}));
  EXPECT_FALSE(warned(Drive() / "image_0", {"--fov", "77"}));
  EXPECT_FALSE(warned(Drive())) << "it is used";
}

TEST_F(ErrorsTest, ACalibrationBesideTheUsedOneIsNamedWhereItContradicts) {
  const auto warned = [&](const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments = {"run", Drive().string(), "--out", Out().string(), "--fps",
                                          "10",  "--max-frames",   "4",     "--quiet"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const CommandResult result = RunCommand(arguments, folder_);
    return result.err.find("calib.txt: is used, with the focal length ") != std::string::npos;
  };
  const CameraModel camera = ReadCameraFile(Drive() / "calib.txt");
  const auto write = [&](double factor) {
    CameraModel other = camera;
    other.pinhole.fx *= factor;
    other.pinhole.fy *= factor;
    const cv::Mat image = cv::imread(Image(0).string());
    other.width = image.cols;
    other.height = image.rows;
    std::ofstream(Drive() / "camera.yaml") << CameraFileText(other);
  };
  EXPECT_FALSE(warned());
  write(1.002);
  EXPECT_FALSE(warned());
  write(1.1);
  EXPECT_TRUE(warned());
  EXPECT_FALSE(warned({"--camera", (Drive() / "calib.txt").string()})) << "it was chosen";
  std::ofstream(Drive() / "camera.yaml") << "settings: of another program\n";
  EXPECT_FALSE(warned());
}

TEST_F(ErrorsTest, MissingImagesAreNamed) {
  for (int i = 8; i < 12; ++i) fs::remove(Image(i));
  const CommandResult result = Run({"--fps", "10", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string warning =
      (Drive() / "image_0").string() +
      ": 4 images are missing by the numbers of the names, 4 of them between 000007.png and 000012.png, and count as "
      "0.4 s at --fps 10; give --timestamps FILE if no time has passed there";
  EXPECT_NE(result.err.find("warning: " + warning), std::string::npos) << result.err;
  EXPECT_EQ(Summary()["warnings"][0], warning);
  EXPECT_EQ(ReadTrajectoryFile(Out() / "trajectory.tum").poses.back().time, (kRoomFrames - 1) / 10.0);
}

TEST_F(ErrorsTest, AMaskBesideTheImagesIsNoFrame) {
  cv::Mat mask(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(255));
  mask.rowRange(kRoomHeight - 20, kRoomHeight) = 0;
  const fs::path file = Drive() / "image_0" / "mask.png";
  cv::imwrite(file.string(), mask);
  const CommandResult result = Run({"--mask", file.string(), "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(Summary()["frames"]["total"], kRoomFrames);
}

TEST_F(ErrorsTest, CoefficientsThatMayBeOfAFisheyeGiveAWarning) {
  const fs::path camera = Text("cam.yaml",
                               "image_width: 320\nimage_height: 240\ncamera_matrix: [200, 0, 159.5, 0, 200, 119.5, 0, "
                               "0, 1]\ndistortion_coefficients: [0.05, 0.01, -0.04, 0.01]\n");
  const CommandResult result = Run({"--camera", camera.string(), "--max-frames", "4", "--quiet"});
  EXPECT_NE(result.err.find("warning: " + camera.string() + ": distortion_coefficients are read as k1 k2 p1 p2, but"),
            std::string::npos)
      << result.err;
}

TEST_F(ErrorsTest, NarrowImagesGiveAWarning) {
  fs::create_directories(folder_ / "small");
  for (int i = 0; i < 8; ++i)
    cv::imwrite((folder_ / "small" / (std::to_string(i) + ".png")).string(),
                cv::Mat(80, 160, CV_8UC1, cv::Scalar(9 * i)));
  const CommandResult result = RunCommand(
      {"run", (folder_ / "small").string(), "--fps", "10", "--fov", "70", "--out", Out().string(), "--no-report"},
      folder_);
  EXPECT_EQ(result.exit_code, 2) << "nothing to track";
  EXPECT_NE(result.err.find("the images are 160x80 pixels, too small"), std::string::npos) << result.err;
}

TEST_F(ErrorsTest, WideImagesAreProcessedSmallerAndResultsAreAtFullSize) {
  const std::string path = (folder_ / "mask.png").string();
  cv::Mat mask(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(255));
  mask.rowRange(200, kRoomHeight).setTo(0);
  cv::imwrite(path, mask);
  const fs::path settings = Text("s.yaml", "images:\n  max_width: 200\ncorners:\n  min_distance: 5\n");
  const CommandResult result = Run({"--settings", settings.string(), "--mask", path});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const nlohmann::json intrinsics = Summary()["intrinsics"];
  EXPECT_EQ(intrinsics["image_size"], nlohmann::json({kRoomWidth, kRoomHeight}));
  EXPECT_EQ(intrinsics["focal_length"], nlohmann::json({kRoomPinhole.fx, kRoomPinhole.fy}));
  EXPECT_EQ(intrinsics["principal_point"], nlohmann::json({kRoomPinhole.cx, kRoomPinhole.cy}));
  const cv::Mat written = cv::imread((Out() / "mask.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(written.size(), mask.size());
  EXPECT_EQ(cv::countNonZero(written != mask), 0);
  EXPECT_EQ(Summary()["frames"]["bridged"], 0);
}

TEST_F(ErrorsTest, AMaskThatDoesNotFit) {
  const std::string path = (folder_ / "mask.png").string();
  cv::imwrite(path, cv::Mat::eye(20, 30, CV_8UC1));
  ExpectComplaint(Run({"--mask", path}), 2, {"mask.png: is 30x20 pixels, but the images are 320x240"});
  EXPECT_FALSE(fs::exists(Out())) << "nothing was computed";
  ExpectComplaint(Run({"--mask", (folder_ / "none.png").string()}), 2, {"none.png: no such mask"});
}

TEST_F(ErrorsTest, ImageSizeThatChangesKeepsWhatWasComputed) {
  cv::imwrite(Image(12).string(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(3)));
  ExpectComplaint(Run({"--quiet"}), 2, {"000012.png: is 100x100 pixels, but", "000000.png says 320x240"});
  EXPECT_EQ(Summary()["frames"]["total"], 12);
  EXPECT_FALSE(Summary()["complete"].get<bool>());
}

TEST_F(ErrorsTest, ImageSizeThatChangesEndsACalibrationWithWhatItSaw) {
  cv::imwrite(Image(12).string(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(3)));
  const std::string out = (folder_ / "calibration.yaml").string();
  const CommandResult result = RunCommand({"calibrate", Drive().string(), "--out", out, "--quiet"}, folder_);
  ExpectComplaint(result, 2, {"000012.png: is 100x100 pixels, but", "; " + Drive().string() + ": ", "steps"});
}

TEST_F(ErrorsTest, ADistanceIsOfTheWholeDrive) {
  const std::string camera = (Drive() / "calib.txt").string();
  const auto calibrate = [&](const fs::path& input, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"calibrate",  input.string(),
                                          "--camera",   camera,
                                          "--distance", "7",
                                          "--out",      (folder_ / "calibration.yaml").string(),
                                          "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = RunCommand(arguments, folder_);
    EXPECT_EQ(result.exit_code, 2) << result.err;
    return result.Complaints().empty() ? std::string() : result.Complaints().front();
  };
  const std::string whole = calibrate(Drive());
  EXPECT_EQ(whole.find("--distance"), std::string::npos) << "the drive has no turn: " << whole;

  const fs::path video = folder_ / "drive.avi";
  fs::resize_file(video, Video(video) * 6 / 10);
  const std::string cut = calibrate(video);
  EXPECT_NE(cut.find("--distance: cannot be applied to " + video.string() + ": drive.avi: the video ends after"),
            std::string::npos)
      << cut;

  const fs::path clips = folder_ / "DCIM";
  fs::create_directories(clips);
  Video(clips / "20230501_120000.avi");
  std::ofstream(clips / "20230501_120002.avi") << "this is no video";
  const std::string left_out = calibrate(clips);
  EXPECT_NE(left_out.find("20230501_120002.avi: is not a video, or is damaged; the clip is left out; give --speed"),
            std::string::npos)
      << left_out;

  for (int i = 0; i < 13; ++i) cv::imwrite(Image(i).string(), cv::Mat(kRoomHeight, kRoomWidth, CV_8UC1, cv::Scalar(5)));
  const std::string late = calibrate(Drive(), {"--fps", "5"});
  EXPECT_NE(late.find("--distance: cannot be applied to " + Drive().string() + ": no map could be started before 2."),
            std::string::npos)
      << late;
}

TEST_F(ErrorsTest, MissingAndSenselessTimes) {
  const auto times = [&](const std::string& text) {
    return std::vector<std::string>{"--timestamps", Text("t.txt", text).string()};
  };
  std::string good;
  for (int i = 0; i < kRoomFrames - 1; ++i) good += std::to_string(i) + "\n";
  ExpectComplaint(Run(times(good)), 2, {"t.txt:19: ends after 19 times"});
  ExpectComplaint(Run(times(good + "19\n20\n")), 2, {"t.txt:21: time 21 has no frame"});
  ExpectComplaint(Run(times(good + "3\n")), 2, {"t.txt:20: time 3 goes back"});
  ExpectComplaint(Run(times(good + "18\n")), 2, {"t.txt:20: time 18 repeats"});
  ExpectComplaint(Run(times(good + "nan\n")), 2, {"t.txt:20: 'nan' is not a time"});
  ExpectComplaint(Run({"--timestamps", "nowhere.txt"}), 2, {"nowhere.txt: no such file"});
  ExpectComplaint(Run({"--fps", "0"}), 2, {"--fps 0"});
  fs::remove(Drive() / "times.txt");
  ExpectComplaint(Run(), 2, {"image_0", "give --timestamps FILE or --fps X"});
}

TEST_F(ErrorsTest, ACalibrationOfAnotherCameraIsDoubted) {
  EXPECT_EQ(Run({"--max-frames", "2"}).err.find("principal point"), std::string::npos);
  Text("drive/calib.txt", "P0: 200 0 60 0 0 200 120 0 0 0 1 0\n");
  const CommandResult result = Run({"--max-frames", "2"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("calib.txt: the principal point (60, 120) is far from the centre"), std::string::npos)
      << result.err;
}

TEST_F(ErrorsTest, ACalibrationOfLargerImagesIsNamed) {
  Text("drive/calib.txt", "P0: 400 0 319 0 0 400 239 0 0 0 1 0\n");
  const CommandResult result = Run({"--max-frames", "2"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.err.find("the calibration seems to be of images 2 times as wide and as high"), std::string::npos)
      << result.err;
}

TEST_F(ErrorsTest, SenselessCameras) {
  const auto camera = [&](const std::string& text) {
    return std::vector<std::string>{"--camera", Text("cam.yaml", text).string()};
  };
  const std::string rest = "Camera.fy: 200\nCamera.cx: 160\nCamera.cy: 120\n";
  ExpectComplaint(Run(camera("Camera.fx: .nan\n" + rest)), 2, {"cam.yaml:1: Camera.fx: is '.nan'"});
  ExpectComplaint(Run(camera("Camera.fx: -200\n" + rest)), 2, {"cam.yaml:1: Camera.fx: is -200", "above 0"});
  ExpectComplaint(Run(camera("Camera.fx: 200\nCamera.cz: 1\n" + rest)), 2,
                  {"cam.yaml:2: Camera.cz: unknown key; did you mean 'Camera.c"});
  ExpectComplaint(Run(camera(rest)), 2, {"Camera.fx: is missing"});
  ExpectComplaint(Run({"--camera", "nowhere.yaml"}), 2, {"nowhere.yaml: no such camera file"});
  for (const auto* text : {"name: a drive\n", "no camera\n", "a: [\n"})
    ExpectComplaint(Run(camera(text)), 2, {"cam.yaml:", "(a camera file is a KITTI calib.txt or a YAML file"});
  Text("drive/calib.txt", "P0: nan 0 160 0 0 200 120 0 0 0 1 0\n");
  ExpectComplaint(Run(), 2, {"calib.txt:1: P0: 'nan' at position 1"});
  ExpectComplaint(Run({"--fov", "200"}), 2, {"--fov 200"});
}

TEST_F(ErrorsTest, ADriveWithoutCalibrationAndTurnsAssumesAFieldOfView) {
  fs::remove(Drive() / "calib.txt");
  const CommandResult result = Run({"--fov", "75"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("--fov 75 is used"), std::string::npos) << result.err;
  EXPECT_TRUE(Summary()["camera"].is_null());
  EXPECT_EQ(Summary()["intrinsics"]["source"], "assumed");
  EXPECT_FALSE(fs::exists(Out() / "camera.yaml"));
}

TEST_F(ErrorsTest, ResultsDoNotGoWhereTheDriveIs) {
  const std::string drive = Drive().string();
  for (const std::vector<std::string>& input :
       {std::vector{drive}, std::vector{drive, std::string("--fov"), std::string("70")}}) {
    std::vector<std::string> arguments = {"run", "--out", drive, "--quiet"};
    arguments.insert(arguments.end(), input.begin(), input.end());
    ExpectComplaint(RunCommand(arguments, folder_), 2, {drive + ": is the folder of the drive; choose another --out"});
  }
  EXPECT_FALSE(fs::exists(Drive() / "summary.json"));
}

// Not after a run of hours.
TEST_F(ErrorsTest, ATruthThatCannotBeReadIsNoticedBeforeTheRun) {
  const std::string broken = Text("broken.tum", "0 0 0 0 0 0 0\n").string();
  const std::string good = Text("good.tum", "0 0 0 0 0 0 0 1\n0.1 0 0 1 0 0 0 1\n").string();
  ExpectComplaint(Run({"--quiet", "--truth", broken}), 2, {"broken.tum"});
  ExpectComplaint(Run({"--quiet", "--truth", (folder_ / "none.tum").string()}), 2, {"none.tum"});
  ExpectComplaint(Run({"--quiet", "--truth", good, "--floor-plan", broken}), 2, {"broken.tum: is not a floor plan"});
  EXPECT_FALSE(fs::exists(Out() / "trajectory.tum"));
}

TEST_F(ErrorsTest, ATruthOfAnotherDriveLeavesAPageWithoutIt) {
  const std::string other = Text("other.tum", "1000 0 0 0 0 0 0 1\n1001 0 0 1 0 0 0 1\n").string();
  const CommandResult result = Run({"--quiet", "--truth", other});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("; the results so far are in"), std::string::npos) << result.err;
  EXPECT_NE(TextOf(Out() / "report.html").find("\"truth\":null"), std::string::npos);
}

TEST_F(ErrorsTest, SenselessSettings) {
  const auto settings = [&](const std::string& text) {
    return std::vector<std::string>{"--settings", Text("s.yaml", text).string()};
  };
  ExpectComplaint(Run(settings("vehicle:\n  lever_arn: 1\n")), 2,
                  {"s.yaml:2: vehicle.lever_arn: unknown key; did you mean 'vehicle.lever_arm'?"});
  ExpectComplaint(Run(settings("vehicle:\n  lever_arm: -1\n")), 2, {"s.yaml", "lever_arm"});
  ExpectComplaint(Run(settings("corners:\n  target: many\n")), 2, {"s.yaml:2: corners.target: is 'many'"});
}

TEST_F(ErrorsTest, SenselessOptions) {
  for (const char* value : {"0", "-1.2", "nan", "inf"}) {
    ExpectComplaint(Run({"--lever-arm", value}), 2, {std::string("--lever-arm ") + value, "above 0"});
  }
  ExpectComplaint(Run({"--lever-arm", "long"}), 2,
                  {"--lever-arm: 'long' is not a valid value; give a number with a decimal point, without a unit; see "
                   "turnscale run --help"});
  ExpectComplaint(Run({"--Lever_arm", "1"}), 2, {"--Lever_arm: unknown option; did you mean '--lever-arm'?; see"});
  ExpectComplaint(Run({"--lever-arm", "1", "--lever-arm", "2"}), 2, {"--lever-arm: is given more than once; see"});
  ExpectComplaint(RunCommand({Drive().string()}, folder_), 2,
                  {Drive().string() + ": unknown command; did you mean 'turnscale run " + Drive().string() + "'?"});
  ExpectComplaint(Run({"--lever-arm"}), 2, {"--lever-arm: its value is missing; see turnscale run --help"});
  ExpectComplaint(Run({"--lever-arm", "--quiet"}), 2, {"--lever-arm: its value is missing"});
  ExpectComplaint(Run({"--side-slip", "-0.1"}), 2, {"--side-slip -0.1"});
  for (const char* value : {"0", "-1.4", "10.5", "nan", "tall", "1.4,", ",0.01", "1.4,0", "1.4,-0.01", "1.4,1.4"})
    ExpectComplaint(Run({"--camera-height", value}), 2,
                    {std::string("--camera-height ") + value + ": give", "H,SIGMA"});
  ExpectComplaint(Run({"--camera-rotation", "1,2"}), 2, {"--camera-rotation '1,2'"});
  ExpectComplaint(Run({"--frame", "vehicle"}), 2, {"--frame vehicle", "--lever-arm"});
  ExpectComplaint(Run({"--lever-arm-sigma", "0.01"}), 2, {"--lever-arm-sigma: needs --lever-arm"});
  ExpectComplaint(Run({"--no-report", "--truth", Drive().string()}), 2, {"--no-report: excludes --truth"});
  for (const char* method : {"turns", "paper"})
    ExpectComplaint(Run({"--method", method, "--camera-height", "1.5"}), 2,
                    {std::string("--method ") + method + ": constrains turns by the lever arm", "give --lever-arm"});
  ExpectComplaint(Run({"--frame", "wheel"}), 2, {"--frame", "wheel"});
  ExpectComplaint(Run({"--threads", "0"}), 2, {"--threads 0"});
  ExpectComplaint(Run({"--no-such-option"}), 2, {"--no-such-option"});
  ExpectComplaint(RunCommand({}, folder_), 2, {"no command; give one"});
  ExpectComplaint(RunCommand({"runn"}, folder_), 2,
                  {"turnscale: runn: unknown command; did you mean 'run'?; see turnscale --help"});
  ExpectComplaint(RunCommand({"drive.mp4", "--lever-arm", "1.5"}, folder_), 2,
                  {"turnscale: drive.mp4: unknown command; see turnscale --help"});
  ExpectComplaint(RunCommand({"run"}, folder_), 2, {"turnscale: input"});
  ExpectComplaint(RunCommand({"run", "--Lever-Arm=1"}, folder_), 2,
                  {"--Lever-Arm: unknown option; did you mean '--lever-arm'?; see turnscale run --help"});
  ExpectComplaint(RunCommand({"evaluate", "a.tum", "-x"}, folder_), 2,
                  {"-x: unknown option; see turnscale evaluate --help"});
  for (const char* file : {"a.tum", "-x"})
    ExpectComplaint(RunCommand({"evaluate", "--", file}, folder_), 2,
                    {"turnscale: GROUND_TRUTH is required; see turnscale evaluate --help"});
  ExpectComplaint(RunCommand({"evaluate", "-x", "--", "a.tum"}, folder_), 2, {"-x: unknown option"});
}

TEST_F(ErrorsTest, PlacesThatCannotBeWritten) {
  Text("out", "a file in the way");
  ExpectComplaint(Run(), 2, {"out: is a file"});
  ExpectComplaint(RunCommand({"run", Drive().string(), "--out", "/proc/turnscale"}, folder_), 2,
                  {"/proc/turnscale: cannot be made"});
}

// Not after the images have been read to estimate the camera.
TEST_F(ErrorsTest, APlaceThatCannotBeWrittenIsNoticedBeforeTheCameraIsEstimated) {
  fs::remove(Image(12));
  ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);  // reading on would hang
  Text("out", "a file in the way");
  ExpectComplaint(Run({"--fov", "75"}), 2, {"out: is a file"});
  fs::remove(Out());
  ExpectComplaint(Run({"--fov", "75", "--frame", "vehicle"}), 2, {"--frame vehicle", "--lever-arm"});
  const std::string nowhere = (folder_ / "nowhere" / "calibration.yaml").string();
  ExpectComplaint(RunCommand({"calibrate", Drive().string(), "--out", nowhere}, folder_), 2,
                  {nowhere + ": cannot be written: No such file or directory; choose another place"});
}

TEST_F(ErrorsTest, FullDisk) {
  for (const char* name :
       {"live.tum", "trajectory.tum", "settings.yaml", "trajectory.csv", "turns.csv", "map.ply", "summary.json"}) {
    fs::remove_all(Out());
    fs::create_directories(Out());
    fs::create_symlink("/dev/full", Out() / name);
    ExpectComplaint(Run({"--quiet"}), 1, {name, "No space left on device"});
  }
}

TEST_F(ErrorsTest, InterruptKeepsWhatWasComputed) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    // A pipe in place of frame 12 holds the run there until the signal has been sent.
    fs::remove(Image(12));
    ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);
    Command command(Arguments({"--lever-arm", "1.5"}), folder_);
    ASSERT_TRUE(command.WaitForError("frame 12/20"));
    command.Signal(signal);
    { const std::ofstream opened_and_closed(Image(12)); }
    const CommandResult result = command.Wait();
    EXPECT_EQ(result.exit_code, 130);
    ASSERT_EQ(result.Complaints().size(), 1u) << result.err;
    EXPECT_NE(result.Complaints()[0].find("interrupted after 12 frames; the results so far are in"), std::string::npos);
    EXPECT_EQ(Summary()["frames"]["total"], 12);
    EXPECT_FALSE(Summary()["complete"].get<bool>());
    EXPECT_EQ(ReadTrajectory(Out() / "trajectory.tum").size(), 12u);
    EXPECT_EQ(ReadTrajectory(Out() / "trajectory.kitti.txt").size(), 12u);
    EXPECT_GT(ReadTrajectory(Out() / "live.tum").size(), 0u);
  }
}

TEST_F(ErrorsTest, AnInterruptBeforeTheFirstFrameSaysThatNothingIsWritten) {
  const fs::path camera = folder_ / "camera.txt";
  ASSERT_EQ(mkfifo(camera.c_str(), 0600), 0);
  for (const std::string command_name : {"run", "calibrate"}) {
    const fs::path out = folder_ / "nothing";
    Command command({command_name, Drive().string(), "--camera", camera.string(), "--out", out.string()}, folder_);
    // Opens as soon as the command does, which reads until the other end is closed: not before it has ended.
    const std::ofstream opened(camera);
    command.Signal(SIGTERM);
    const CommandResult result = command.Wait();
    EXPECT_EQ(result.exit_code, 130);
    EXPECT_EQ(result.err, "turnscale: interrupted before the first frame; nothing is written\n");
    EXPECT_FALSE(fs::exists(out));
  }
}

TEST_F(ErrorsTest, AnInterruptedEstimateOfTheCameraSaysSo) {
  for (const int image : {11, 12}) {
    fs::remove(Image(image));
    ASSERT_EQ(mkfifo(Image(image).c_str(), 0600), 0);
  }
  for (const std::string command_name : {"run", "calibrate"}) {
    const fs::path out = folder_ / "nothing";
    Command command({command_name, Drive().string(), "--fov", "75", "--out", out.string()}, folder_);
    // The first pipe tells that images are being read, the second holds the command there until the signal is sent.
    { const std::ofstream opened_and_closed(Image(11)); }
    command.Signal(SIGINT);
    // Opened for both directions, it does not wait for a command that has ended.
    const std::fstream opened(Image(12));
    const CommandResult result = command.Wait();
    EXPECT_EQ(result.exit_code, 130);
    EXPECT_EQ(result.err, "turnscale: interrupted while the camera was estimated; nothing is written\n");
    EXPECT_FALSE(fs::exists(out));
  }
}

TEST_F(ErrorsTest, AnInterruptedCalibrationSaysSo) {
  fs::remove(Image(12));
  ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);
  const std::string out = (folder_ / "calibration.yaml").string();
  Command command({"calibrate", Drive().string(), "--distance", "7", "--out", out}, folder_);
  ASSERT_TRUE(command.WaitForError("frame 12/20"));
  command.Signal(SIGINT);
  { const std::ofstream opened_and_closed(Image(12)); }
  const CommandResult result = command.Wait();
  EXPECT_EQ(result.exit_code, 130);
  ASSERT_EQ(result.Complaints().size(), 1u) << result.err;
  const std::string complaint = result.Complaints()[0];
  EXPECT_NE(complaint.find("interrupted after 12 frames; "), std::string::npos);
  EXPECT_EQ(complaint.find("interrupted"), complaint.rfind("interrupted")) << complaint;
}

TEST_F(ErrorsTest, ASecondSignalOfEitherKindEndsARunThatHangs) {
  for (const auto& [first, second] : {std::pair(SIGINT, SIGTERM), std::pair(SIGTERM, SIGINT)}) {
    fs::remove(Image(12));
    ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);
    Command command(Arguments({}), folder_);
    ASSERT_TRUE(command.WaitForError("frame 12/20"));
    command.Signal(first);
    // Both at once would be one for the run.
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    command.Signal(second);
    EXPECT_EQ(command.Wait().exit_code, -1) << "ended by the signal";
  }
}

TEST_F(ErrorsTest, AnotherSignalDoesNotUndoNohup) {
  fs::remove(Image(12));
  ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);
  Command command(Arguments({}), folder_, {}, {}, /*nohup=*/true);
  ASSERT_TRUE(command.WaitForError("frame 12/20"));
  command.Signal(SIGHUP);
  command.Signal(SIGINT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  command.Signal(SIGHUP);
  { const std::ofstream opened_and_closed(Image(12)); }
  EXPECT_EQ(command.Wait().exit_code, 130);
}

TEST_F(ErrorsTest, FilesAreValidWhileTheRunGoesOn) {
  fs::remove(Image(12));
  ASSERT_EQ(mkfifo(Image(12).c_str(), 0600), 0);
  Command command(Arguments({}), folder_);
  ASSERT_TRUE(command.WaitForError("frame 12/20"));
  EXPECT_GT(ReadTrajectory(Out() / "live.tum.part").size(), 0u);
  command.Signal(SIGKILL);
}

}  // namespace
}  // namespace turnscale
