// SPDX-License-Identifier: MIT
#include "turnscale/mapping/map_archive.h"

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

constexpr float kSinglePrecision = 1e-4F;  // pixels

Map StreetMap() {
  const CarDrive drive = MakeCarDrive({{130, 0.8, 0}}, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  return MakeMap(drive, {.points_per_step = 10, .pixel_noise = 0.3});
}

TEST(MapArchive, GivesBackWhatItTook) {
  const Map whole = StreetMap();
  const int keyframes = CountKeyframes(whole);
  Map map = whole;
  MapArchive archive;
  archive.Retire(60, map);
  archive.Retire(keyframes, map);
  EXPECT_EQ(archive.end(), keyframes);
  EXPECT_TRUE(map.landmarks.empty());
  for (const Keyframe& keyframe : map.keyframes) EXPECT_EQ(keyframe.observations.capacity(), 0U);

  const ArchivedPart all = archive.Load(0, keyframes, map);
  ASSERT_EQ(all.map.keyframes.size(), whole.keyframes.size());
  ASSERT_EQ(all.map.landmarks.size(), whole.landmarks.size());
  for (int k = 0; k < keyframes; ++k) {
    const auto& seen = all.map.keyframes[k].observations;
    const auto& wanted = whole.keyframes[k].observations;
    ASSERT_EQ(seen.size(), wanted.size()) << k;
    for (size_t i = 0; i < seen.size(); ++i) {
      EXPECT_LT((seen[i].pixel - wanted[i].pixel).norm(), kSinglePrecision);
      EXPECT_EQ(all.map.landmarks[seen[i].landmark].position, whole.landmarks[wanted[i].landmark].position);
    }
  }
}

// The open files of this process in a folder, by their links.
int OpenFilesIn(const std::filesystem::path& folder) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    const std::filesystem::path file = std::filesystem::read_symlink(entry.path(), error);
    if (!error && file.parent_path() == folder) ++files;
  }
  return files;
}

TEST(MapArchive, UsesTheFolderForTemporaryFiles) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "map_archive_test";
  std::filesystem::create_directories(folder);
  const char* given = std::getenv("TMPDIR");
  const std::optional<std::string> before = given ? std::optional<std::string>(given) : std::nullopt;
  Map map = StreetMap();
  const auto retire = [&](const std::filesystem::path& temporary, MapArchive& archive, int last) {
    setenv("TMPDIR", temporary.c_str(), 1);
    archive.Retire(last, map);
  };
  MapArchive archive;
  retire(folder, archive, 60);
  EXPECT_EQ(OpenFilesIn(std::filesystem::canonical(folder)), 1);
  EXPECT_TRUE(std::filesystem::is_empty(folder)) << "it has no name";

  map = StreetMap();
  MapArchive elsewhere;
  retire(folder / "missing", elsewhere, 60);
  EXPECT_EQ(elsewhere.Load(0, 60, map).map.landmarks.size(), archive.Load(0, 60, map).map.landmarks.size());
  if (before) {
    setenv("TMPDIR", before->c_str(), 1);
  } else {
    unsetenv("TMPDIR");
  }
  std::filesystem::remove_all(folder);
}

TEST(MapArchive, LandmarksThatLaterKeyframesSeeStay) {
  const Map whole = StreetMap();
  Map map = whole;
  MapArchive archive;
  const std::vector<int> new_index = archive.Retire(60, map);
  ASSERT_EQ(new_index.size(), whole.landmarks.size());
  for (size_t i = 0; i < whole.landmarks.size(); ++i) {
    const bool stays = whole.landmarks[i].observations.back().keyframe >= 60;
    ASSERT_EQ(new_index[i] >= 0, stays) << i;
    if (!stays) continue;
    const Landmark& landmark = map.landmarks[new_index[i]];
    EXPECT_EQ(landmark.position, whole.landmarks[i].position);
    EXPECT_GE(landmark.observations.front().keyframe, 60);
    for (const LandmarkObservation& seen : landmark.observations) {
      const auto& of_keyframe = map.keyframes[seen.keyframe].observations;
      EXPECT_TRUE(std::ranges::any_of(of_keyframe, [&](const auto& o) { return o.landmark == new_index[i]; }));
    }
  }
}

TEST(MapArchive, ALandmarkOfTwoBlocksIsOneLandmark) {
  const Map whole = StreetMap();
  Map map = whole;
  MapArchive archive;
  archive.Retire(60, map);
  archive.Retire(CountKeyframes(map), map);
  const ArchivedPart all = archive.Load(0, archive.end(), map);
  EXPECT_EQ(archive.landmarks(), static_cast<int>(whole.landmarks.size()));
  EXPECT_EQ(std::set<int>(all.numbers.begin(), all.numbers.end()).size(), whole.landmarks.size());
}

TEST(MapArchive, LandmarksWithoutADepthAreLetGo) {
  Map map = StreetMap();
  map.landmarks[0].valid = false;
  const size_t landmarks = map.landmarks.size();
  MapArchive archive;
  archive.Retire(CountKeyframes(map), map);
  EXPECT_EQ(archive.Load(0, archive.end(), map).map.landmarks.size(), landmarks - 1);
}

TEST(MapArchive, BlocksAreBoundedAndEndAtGaps) {
  Map map = StreetMap();
  map.keyframes[70].after_gap = true;
  MapArchive archive;
  archive.Retire(131, map);
  EXPECT_EQ(archive.BlockEnds(), (std::vector<int>{35, 70, 100, 131}));
}

TEST(MapArchive, GivesOutWholeBlocksOnly) {
  Map map = StreetMap();
  MapArchive archive;
  archive.Retire(131, map);
  EXPECT_THROW(archive.Load(10, 131, map), InternalError);
}

TEST(MapArchive, RetiringNothingChangesNothing) {
  Map map = StreetMap();
  const size_t landmarks = map.landmarks.size();
  MapArchive archive;
  archive.Retire(0, map);
  EXPECT_EQ(archive.end(), 0);
  EXPECT_EQ(map.landmarks.size(), landmarks);
}

TEST(MapArchive, PixelsFollowTheCorrection) {
  Map map = StreetMap();
  const Eigen::Vector2d pixel = map.keyframes[3].observations[0].pixel;
  MapArchive archive;
  map.camera.radial_correction = 0.01;
  archive.Retire(50, map);
  map.camera.radial_correction = 0.02;
  const ArchivedPart part = archive.Load(0, 50, map);
  EXPECT_EQ(part.map.camera.radial_correction, 0.02);
  const Eigen::Vector2d ideal = UndoRadialCorrection(map.camera.pinhole, 0.01, pixel);
  EXPECT_LT((part.map.keyframes[3].observations[0].pixel - CorrectRadially(map.camera.pinhole, 0.02, ideal)).norm(),
            2 * kSinglePrecision);
}

TEST(MapArchive, KeepsChangedPositions) {
  Map map = StreetMap();
  MapArchive archive;
  archive.Retire(131, map);
  const std::vector<int> ends = archive.BlockEnds();
  ASSERT_EQ(ends.size(), 3U);
  ArchivedPart part = archive.Load(ends[0], ends[1], map);
  for (Landmark& landmark : part.map.landmarks) landmark.position += Eigen::Vector3d(1, 2, 3);
  archive.Store(part);
  const ArchivedPart again = archive.Load(ends[0], ends[1], map);
  ASSERT_EQ(again.numbers, part.numbers);
  for (size_t i = 0; i < part.numbers.size(); ++i)
    EXPECT_EQ(again.map.landmarks[i].position, part.map.landmarks[i].position);
}

}  // namespace
}  // namespace turnscale
