// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_source.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/frames/drive_input.h"
#include "turnscale/frames/frame_reader.h"
#include "turnscale/frames/test_video.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// Its gray tells which frame it is; the rest keeps the file longer than its header.
cv::Mat Image(int number, cv::Size size = {64, 48}) {
  cv::Mat image(size, CV_8UC1);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = static_cast<uint8_t>((x * 7 + y * 13 + x * y) % 251);
  }
  image(cv::Rect(0, 0, 16, 16)) = number;
  return image;
}

class ImageSourceTest : public ::testing::Test {
 protected:
  ImageSourceTest() {
    const std::string name = ::testing::UnitTest::GetInstance()->current_test_info()->name();
    folder_ = ScratchPath(name);
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  ~ImageSourceTest() override { fs::remove_all(folder_); }

  void Images(const fs::path& folder, int first, int count) {
    fs::create_directories(folder);
    for (int i = first; i < first + count; ++i) cv::imwrite((folder / (std::to_string(i) + ".png")).string(), Image(i));
  }

  fs::path Text(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }

  void Truncate(const fs::path& path) { fs::resize_file(path, fs::file_size(path) * 6 / 10); }

  std::vector<SourceFrame> ReadAll(const ImageSourceOptions& options = {.fps = 10}) {
    ImageSource source(FindDrive(folder_), options);
    std::vector<SourceFrame> frames;
    while (auto frame = source.Next()) frames.push_back(*frame);
    return frames;
  }

  std::string Complaint(const ImageSourceOptions& options = {.fps = 10}) {
    try {
      ReadAll(options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  fs::path folder_;
};

TEST(NaturalOrder, NumbersCompareByValue) {
  EXPECT_TRUE(NaturalLess("9.png", "10.png"));
  EXPECT_FALSE(NaturalLess("10.png", "9.png"));
  EXPECT_TRUE(NaturalLess("a2b10", "a2b9999"));
  EXPECT_TRUE(NaturalLess("000100.png", "000101.png"));
  EXPECT_TRUE(NaturalLess("frame", "frame1"));
  EXPECT_NE(NaturalLess("01.png", "1.png"), NaturalLess("1.png", "01.png")) << "names that differ have one order";
  EXPECT_FALSE(NaturalLess("1.png", "1.png"));
}

TEST_F(ImageSourceTest, FolderOfImagesInNaturalOrderWithAnyStartAndGaps) {
  Images(folder_, 98, 4);
  fs::remove(folder_ / "100.png");
  Text("notes.md", "no image");
  const auto frames = ReadAll();
  ASSERT_EQ(frames.size(), 3u);
  const int expected[] = {98, 99, 101};
  const double times[] = {0, 0.1, 0.3};
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(frames[i].index, i);
    EXPECT_DOUBLE_EQ(frames[i].time, times[i]);
    EXPECT_EQ(frames[i].gray.at<uint8_t>(0, 0), expected[i]);
    EXPECT_EQ(frames[i].problem, "");
  }
}

TEST_F(ImageSourceTest, WideImagesAreReducedAndNarrowOnesEnlarged) {
  Images(folder_, 0, 2);
  ImageSource plain(FindDrive(folder_), {.fps = 10});
  const cv::Size size = plain.FullSize().value();
  ImageSource source(
      FindDrive(folder_),
      {.fps = 10, .width = size.width, .height = size.height, .images = {.max_width = size.width - 1, .min_width = 0}});
  EXPECT_EQ(source.FullSize(), size) << "asked before the first image";
  int frames = 0;
  for (; const auto frame = source.Next(); ++frames) EXPECT_EQ(frame->gray.size(), size / 2);
  EXPECT_EQ(frames, 2) << "none is missing";
  ImageSource enlarged(FindDrive(folder_), {.fps = 10, .images = {.max_width = 0, .min_width = size.width + 1}});
  EXPECT_EQ(enlarged.FullSize(), size);
  EXPECT_EQ(enlarged.Next()->gray.size(), size * 2);
}

TEST_F(ImageSourceTest, TheSizeIsThatOfTheFirstReadableImage) {
  Images(folder_, 1, 2);
  Text("0.png", "no image");
  ImageSource source(FindDrive(folder_), {.fps = 10});
  EXPECT_FALSE(source.FullSize().value().empty());
  EXPECT_TRUE(source.Next()->gray.empty());
  EXPECT_FALSE(source.Next()->gray.empty());
}

TEST_F(ImageSourceTest, KittiFolderBringsItsTimesAndCamera) {
  Images(folder_ / "image_0", 0, 3);
  Text("times.txt", "0.0\n1.036e-01\n\n# a comment\n2.07e-01\r\n");
  Text("calib.txt", "");
  const auto frames = ReadAll({});
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].time, 0.1036);
  EXPECT_EQ(frames[2].time, 0.207);
  EXPECT_EQ(FindDrive(folder_).camera_file, folder_ / "calib.txt");
  EXPECT_EQ(ReadAll({.fps = 5})[1].time, 0.2) << "what the user says goes first";
}

TEST_F(ImageSourceTest, CameraYamlStandsInWhereThereIsNoCalibTxt) {
  Images(folder_ / "image_0", 0, 1);
  EXPECT_FALSE(FindDrive(folder_).camera_file.has_value());
  Text("camera.yaml", "");
  EXPECT_EQ(FindDrive(folder_).camera_file, folder_ / "camera.yaml");
  Text("calib.txt", "");
  EXPECT_EQ(FindDrive(folder_).camera_file, folder_ / "calib.txt");
}

TEST_F(ImageSourceTest, ColourAndSixteenBitBecomeGray) {
  cv::imwrite((folder_ / "0.png").string(), cv::Mat(48, 64, CV_8UC3, cv::Scalar(50, 50, 50)));
  cv::Mat deep(48, 64, CV_16UC1, cv::Scalar(50 * 256));
  deep.at<uint16_t>(0, 0) = 200 * 256;
  cv::imwrite((folder_ / "1.png").string(), deep);
  cv::imwrite((folder_ / "2.jpg").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(50)));
  cv::imwrite((folder_ / "3.bmp").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(50)));
  cv::imwrite((folder_ / "4.pgm").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(50)));
  cv::imwrite((folder_ / "5.png").string(), cv::Mat(48, 64, CV_8UC4, cv::Scalar(50, 50, 50, 255)));
  cv::imwrite((folder_ / "6.TIFF").string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(50)));
  const auto frames = ReadAll();
  ASSERT_EQ(frames.size(), 7u);
  for (const SourceFrame& frame : frames) {
    ASSERT_EQ(frame.gray.type(), CV_8UC1) << frame.problem;
    EXPECT_NEAR(frame.gray.at<uint8_t>(20, 20), 50, 1) << frame.index;
  }
}

TEST_F(ImageSourceTest, TwelveBitsInSixteenKeepTheirContrast) {
  for (const char* name : {"1.png", "2.tif"}) {
    cv::Mat deep;
    Image(50).convertTo(deep, CV_16U, 16);
    cv::imwrite((folder_ / name).string(), deep);
  }
  Text("0.png", "unreadable");
  const auto frames = ReadAll();
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[0].notice, "");
  EXPECT_EQ(frames[1].notice, "the 16-bit images are read as 12 bits: the brightest level of the first one is 4000");
  EXPECT_EQ(frames[2].notice, "");
  for (int i = 1; i < 3; ++i) EXPECT_EQ(cv::norm(frames[i].gray, Image(50), cv::NORM_INF), 0);
}

TEST_F(ImageSourceTest, ImagesAreTurnedByTheOrientationOfTheFirst) {
  const auto write = [&](const std::string& name, char orientation) {
    std::vector<uint8_t> jpeg;
    cv::imencode(".jpg", Image(50), jpeg);
    std::string exif(
        "\xFF\xE1\0\x22"
        "Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\0\0\0\0\0\0\0\0",
        36);
    exif[28] = orientation;
    jpeg.insert(jpeg.begin() + 2, exif.begin(), exif.end());
    std::ofstream(folder_ / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  };
  write("0.jpg", 6);
  write("1.jpg", 6);
  write("2.jpg", 1);
  write("3.jpg", 8);
  EXPECT_EQ(ImageSource(FindDrive(folder_), {.fps = 10}).read_direction(), (ReadDirection{-1, 0}));
  EXPECT_EQ(ImageSource(FindDrive(folder_), {.fps = 10, .rotate = 270}).read_direction(), ReadDirection());
  const auto frames = ReadAll();
  ASSERT_EQ(frames.size(), 4u);
  const cv::Mat shown = cv::imread((folder_ / "0.jpg").string(), cv::IMREAD_GRAYSCALE);
  ASSERT_EQ(shown.size(), cv::Size(48, 64));
  for (const SourceFrame& frame : frames) {
    ASSERT_EQ(frame.gray.size(), shown.size());
    EXPECT_LE(cv::norm(frame.gray, shown, cv::NORM_INF), 2);
    EXPECT_EQ(frame.notice,
              frame.index == 2
                  ? "2.jpg: its EXIF orientation is 1, but that of the first image is 6, which is used for all"
                  : "");
  }
  const std::string complaint = Complaint({.fps = 10, .width = 64, .height = 48, .camera_file = "cam.yaml"});
  EXPECT_NE(complaint.find("0.jpg: is 48x64 pixels, but cam.yaml says 64x48"), std::string::npos) << complaint;
}

TEST_F(ImageSourceTest, ImagesAreRotatedAsAsked) {
  Images(folder_, 0, 1);
  const cv::Mat plain = ReadAll().at(0).gray;
  for (const auto& [degrees, code] : {std::pair(90, cv::ROTATE_90_CLOCKWISE), std::pair(180, cv::ROTATE_180),
                                      std::pair(270, cv::ROTATE_90_COUNTERCLOCKWISE)}) {
    cv::Mat expected;
    cv::rotate(plain, expected, code);
    const cv::Mat seen = ReadAll({.fps = 10, .rotate = degrees}).at(0).gray;
    ASSERT_EQ(seen.size(), expected.size());
    EXPECT_EQ(cv::norm(seen, expected, cv::NORM_INF), 0) << degrees;
  }
  EXPECT_THROW(ReadAll({.fps = 10, .rotate = 45}), InputError);
}

TEST_F(ImageSourceTest, MissingImagesAreNamedAndTakeTime) {
  Images(folder_, 1, 4);
  Images(folder_, 15, 5);
  ImageSource source(FindDrive(folder_), {.fps = 10});
  EXPECT_EQ(source.notice(), folder_.string() +
                                 ": 10 images are missing by the numbers of the names, 10 of them between 4.png and "
                                 "15.png, and count as 1.0 s at --fps 10; give --timestamps FILE if no time has passed "
                                 "there");
  EXPECT_EQ(source.count(), 9);
  const auto frames = ReadAll();
  EXPECT_EQ(frames[3].time, 0.3);
  EXPECT_EQ(frames[4].time, 1.4);
  EXPECT_EQ(ReadAll({.fps = 10, .start = 1.4}).size(), 5u);
  EXPECT_NE(Complaint({.fps = 0.05}).find("--fps 0.05: give the frames per second, not the seconds per frame"),
            std::string::npos);
  ImageSource part(FindDrive(folder_), {.fps = 10, .start = 1.4});
  EXPECT_EQ(part.notice(), "") << "what is missing is before it";
  Text("times.txt", "1\n2\n3\n4\n5\n6\n7\n8\n9\n");
  ImageSource timed(FindDrive(folder_), {});
  EXPECT_EQ(timed.notice(), "") << "the times tell";
  EXPECT_EQ(ReadAll({})[4].time, 5);
}

TEST_F(ImageSourceTest, ImagesOfTwoCamerasAreRefused) {
  for (const char* camera : {"left_", "right_"})
    for (int i = 0; i < 12; ++i) cv::imwrite((folder_ / (camera + std::to_string(i) + ".png")).string(), Image(i));
  EXPECT_EQ(Complaint(),
            folder_.string() +
                ": holds images of several cameras or drives, left_0.png to left_11.png (12 images) and "
                "right_0.png to right_11.png (12 images); give a folder with the images of one camera only");
}

TEST_F(ImageSourceTest, TheMaskIsNoFrame) {
  Images(folder_, 0, 3);
  fs::copy_file(folder_ / "0.png", folder_ / "mask.png");
  EXPECT_EQ(FindDrive(folder_).images.size(), 4u);
  EXPECT_EQ(FindDrive(folder_, {}, folder_ / "." / "mask.png").images.size(), 3u);
  Images(folder_ / "elsewhere", 0, 1);
  EXPECT_EQ(FindDrive(folder_, {}, folder_ / "elsewhere" / "0.png").images.size(), 4u) << "another of the same name";
  WriteTestVideo(folder_ / "elsewhere" / "v.mkv", {Image(1)}, {.codec = "ffv1"});
  EXPECT_EQ(FindDrive(folder_ / "elsewhere", {}, folder_ / "elsewhere" / "0.png").videos.size(), 1u);
}

TEST_F(ImageSourceTest, KindsOfTiffThatAreNotReadAreNamed) {
  const fs::path path = folder_ / "0.tif";
  cv::imwrite(path.string(), cv::Mat(48, 64, CV_32FC1, cv::Scalar(50)));
  const GrayImage read = ReadGrayImage(path);
  EXPECT_TRUE(read.gray.empty());
  EXPECT_EQ(read.problem.rfind("0.tif: is not a readable TIFF; ", 0), 0u) << read.problem;
}

TEST_F(ImageSourceTest, TruncatedFilesOfEveryKindAreNoticed) {
  for (const std::string name : {"0.png", "1.jpg", "2.bmp", "3.pgm", "4.ppm"}) {
    const fs::path path = folder_ / name;
    cv::Mat image = Image(7, {320, 240});
    if (name == "4.ppm") cv::merge(std::vector<cv::Mat>{image, image, image}, image);
    cv::imwrite(path.string(), image);
    EXPECT_EQ(ReadGrayImage(path).problem, "");
    for (const double part : {0.999, 0.6, 0.05}) {
      fs::resize_file(path, static_cast<uintmax_t>(static_cast<double>(fs::file_size(path)) * part));
      const GrayImage read = ReadGrayImage(path);
      EXPECT_TRUE(read.gray.empty());
      EXPECT_EQ(read.problem, name + ": is truncated") << part;
    }
  }
}

TEST_F(ImageSourceTest, DamagedImagesAnywhereAreSkippedAndNamed) {
  for (const int damaged : {0, 2, 4}) {
    Images(folder_, 0, 5);
    Truncate(folder_ / (std::to_string(damaged) + ".png"));
    const auto frames = ReadAll();
    ASSERT_EQ(frames.size(), 5u);
    for (const SourceFrame& frame : frames) {
      EXPECT_EQ(frame.gray.empty(), frame.index == damaged);
      EXPECT_EQ(frame.problem, frame.index == damaged ? std::to_string(damaged) + ".png: is truncated" : "");
    }
  }
}

TEST_F(ImageSourceTest, UnreadableImagesAreNamed) {
  Images(folder_, 0, 4);
  Text("1.png", "this is no image");
  Text("2.png", "");
  const auto frames = ReadAll();
  EXPECT_EQ(frames[1].problem, "1.png: is not a readable image");
  EXPECT_EQ(frames[2].problem, "2.png: is empty");
  EXPECT_FALSE(frames[3].gray.empty());
}

TEST_F(ImageSourceTest, NotOneReadableImageIsAnError) {
  Text("0.png", "x");
  Text("1.png", "y");
  EXPECT_NE(Complaint().find("not one of 2 frames could be read"), std::string::npos);
}

TEST_F(ImageSourceTest, SizesMustAgree) {
  Images(folder_, 0, 3);
  cv::imwrite((folder_ / "2.png").string(), Image(2, {60, 48}));
  const std::string complaint = Complaint();
  EXPECT_NE(complaint.find("2.png: is 60x48 pixels, but"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("0.png says 64x48; all images of a drive"), std::string::npos) << complaint;
  const std::string camera = Complaint({.fps = 10, .width = 640, .height = 480, .camera_file = "cam.yaml"});
  EXPECT_NE(camera.find("0.png: is 64x48 pixels, but cam.yaml says 640x480; all images need the calibration's size"),
            std::string::npos)
      << camera;
}

TEST_F(ImageSourceTest, TheResultsOfARunAreNoDrive) {
  Text("trajectory.csv", "");
  const std::string complaint = Complaint();
  EXPECT_NE(complaint.find("holds the results of a run"), std::string::npos) << complaint;
}

TEST_F(ImageSourceTest, TimesMayBeOfAnyUnit) {
  const std::vector<double> times =
      ReadFrameTimes(Text("t.txt", "1403636580000000\n1403636580100000\n1403636580200000\n")).times;
  EXPECT_EQ(times[0], 1403636580);
  EXPECT_NEAR(times[2] - times[0], 0.2, 1e-6);
  EXPECT_EQ(ReadFrameTimes(Text("t.txt", "1403636580\n1403636581\n")).times[1], 1403636581);
}

TEST_F(ImageSourceTest, NamesTimesBesideTheFolder) {
  const fs::path outer = folder_;
  const std::string times = Text("times.txt", "0\n1\n2\n").string();
  folder_ /= "image_0";
  Images(folder_, 0, 3);
  EXPECT_NE(Complaint({}).find("--fps X, such as --timestamps " + times), std::string::npos) << Complaint({});
  folder_ = outer;
}

TEST_F(ImageSourceTest, ComplaintsAboutTimesNameTheLine) {
  Images(folder_, 0, 3);
  const auto complaint = [&](const std::string& text) {
    const std::string message = Complaint({.timestamps = Text("t.txt", text)});
    return message.substr(std::min(message.size(), message.find("t.txt")));
  };
  EXPECT_NE(Complaint({}).find("times of the frames are missing; give --timestamps FILE or --fps X"),
            std::string::npos);
  EXPECT_NE(Complaint({.timestamps = "/nonexistent"}).find("no such file"), std::string::npos);
  EXPECT_NE(Complaint({.fps = 1e9}).find("--fps 1000000000: give the frames per second; at most 1000"),
            std::string::npos);
  EXPECT_NE(Complaint({.fps = 0}).find("--fps 0"), std::string::npos);
  EXPECT_NE(Complaint({.fps = std::nan("")}).find("--fps nan"), std::string::npos);
  EXPECT_TRUE(complaint("0\n1\n").starts_with("t.txt:2: ends after 2 times")) << complaint("0\n1\n");
  EXPECT_TRUE(complaint("0\n1\n2\n\n3\n").starts_with("t.txt:5: time 4 has no frame"));
  EXPECT_TRUE(complaint("0\n2\n1\n").starts_with("t.txt:3: time 1 goes back from the time before, 2"));
  EXPECT_TRUE(complaint("0\n1\n1\n").starts_with("t.txt:3: time 1 repeats the time before"));
  EXPECT_TRUE(complaint("0\nnan\n2\n").starts_with("t.txt:2: 'nan' is not a time"));
  EXPECT_TRUE(complaint("0\n1 1\n2\n").starts_with("t.txt:2: '1 1' is not a time"));
  EXPECT_TRUE(complaint("0\nx\n2\n").starts_with("t.txt:2: 'x' is not a time"));
  EXPECT_TRUE(complaint("# nothing\n").starts_with("t.txt: has no times"));
}

TEST_F(ImageSourceTest, MissingAndEmptyInputs) {
  EXPECT_THROW(FindDrive(folder_ / "nowhere"), InputError);
  EXPECT_NE(Complaint().find("holds no images"), std::string::npos);
  Text("front.mp4", "");
  Text("rear.mp4", "");
  EXPECT_NE(Complaint().find("front.mp4: is empty"), std::string::npos);
  Images(folder_ / "pictures", 0, 1);
  EXPECT_THROW(FindDrive(folder_ / "pictures" / "0.png"), InputError);
  EXPECT_THROW(ImageSource(FindDrive(Text("drive.mp4", "no video")), {}), InputError);
}

TEST_F(ImageSourceTest, VideoWithItsOwnRateOrTimestamps) {
  const fs::path video = folder_ / "drive.avi";
  std::vector<cv::Mat> images;
  for (int i = 0; i < 12; ++i) images.push_back(Image(10 * i));
  WriteTestVideo(video, images, {.codec = "mjpeg"});
  const auto frames = ReadAll({});
  ASSERT_EQ(frames.size(), 12u);
  for (int i = 0; i < 12; ++i) {
    EXPECT_NEAR(frames[i].gray.at<uint8_t>(8, 8), 10 * i, 4);
    EXPECT_DOUBLE_EQ(frames[i].time, i / 25.0);
  }
  std::string times;
  for (int i = 0; i < 12; ++i) times += std::to_string(100 + i) + "\n";
  EXPECT_EQ(ReadAll({.timestamps = Text("t.txt", times)})[11].time, 111);
  EXPECT_NE(Complaint({.timestamps = Text("t.txt", times + "200\n")}).find("t.txt:13: time 13 has no frame"),
            std::string::npos);
  EXPECT_NE(Complaint({.width = 640, .height = 48, .camera_file = "cam.yaml"}).find("frame 0: is 64x48"),
            std::string::npos);
}

TEST_F(ImageSourceTest, AFolderOfVideosIsOneDrive) {
  for (const int clip : {9, 10, 11}) {
    std::vector<cv::Mat> images;
    for (int i = 0; i < 5; ++i) images.push_back(Image(10 * clip + i));
    WriteTestVideo(folder_ / ("clip" + std::to_string(clip) + ".mkv"), images, {.codec = "ffv1"});
  }
  Text("calib.txt", "");
  EXPECT_EQ(FindDrive(folder_).camera_file, folder_ / "calib.txt");
  ImageSource source(FindDrive(folder_), {});
  EXPECT_EQ(source.count(), 15);
  for (int i = 0; i < 15; ++i) {
    const auto frame = source.Next();
    ASSERT_TRUE(frame.has_value());
    const int clip = i / 5;
    EXPECT_NEAR(frame->gray.at<uint8_t>(8, 8), 10 * (9 + clip) + i % 5, 1);
    EXPECT_NEAR(frame->time, i / 25.0, 1e-9);
  }
  EXPECT_FALSE(source.Next().has_value());
  ASSERT_EQ(source.clips().size(), 3u);
  EXPECT_EQ(source.clips()[1].file, (folder_ / "clip10.mkv").string());
  EXPECT_EQ(source.clips()[1].frames, 5);
  EXPECT_NEAR(source.clips()[1].start, 0.2, 1e-9);
  std::string times;
  for (int i = 0; i < 15; ++i) times += std::to_string(100 + i) + "\n";
  EXPECT_EQ(ReadAll({.timestamps = Text("t.txt", times)})[12].time, 112);

  const DriveInput two = FindDrive(std::vector<fs::path>{folder_ / "clip11.mkv", folder_ / "clip9.mkv"});
  EXPECT_EQ(two.videos.size(), 2u);
  EXPECT_EQ(two.videos.front(), folder_ / "clip11.mkv") << "the order given";
  const auto complaint = [](const std::vector<fs::path>& inputs) {
    try {
      FindDrive(inputs);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(complaint({folder_ / "clip9.mkv", folder_ / "." / "clip9.mkv"}).find("clip9.mkv: is given twice"),
            std::string::npos);
  EXPECT_NE(complaint({folder_, folder_ / "clip9.mkv"}).find("is a folder; give one folder, or several videos"),
            std::string::npos);
  EXPECT_NE(complaint({folder_ / "clip9.mkv", folder_ / "clip12.mkv"}).find("clip12.mkv: no such file"),
            std::string::npos);
}

TEST_F(ImageSourceTest, AMemoryCardIsOneDrive) {
  const auto write = [&](const fs::path& path) {
    fs::create_directories(path.parent_path());
    WriteTestVideo(path, {Image(1), Image(2)}, {.codec = "ffv1"});
  };
  write(folder_ / "100MEDIA" / "2.mkv");
  write(folder_ / "100MEDIA" / "10.mkv");
  write(folder_ / "101MEDIA" / "1.mkv");
  const std::vector<fs::path> found = FindDrive(folder_).videos;
  EXPECT_EQ(found, std::vector<fs::path>({folder_ / "100MEDIA" / "2.mkv", folder_ / "100MEDIA" / "10.mkv",
                                          folder_ / "101MEDIA" / "1.mkv"}));

  EXPECT_TRUE(FindDrive(folder_).several_folders);
  const fs::path media = folder_ / "100MEDIA";
  EXPECT_FALSE(FindDrive(media).several_folders);
  cv::imwrite((media / "10.jpg").string(), Image(1));
  EXPECT_EQ(FindDrive(media).videos.size(), 2u) << "a thumbnail";
  EXPECT_TRUE(FindDrive(media).images.empty());
  cv::imwrite((media / "11.jpg").string(), Image(1));
  try {
    FindDrive(media);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), media.string() +
                                             ": holds images (11.jpg) and videos (2.mkv); give the videos by name, or "
                                             "a folder of one kind");
  }
}

TEST_F(ImageSourceTest, ChaptersOfARecordingStandTogether) {
  for (const char* name : {"GX010124.MP4", "GX020123.MP4", "GX010123.MP4"}) Text(name, "");
  const DriveInput two = FindDrive(folder_);
  EXPECT_EQ(two.videos,
            std::vector<fs::path>({folder_ / "GX010123.MP4", folder_ / "GX020123.MP4", folder_ / "GX010124.MP4"}));
  EXPECT_TRUE(two.several_recordings);
  fs::remove(folder_ / "GX010124.MP4");
  EXPECT_FALSE(FindDrive(folder_).several_recordings);
}

TEST_F(ImageSourceTest, APartOfTheDriveKeepsItsTimes) {
  Images(folder_, 0, 20);
  std::string times;
  for (int i = 0; i < 20; ++i) times += std::to_string(1000 + i) + "\n";
  const fs::path file = Text("t.txt", times);
  const auto check = [](const std::vector<SourceFrame>& frames, double unit, double first_time) {
    ASSERT_EQ(frames.size(), 5u);
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(frames[i].index, i);
      EXPECT_NEAR(frames[i].time, first_time + unit * (5 + i), 1e-9);
      EXPECT_NEAR(frames[i].gray.at<uint8_t>(0, 0), 5 + i, 1);
    }
  };
  check(ReadAll({.fps = 10, .start = 0.5, .end = 1.0}), 0.1, 0);
  check(ReadAll({.timestamps = file, .start = 5, .end = 10}), 1, 1000);
  EXPECT_EQ(ImageSource(FindDrive(folder_), {.timestamps = file, .start = 5}).first_time(), 1000);
  EXPECT_EQ(ImageSource(FindDrive(folder_), {.fps = 10, .start = 0.5}).first_time(), 0);
  EXPECT_EQ(ReadAll({.fps = 10, .end = 100}).size(), 20u);
  EXPECT_NE(Complaint({.fps = 10, .start = 3}).find("--start 3 s: the drive ends at 1.9 s; give the time since"),
            std::string::npos);
  EXPECT_NE(Complaint({.fps = 10, .start = 0.51, .end = 0.52}).find("has no frame between them"), std::string::npos);
  EXPECT_NE(Complaint({.fps = 10, .start = 2, .end = 2}).find("--end 2 s: has to be after --start 2 s"),
            std::string::npos);
  EXPECT_EQ(Complaint({.fps = 10, .end = 0}), "--end 0 s: has to be after the drive's start");

  std::vector<cv::Mat> images;
  for (int i = 0; i < 20; ++i) {
    images.push_back(Image(i));
    fs::remove(folder_ / (std::to_string(i) + ".png"));
  }
  WriteTestVideo(folder_ / "v.mkv", images, {.codec = "ffv1", .ticks_per_second = 10});
  check(ReadAll({.start = 0.5, .end = 1.0}), 0.1, 0);
  check(ReadAll({.fps = 10, .start = 0.5, .end = 1.0}), 0.1, 0);
  check(ReadAll({.timestamps = file, .start = 5, .end = 10}), 1, 1000);
  for (const ImageSourceOptions& options : {ImageSourceOptions{}, {.timestamps = file}, {.fps = 100}}) {
    ImageSource source(FindDrive(folder_), options);
    while (source.Next()) EXPECT_EQ(source.EndsEarly(), "");
    EXPECT_EQ(source.EndsEarly(), "");
  }
  EXPECT_NE(Complaint({.start = 3}).find("--start 3 s: the drive ends at 1.9 s; give the time since"),
            std::string::npos);
  EXPECT_NE(Complaint({.start = 0.51, .end = 0.52}).find("has no frame between them"), std::string::npos);
}

TEST_F(ImageSourceTest, WhetherAPartLeavesImagesOut) {
  const auto expect_left_out = [&](const ImageSourceOptions& options, bool expected) {
    ImageSource source(FindDrive(folder_), options);
    while (source.Next()) continue;
    EXPECT_EQ(source.LeavesOut(), expected) << options.start << " to " << options.end.value_or(-1);
  };
  const auto expect_of_parts = [&](ImageSourceOptions options) {
    expect_left_out(options, false);
    options.end = 3600;
    expect_left_out(options, false);
    options.end = 1;
    expect_left_out(options, true);
    options.end.reset();
    options.start = 1;
    expect_left_out(options, true);
  };
  std::vector<cv::Mat> images;
  std::string times;
  for (int i = 0; i < 20; ++i) {
    images.push_back(Image(i));
    times += std::to_string(1000 + 0.1 * i) + "\n";
  }
  const fs::path file = Text("t.txt", times);
  Images(folder_, 0, 20);
  expect_of_parts({.fps = 10});
  expect_of_parts({.timestamps = file});
  for (int i = 0; i < 20; ++i) fs::remove(folder_ / (std::to_string(i) + ".png"));
  WriteTestVideo(folder_ / "v.mkv", images, {.codec = "ffv1", .ticks_per_second = 10});
  expect_of_parts({});
  expect_of_parts({.timestamps = file});
}

TEST_F(ImageSourceTest, AStartThatIsATimeOfDayIsTranslated) {
  std::vector<cv::Mat> images(20, Image(1));
  const auto complaint = [&](const std::string& name, const ImageSourceOptions& options) {
    const fs::path video = folder_ / name;
    WriteTestVideo(video, images, {.codec = "ffv1", .ticks_per_second = 10});
    const std::string text = Complaint(options);
    fs::remove(video);
    return text;
  };
  const std::string text = "the drive ends at 1.9 s; give the time since the drive's start";
  EXPECT_EQ(complaint("20230501_120000.mkv", {.start = 43201}),
            "--start 43201 s: " + text + ": --start 1 for 12:00:01, as its first video begins at 12:00:00 by its name");
  EXPECT_EQ(complaint("20230501_120000.mkv", {.start = 43203}), "--start 43203 s: " + text);
  EXPECT_EQ(complaint("a.mkv", {.start = 43201}), "--start 43201 s: " + text);
}

TEST_F(ImageSourceTest, WhatADriveLacksIsThatOfThePart) {
  for (const char* name : {"20230501_120000.mkv", "20230501_120007.mkv"})
    WriteTestVideo(folder_ / name, std::vector<cv::Mat>(20, Image(1)), {.codec = "ffv1", .ticks_per_second = 10});
  Text("20230501_120002.mkv", "no video");
  const auto lacks = [&](const ImageSourceOptions& options) {
    ImageSource source(FindDrive(folder_), options);
    while (source.Next()) continue;
    return source.Lacks();
  };
  const std::string why = "20230501_120002.mkv: cannot be decoded: a part of the drive is missing";
  EXPECT_EQ(lacks({}), why);
  EXPECT_EQ(lacks({.end = 1.5}), "");
  EXPECT_EQ(lacks({.end = 5}), why);
  EXPECT_EQ(lacks({.start = 7}), "");
  EXPECT_EQ(lacks({.start = 4}), why);
}

TEST_F(ImageSourceTest, AnEndInAGapIsNamed) {
  for (const char* name : {"20230501_120000.mkv", "20230501_120007.mkv"})
    WriteTestVideo(folder_ / name, std::vector<cv::Mat>(20, Image(1)), {.codec = "ffv1", .ticks_per_second = 10});
  const auto notice = [&](double end) {
    ImageSource source(FindDrive(folder_), {.end = end});
    while (source.Next()) EXPECT_EQ(source.NoticeAtEnd(), "") << end;
    return source.NoticeAtEnd();
  };
  EXPECT_EQ(notice(5), "--end lies in a gap of 5.0 s: the path ends 3.0 s earlier, at 2.0 s of the drive");
  EXPECT_EQ(notice(7), "--end lies in a gap of 5.0 s: the path ends 5.0 s earlier, at 2.0 s of the drive");
  for (const double end : {1.0, 2.0, 3.0, 7.5, 60.0}) EXPECT_EQ(notice(end), "") << end;
}

TEST(DriveTime, HoursMinutesAndSeconds) {
  EXPECT_EQ(ParseDriveTime("--start", "0"), 0);
  EXPECT_EQ(ParseDriveTime("--start", "750.25"), 750.25);
  EXPECT_EQ(ParseDriveTime("--start", "12:30"), 750);
  EXPECT_EQ(ParseDriveTime("--start", "90:00"), 5400);
  EXPECT_DOUBLE_EQ(ParseDriveTime("--start", "01:02:03.5"), 3723.5);
  for (const char* text :
       {"", "x", "-1", "1:", ":1", "1:60", "1:60:00", "1:2:3:4", "1.5:00", "nan", "inf", "1e3", "1 2"}) {
    try {
      ParseDriveTime("--end", text);
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("--end " + std::string(text) + ": is not a time")) << text;
    }
  }
}

TEST_F(ImageSourceTest, StopsCleanlyWhenLeftHalfWay) {
  Images(folder_, 0, 20);
  for (int taken = 0; taken < 8; ++taken) {
    ImageSource source(FindDrive(folder_), {.fps = 10});
    for (int i = 0; i < taken; ++i) ASSERT_EQ(source.Next()->index, i);
  }
}

}  // namespace
}  // namespace turnscale
