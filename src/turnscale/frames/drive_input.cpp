// SPDX-License-Identifier: MIT
#include "turnscale/frames/drive_input.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "turnscale/bag/bag_reader.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/file_extension.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"
#include "turnscale/frames/clip_names.h"
#include "turnscale/frames/image_numbers.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/time_unit.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

bool HasExtension(const fs::path& path, std::initializer_list<std::string_view> extensions) {
  return std::find(extensions.begin(), extensions.end(), LowerExtension(path)) != extensions.end();
}

bool IsImageName(const fs::path& path) {
  return HasExtension(path, {".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm", ".tif", ".tiff"});
}

bool IsVideoName(const fs::path& path) {
  return HasExtension(
      path, {".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts", ".3gp", ".wmv"});
}

bool IsBagName(const fs::path& path) { return HasExtension(path, {".mcap", ".db3"}); }

// The entries of a folder for which `wanted` holds, in natural order. The hidden companions that some file systems
// write are left out.
template <class Predicate>
std::vector<fs::path> EntriesIn(const fs::path& folder, const Predicate& wanted) {
  std::error_code error;
  std::vector<fs::path> found;
  fs::directory_iterator entries(folder, error);
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    if (wanted(*entries) && !entries->path().filename().string().starts_with('.')) found.push_back(entries->path());
  }
  if (error) throw InputError(folder.string() + ": cannot be listed: " + error.message());
  std::sort(found.begin(), found.end(), [](const fs::path& a, const fs::path& b) {
    return NaturalLess(a.filename().string(), b.filename().string());
  });
  return found;
}

// A folder named like an image is no frame.
std::vector<fs::path> FilesIn(const fs::path& folder, bool (*wanted)(const fs::path& path)) {
  return EntriesIn(folder, [&](const fs::directory_entry& entry) {
    std::error_code error;
    return wanted(entry.path()) && !entry.is_directory(error);
  });
}

std::vector<fs::path> FoldersIn(const fs::path& folder) {
  return EntriesIn(folder, [](const fs::directory_entry& entry) {
    std::error_code error;
    return entry.is_directory(error);
  });
}

std::optional<fs::path> FileIn(const fs::path& folder, const char* name) {
  std::error_code error;
  return fs::is_regular_file(folder / name, error) ? std::optional(folder / name) : std::nullopt;
}

std::vector<fs::path> VideosIn(const fs::path& folder) {
  std::vector<fs::path> videos = FilesIn(folder, IsVideoName);
  std::sort(videos.begin(), videos.end(), [](const fs::path& a, const fs::path& b) {
    return ClipNameLess(a.filename().string(), b.filename().string());
  });
  return videos;
}

// The videos of a folder, or of the folders in it, as memory cards have them: DCIM/100MEDIA, DCIM/101MEDIA.
std::vector<fs::path> VideosOf(const fs::path& folder, bool also_below) {
  std::vector<fs::path> videos = VideosIn(folder);
  if (!videos.empty() || !also_below) return videos;
  for (const fs::path& below : FoldersIn(folder)) {
    // Such as lost+found.
    if (std::error_code error; fs::directory_iterator(below, error), error) continue;
    const std::vector<fs::path> more = VideosIn(below);
    videos.insert(videos.end(), more.begin(), more.end());
  }
  return videos;
}

// Cameras put a picture of each video beside it.
bool IsThumbnail(const fs::path& image, const std::vector<fs::path>& videos) {
  return std::any_of(videos.begin(), videos.end(), [&](const fs::path& video) { return video.stem() == image.stem(); });
}

// Whether the names tell that the camera was stopped and started between two of the videos.
bool AreOfSeveralRecordings(const std::vector<fs::path>& videos) {
  std::set<int> recordings;
  for (const fs::path& video : videos)
    if (const auto chapter = ChapterInName(video.stem().string())) recordings.insert(chapter->recording);
  return recordings.size() > 1;
}

// A mask often lies beside the images that it is for.
bool IsMask(const fs::path& image, const fs::path& mask) {
  std::error_code error;
  return image.filename() == mask.filename() && fs::equivalent(image, mask, error);
}

void RefuseTopic(const std::string& topic, const fs::path& input) {
  if (!topic.empty()) throw InputError(fmt::format("--topic {}: {} is not a bag", topic, input.string()));
}

// The parts of a bag of ROS 2, which keeps them with a description in a folder of their own; empty for other folders.
std::vector<fs::path> PartsOfBag(const fs::path& folder) {
  return FileIn(folder, "metadata.yaml") ? FilesIn(folder, IsBagName) : std::vector<fs::path>();
}

DriveInput FindInFolder(const fs::path& folder, const std::string& topic, const fs::path& mask) {
  DriveInput drive;
  drive.path = folder;
  drive.camera_file = FileIn(folder, "calib.txt");
  (drive.camera_file ? drive.unused_camera_file : drive.camera_file) = FileIn(folder, "camera.yaml");
  drive.times_file = FileIn(folder, "times.txt");
  if (FileIn(folder, "drive.yaml") && !drive.times_file) {
    throw InputError(folder.string() + ": is an incomplete simulated drive; simulate it again");
  }
  std::error_code error;
  for (const char* name : {"image_0", "images"}) {
    if (!fs::is_directory(folder / name, error)) continue;
    drive.path = folder / name;
    break;
  }
  drive.images = FilesIn(drive.path, IsImageName);
  if (drive.path == folder) drive.videos = VideosOf(folder, drive.images.empty());
  std::erase_if(drive.images,
                [&](const fs::path& image) { return IsThumbnail(image, drive.videos) || IsMask(image, mask); });
  if (!drive.images.empty() && !drive.videos.empty()) {
    throw InputError(fmt::format(
        "{}: holds images ({}) and videos ({}); give the videos by name, or a folder of one kind", folder.string(),
        drive.images.front().filename().string(), drive.videos.front().filename().string()));
  }
  // With a time for each, they are one drive, however they are named.
  if (!drive.times_file) RefuseSeveralSeries(drive.path, drive.images);
  drive.several_folders = std::any_of(drive.videos.begin(), drive.videos.end(), [&](const fs::path& video) {
    return video.parent_path() != drive.videos.front().parent_path();
  });
  drive.several_recordings = AreOfSeveralRecordings(drive.videos);
  if (drive.videos.size() == 1) drive.path = drive.videos.front();
  if (!drive.images.empty() || !drive.videos.empty()) {
    RefuseTopic(topic, drive.path);
    return drive;
  }
  if (const std::vector<fs::path> bags = PartsOfBag(folder); !bags.empty()) {
    drive.bags = FindBagDrive(bags, topic);
    return drive;
  }
  if (HasPosesOfRun(folder))
    throw InputError(folder.string() + ": holds the results of a run; give the images or videos of a drive");
  throw InputError(
      drive.path.string() +
      ": holds no images or videos, nor do its subfolders hold videos; give a folder of png, jpg, bmp, pgm or "
      "tiff files, a KITTI folder with image_0/, a video, a folder of videos, or a bag");
}

}  // namespace

FrameTimes ReadFrameTimes(const std::filesystem::path& path) {
  FrameTimes result;
  for (TextLines lines(path, "file of frame times"); lines.Next();) {
    const auto words = SplitWords(lines.Line());
    if (words.empty() || words[0].starts_with('#')) continue;
    const auto time = ParseNumber<double>(words[0]);
    if (words.size() != 1 || !time || !std::isfinite(*time)) {
      throw InputError(fmt::format("{}: '{}' is not a time; give one number per line, in seconds", lines.Where(),
                                   Excerpt(fmt::format("{}", fmt::join(words, " ")))));
    }
    if (!result.times.empty() && *time <= result.times.back()) {
      throw InputError(fmt::format("{}: time {} {} the time before, {}; times must increase", lines.Where(), *time,
                                   *time < result.times.back() ? "goes back from" : "repeats", result.times.back()));
    }
    result.times.push_back(*time);
    result.lines.push_back(lines.Number());
  }
  if (result.times.empty()) throw InputError(path.string() + ": has no times; give one number per line, in seconds");
  result.times = InSeconds(std::move(result.times));
  RefuseSparseTimes(path.string(), result.times);
  return result;
}

void CheckTimesMatch(const FrameTimes& times, const std::filesystem::path& path, size_t frames,
                     const std::string& frames_of) {
  if (times.times.size() < frames) {
    throw InputError(fmt::format("{}:{}: ends after {} times, but {} has {} frames; give one time per frame",
                                 path.string(), times.lines.back(), times.times.size(), frames_of, frames));
  }
  if (times.times.size() > frames) {
    throw InputError(fmt::format("{}:{}: time {} has no frame: {} has only {}; give one time per frame", path.string(),
                                 times.lines[frames], frames + 1, frames_of, frames));
  }
}

bool NaturalLess(std::string_view a, std::string_view b) {
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  const auto digits_at = [&](std::string_view text) {
    size_t size = 0;
    while (size < text.size() && is_digit(text[size])) ++size;
    return text.substr(0, size);
  };
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view run_a = digits_at(a);
      const std::string_view run_b = digits_at(b);
      const auto value = [](std::string_view run) {
        return run.substr(std::min(run.find_first_not_of('0'), run.size()));
      };
      const std::string_view value_a = value(run_a);
      const std::string_view value_b = value(run_b);
      if (value_a.size() != value_b.size()) return value_a.size() < value_b.size();
      if (value_a != value_b) return value_a < value_b;
      a.remove_prefix(run_a.size());
      b.remove_prefix(run_b.size());
    } else {
      if (a.front() != b.front()) return a.front() < b.front();
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  if (a.empty() != b.empty()) return a.empty();
  // Names equal but for leading zeros still need one fixed order.
  return whole_a < whole_b;
}

DriveInput FindDrive(const fs::path& input, const std::string& topic, const fs::path& mask) {
  return FindDrive(std::vector{input}, topic, mask);
}

DriveInput FindDrive(const std::vector<fs::path>& inputs, const std::string& topic, const fs::path& mask) {
  DriveInput drive;
  std::vector<fs::path> bags;
  for (const fs::path& input : inputs) {
    std::error_code error;
    const fs::file_status status = fs::status(input, error);
    if (status.type() == fs::file_type::not_found) throw InputError(input.string() + ": no such file or folder");
    if (error) throw InputError(input.string() + ": cannot be opened: " + error.message());
    if (fs::is_directory(status)) {
      if (inputs.size() == 1) return FindInFolder(input, topic, mask);
      throw InputError(input.string() + ": is a folder; give one folder, or several videos or bags");
    }
    if (IsImageName(input)) throw InputError(input.string() + ": is a single image; give the folder of the drive");
    std::vector<fs::path>& same_kind = IsBag(input) ? bags : drive.videos;
    for (const fs::path& other : same_kind) {
      if (fs::equivalent(input, other, error)) throw InputError(input.string() + ": is given twice");
    }
    same_kind.push_back(input);
  }
  drive.path = inputs.front();
  if (!bags.empty() && !drive.videos.empty()) {
    throw InputError(fmt::format("{}: is a bag, but {} is not; give files of one kind", bags.front().string(),
                                 drive.videos.front().string()));
  }
  if (bags.empty()) {
    RefuseTopic(topic, drive.path);
  } else {
    drive.bags = FindBagDrive(bags, topic);
  }
  return drive;
}

double ParseDriveTime(const std::string& option, std::string_view text) {
  const std::string_view whole = text;
  const auto refuse = [&] {
    return InputError(
        fmt::format("{} {}: is not a time; give HH:MM:SS, MM:SS or seconds, such as 12:30 or 750", option, whole));
  };
  double seconds = 0;
  for (int fields = 1;; ++fields) {
    const size_t colon = text.find(':');
    const bool last = colon == std::string_view::npos;
    const std::string_view field = text.substr(0, colon);
    const auto value = ParseNumber<double>(field);
    const bool has_digits_only = field.find_first_not_of(last ? "0123456789." : "0123456789") == std::string_view::npos;
    if (!value || !has_digits_only || fields > 3 || (fields > 1 && *value >= 60)) throw refuse();
    seconds = 60 * seconds + *value;
    if (last) return seconds;
    text.remove_prefix(colon + 1);
  }
}

}  // namespace turnscale
