// SPDX-License-Identifier: MIT
#include "turnscale/io/trajectory_file.h"

#include <filesystem>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"
#include "turnscale/geometry/random_vector.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

fs::path Path(const std::string& name) { return ScratchPath(name); }

std::string TrajectoryComplaint(const std::string& text,
                                const std::optional<std::vector<double>>& times = std::nullopt) {
  std::ofstream(Path("bad.txt")) << text;
  try {
    ReadTrajectory(Path("bad.txt"), times);
  } catch (const InputError& error) {
    const std::string message = error.what();
    return message.substr(std::min(message.size(), message.find("bad.txt")));
  }
  return "no error";
}

Trajectory RandomTrajectory(int count) {
  std::mt19937 random(21);
  std::normal_distribution<double> normal;
  Trajectory poses;
  for (int i = 0; i < count; ++i) {
    const auto vector = [&] { return DrawVector<3>([&] { return normal(random); }); };
    poses.push_back({1.4e9 + 0.1 * i, {RotationFromVector(vector()), 1000 * vector()}});
  }
  return poses;
}

void WriteTum(const Trajectory& poses) {
  std::ofstream stream(Path("a.tum"));
  for (const StampedPose& pose : poses) stream << TumLine(pose);
}

void WriteKitti(const Trajectory& poses) {
  std::ofstream stream(Path("a.kitti.txt"));
  for (const StampedPose& pose : poses) stream << KittiLine(pose.world_from_camera);
}

void ExpectNear(const Trajectory& a, const Trajectory& b) {
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) {
    EXPECT_LT((a[i].world_from_camera.translation - b[i].world_from_camera.translation).norm(), 1e-5);
    EXPECT_LT(a[i].world_from_camera.rotation.angularDistance(b[i].world_from_camera.rotation), 1e-8);
  }
}

TEST(TrajectoryFile, ReadsEurocCsv) {
  std::ofstream(Path("a.csv")) << "#timestamp [ns],p_x [m],p_y [m],p_z [m],q_w [],q_x [],q_y [],q_z [],v_x,v_y,v_z\n"
                                  "1403636580838555648,4.5,-1.25,0.75,0.5,-0.5,0.5,0.5,0,0,0\r\n"
                                  "1403636580888555520, 5.5, -1.25, 0.75, 1, 0, 0, 0, 1, 2, 3\n";
  const TrajectoryFile file = ReadTrajectoryFile(Path("a.csv"));
  EXPECT_EQ(file.format, TrajectoryFormat::kEuroc);
  ASSERT_EQ(file.poses.size(), 2u);
  EXPECT_TRUE(file.frames.empty());
  EXPECT_NEAR(file.poses[0].time, 1403636580.838555648, 1e-6);
  EXPECT_EQ(file.poses[0].world_from_camera.translation, Eigen::Vector3d(4.5, -1.25, 0.75));
  EXPECT_LT(file.poses[0].world_from_camera.rotation.angularDistance(Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5)), 1e-12);
  EXPECT_NE(TrajectoryComplaint("1,2,3\n").find("EuRoC has"), std::string::npos);
  EXPECT_NE(TrajectoryComplaint("1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,x\n").find("bad.txt:2: 'x' is not a finite number"),
            std::string::npos);
}

TEST(TrajectoryFile, EurocTimesAreWholeNanoseconds) {
  EXPECT_EQ(TrajectoryComplaint("0.1,1,2,3,0,0,0,1\n0.2,1,2,3,0,0,0,1\n"),
            "bad.txt:1: time 0.1, but those of a EuRoC file are whole nanoseconds; give a TUM file with blanks, not "
            "commas, between its columns");
  EXPECT_TRUE(TrajectoryComplaint("0,1,2,3,1,0,0,0\n0.1,1,2,3,1,0,0,0\n").starts_with("bad.txt:2: time 0.1, but"));
  EXPECT_TRUE(TrajectoryComplaint("0,1,2,3,1,0,0,0\n1,1,2,3,1,0,0,0\n").starts_with("bad.txt: times 0 and 1 are too "));
  EXPECT_EQ(TrajectoryComplaint("1403636580838555648.0,1,2,3,1,0,0,0\n"), "no error") << "no clock counts such seconds";
}

TEST(TrajectoryFile, TimesMayBeOfAnyUnit) {
  for (const double unit : {1.0, 1e-3, 1e-6, 1e-9}) {
    std::ofstream tum(Path("a.tum"));
    std::ofstream euroc(Path("a.csv"));
    for (int i = 0; i < 5; ++i) {
      const double time = (1403636580 + 0.05 * i) / unit;
      tum << fmt::format("{:.2f} 0 0 {} 0 0 0 1\n", time, i);
      euroc << fmt::format("{:.0f},0,0,{},1,0,0,0\n", time, i);
    }
    tum.close();
    euroc.close();
    for (const fs::path& path : {Path("a.tum"), Path("a.csv")}) {
      if (unit == 1 && path.extension() == ".csv") continue;
      const Trajectory poses = ReadTrajectory(path);
      EXPECT_NEAR(poses[0].time, 1403636580, 1e-3) << path << " " << unit;
      EXPECT_NEAR(poses[4].time - poses[0].time, 0.2, 1e-3) << path << " " << unit;
    }
  }
}

TEST(TrajectoryFile, TumRoundTrip) {
  const Trajectory poses = RandomTrajectory(20);
  WriteTum(poses);
  const TrajectoryFile read = ReadTrajectoryFile(Path("a.tum"));
  EXPECT_EQ(read.format, TrajectoryFormat::kTum);
  EXPECT_TRUE(read.frames.empty());
  ExpectNear(read.poses, poses);
  EXPECT_NEAR(read.poses[7].time, poses[7].time, 1e-6);
}

TEST(TrajectoryFile, KittiRoundTripWithAndWithoutTimes) {
  const Trajectory poses = RandomTrajectory(5);
  WriteKitti(poses);
  const TrajectoryFile read = ReadTrajectoryFile(Path("a.kitti.txt"));
  EXPECT_EQ(read.format, TrajectoryFormat::kKitti);
  EXPECT_EQ(read.frames, (std::vector<int>{0, 1, 2, 3, 4}));
  ExpectNear(read.poses, poses);
  EXPECT_EQ(read.poses[3].time, 3);
  EXPECT_EQ(ReadTrajectory(Path("a.kitti.txt"), std::vector<double>{0, 2, 4, 6, 8})[3].time, 6);
}

TEST(TrajectoryFile, ThirteenColumnsBeginWithTheFrame) {
  std::ofstream(Path("13.txt")) << "# frame, pose\n2 1 0 0 5 0 1 0 0 0 0 1 0\n4 1 0 0 6 0 1 0 0 0 0 1 0\n";
  const TrajectoryFile read = ReadTrajectoryFile(Path("13.txt"), std::vector<double>{0, .1, .2, .3, .4, .5});
  EXPECT_EQ(read.frames, (std::vector<int>{2, 4}));
  EXPECT_EQ(read.poses[1].time, 0.4);
  EXPECT_EQ(read.poses[1].world_from_camera.translation.x(), 6);
}

TEST(TrajectoryFile, TheTableOfARunNamesTheFileToGive) {
  std::ofstream(Path("trajectory.csv"))
      << "frame,time,state,x,y,z,qx,qy,qz,qw,scale_state\n0,0,tracked,0,0,0,0,0,0,1,held\n";
  try {
    ReadTrajectoryFile(Path("trajectory.csv"));
    ADD_FAILURE() << "is read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.what(), Path("trajectory.csv").string() +
                                ": is the table of the frames of a run, not a trajectory file; give trajectory.tum, "
                                "which a run writes beside it");
  }
}

TEST(TrajectoryFile, ATableOfOtherThingsIsToldByItsHeading) {
  EXPECT_NE(TrajectoryComplaint("frame,time_s,speed_mps,yaw_rate_degps\n0,0.1,5,0\n").find("give poses.txt, which"),
            std::string::npos);
  EXPECT_NE(TrajectoryComplaint("time,speed\n0.1,5\n").find("begins with 'time'"), std::string::npos);
  EXPECT_NE(TrajectoryComplaint("1 0 0 0 0 0 0 1\ntime tx ty tz qx qy qz qw\n").find("'time' is not a finite number"),
            std::string::npos)
      << "no heading";
}

TEST(TrajectoryFile, LinesAreAsTheFormatsSay) {
  const RigidTransform pose{Eigen::Quaterniond::Identity(), {1.5, -2, 1.0 / 3}};
  EXPECT_EQ(TumLine({12.5, pose}), "12.500000 1.5 -2 0.333333333 0 0 0 1\n");
  EXPECT_EQ(KittiLine(pose), "1 0 0 1.5 0 1 0 -2 0 0 1 0.333333333\n");
}

TEST(TrajectoryFile, NoZeroHasASign) {
  const RigidTransform pose{Eigen::Quaterniond::Identity().conjugate(), {-0.0, -1, -0.0}};
  EXPECT_EQ(TumLine({0, pose}), "0.000000 0 -1 0 0 0 0 1\n");
  EXPECT_EQ(KittiLine(pose).find("-0"), std::string::npos) << KittiLine(pose);
}

TEST(TrajectoryFile, TimesAreFoundOnlyWhereTheyCanBeExamined) {
  const fs::path loop = Path("loop");
  fs::create_symlink(loop, loop);
  EXPECT_EQ(FindPoseTimes(loop / "poses.txt"), fs::path());
  const fs::path folder = Path("folder");
  fs::create_directory(folder);
  std::ofstream(folder / "times.txt") << "0\n";
  EXPECT_EQ(FindPoseTimes(folder / "poses.txt"), folder / "times.txt");
}

TEST(TrajectoryFile, ComplaintsNameTheLine) {
  const std::string tum = "0 1 2 3 0 0 0 1\n";
  const std::string kitti = "1 0 0 5 0 1 0 0 0 0 1 0\n";
  EXPECT_TRUE(TrajectoryComplaint("").starts_with("bad.txt: holds no poses"));
  EXPECT_TRUE(TrajectoryComplaint("1\n").starts_with("bad.txt:1: 1 column;"));
  EXPECT_TRUE(TrajectoryComplaint("1 2 3\n").starts_with("bad.txt:1: 3 columns"));
  EXPECT_TRUE(
      TrajectoryComplaint(tum + "1 1 2 3 0 0 0\n").starts_with("bad.txt:2: 7 columns, but the lines before have 8"));
  EXPECT_TRUE(TrajectoryComplaint("# c\n" + tum + "1 1 nan 3 0 0 0 1\n")
                  .starts_with("bad.txt:3: 'nan' is not a finite number"));
  EXPECT_TRUE(TrajectoryComplaint(tum + "1 1 2 x 0 0 0 1\n").starts_with("bad.txt:2: 'x' is not a finite number"));
  EXPECT_TRUE(TrajectoryComplaint(tum + "1 1 2 3 0 0 0 0.5\n").starts_with("bad.txt:2: quaternion has norm 0.5"));
  EXPECT_TRUE(TrajectoryComplaint(tum + tum).starts_with("bad.txt:2: time 0 does not come after 0"));
  EXPECT_TRUE(TrajectoryComplaint(kitti + "1 0 0 5 0 1 0 0 0 0 -1 0\n")
                  .starts_with("bad.txt:2: the 3x3 part is not a rotation"));
  EXPECT_TRUE(
      TrajectoryComplaint("2 0 0 5 0 1 0 0 0 0 1 0\n").starts_with("bad.txt:1: the 3x3 part is not a rotation"));
  EXPECT_TRUE(TrajectoryComplaint(kitti + kitti, std::vector<double>{0}).starts_with("bad.txt:2: frame 1 has no time"));
  EXPECT_TRUE(TrajectoryComplaint(kitti, std::vector<double>{0, 1}).starts_with("bad.txt: 1 poses, but 2 times"));
  EXPECT_TRUE(TrajectoryComplaint("0.5 " + kitti).starts_with("bad.txt:1: '0.5' is not a frame number"));
  EXPECT_TRUE(TrajectoryComplaint("3 " + kitti + "3 " + kitti).starts_with("bad.txt:2: frame 3 does not come after 3"));
  EXPECT_THROW(ReadTrajectory(Path("nowhere")), InputError);
  EXPECT_THROW(ReadTrajectory(::testing::TempDir()), InputError);
}

}  // namespace
}  // namespace turnscale
