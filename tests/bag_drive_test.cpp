// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "command_line.h"
#include "rendered_room.h"
#include "turnscale/bag/test_bag.h"
#include "turnscale/base/test_files.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/frames/drive_input.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

constexpr int kBagRoomFrames = 20;

class BagDriveTest : public ::testing::Test {
 protected:
  BagDriveTest() : folder_(ScratchPath("folder")) {
    fs::create_directories(folder_);
    WriteRoomDrive(folder_ / "drive", kBagRoomFrames);
  }
  ~BagDriveTest() override { fs::remove_all(folder_); }

  // The drive's images from `first` to before `last` on each of the topics, with their times and camera.
  fs::path Bag(const std::string& name, const std::vector<std::string>& topics, int first = 0,
               int last = kBagRoomFrames) const {
    const DriveInput drive = FindDrive(folder_ / "drive");
    const std::vector<double> times = ReadFrameTimes(*drive.times_file).times;
    const CameraModel camera = ReadCameraFile(*drive.camera_file);
    const BagSerialization serialization = SerializationOf(name);
    std::vector<TestBagMessage> messages;
    for (int i = first; i < last; ++i) {
      const cv::Mat image = cv::imread(drive.images[static_cast<size_t>(i)].string(), cv::IMREAD_GRAYSCALE);
      const auto stamp = static_cast<int64_t>(std::llround(1e9 * times[static_cast<size_t>(i)]));
      TestCameraInfo info;
      info.width = static_cast<uint32_t>(image.cols);
      info.height = static_cast<uint32_t>(image.rows);
      const Pinhole& p = camera.pinhole;
      info.k = {p.fx, 0, p.cx, 0, p.fy, p.cy, 0, 0, 1};
      const std::span<const uint8_t> pixels(image.data, image.total());
      for (const std::string& topic : topics) {
        messages.push_back({topic + "/camera_info", "CameraInfo", stamp, TestCameraInfoMessage(serialization, info)});
        messages.push_back({topic + "/image_raw", "Image", stamp,
                            TestImageMessage(serialization, stamp, info.width, info.height, "mono8", pixels)});
      }
    }
    WriteTestBag(folder_ / name, messages, {.compression = "lz4"});
    return folder_ / name;
  }

  CommandResult Run(const std::vector<std::string>& inputs, const std::vector<std::string>& options = {}) const {
    std::vector<std::string> arguments = {"run"};
    arguments.insert(arguments.end(), inputs.begin(), inputs.end());
    arguments.insert(arguments.end(), {"--lever-arm", "1.5", "--quiet", "--out", (folder_ / "out").string()});
    arguments.insert(arguments.end(), options.begin(), options.end());
    return RunCommand(arguments, folder_);
  }

  std::string Trajectory() const { return TextOf(folder_ / "out" / "trajectory.tum"); }

  fs::path folder_;
};

TEST_F(BagDriveTest, ABagGivesWhatItsImagesGiveInAFolder) {
  const CommandResult of_folder = Run({(folder_ / "drive").string()});
  ASSERT_EQ(of_folder.exit_code, 0);
  EXPECT_TRUE(of_folder.err.starts_with("warning: the trajectory is up to scale: no turn; ")) << of_folder.err;
  const std::string expected = Trajectory();
  ASSERT_FALSE(expected.empty());
  for (const std::string name : {"drive.bag", "drive.mcap", "drive.db3"}) {
    const CommandResult result = Run({Bag(name, {"/camera"}).string()});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, of_folder.err);
    EXPECT_EQ(Trajectory(), expected) << name;
    const std::string summary = TextOf(folder_ / "out" / "summary.json");
    EXPECT_NE(summary.find("\"topic\": \"/camera/image_raw\""), std::string::npos);
    EXPECT_NE(summary.find(name + ": /camera/camera_info"), std::string::npos);
  }
  EXPECT_EQ(Run({Bag("1.bag", {"/camera"}, 0, 8).string(), Bag("2.bag", {"/camera"}, 8).string()}).exit_code, 0);
  EXPECT_EQ(Trajectory(), expected) << "bags continue one another";
  EXPECT_EQ(Run({Bag("two.bag", {"/left", "/right"}).string()}, {"--topic", "/right/image_raw"}).exit_code, 0);
  EXPECT_EQ(Trajectory(), expected);
}

TEST_F(BagDriveTest, ErrorsAreOneLine) {
  const std::string two = Bag("two.bag", {"/left", "/right"}).string();
  ExpectComplaint(Run({two}), 2, {"two.bag: ", "with --topic: /left/image_raw, /right/image_raw"});
  ExpectComplaint(Run({two}, {"--topic", "/rear"}), 2, {"two.bag: holds no images on /rear, but on /left/image_raw"});
  const std::string first = Bag("1.bag", {"/camera"}, 0, 8).string();
  const std::string second = Bag("2.bag", {"/camera"}, 8).string();
  ExpectComplaint(Run({second, first}), 2, {"1.bag: begins before ", "give the bags in their order"});
  ExpectComplaint(Run({(folder_ / "drive").string()}, {"--topic", "/a"}), 2, {"--topic /a: ", "is not a bag"});
  const std::string cut = Bag("cut.mcap", {"/camera"}).string();
  fs::resize_file(cut, fs::file_size(cut) / 2);
  ExpectComplaint(Run({cut}), 2, {"cut.mcap: the file ends early (record at byte ", "the results so far are in "});
}

TEST_F(BagDriveTest, CalibrateTakesBags) {
  // What it says after the name of the input.
  const auto calibrate = [&](const std::string& input) {
    const CommandResult result =
        RunCommand({"calibrate", input, "--quiet", "--out", (folder_ / "c.yaml").string()}, folder_);
    EXPECT_NE(result.exit_code, 1) << result.err;
    return std::to_string(result.exit_code) + result.err.substr(std::min(result.err.size(), result.err.rfind(": ")));
  };
  const std::string expected = calibrate((folder_ / "drive").string());
  EXPECT_EQ(calibrate(Bag("drive.mcap", {"/camera"}).string()), expected);
}

}  // namespace
}  // namespace turnscale
