// SPDX-License-Identifier: MIT
#include "turnscale/io/trajectory_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <span>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"
#include "turnscale/io/run_files.h"
#include "turnscale/io/time_unit.h"

namespace turnscale {
namespace {

// Published files carry as few as four digits.
constexpr double kRotationTolerance = 1e-2;
constexpr double kLeastNanoseconds = 1e14;  // without being an integer; no clock counts such seconds
constexpr std::size_t kEurocColumns = 8;

RigidTransform PoseFromTum(std::span<const double> values, const std::string& where) {
  const Eigen::Quaterniond read(values[6], values[3], values[4], values[5]);
  return {RotationFromFile(read, where, "time tx ty tz qx qy qz qw"), {values[0], values[1], values[2]}};
}

RigidTransform PoseFromKitti(std::span<const double> values, const std::string& where) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> matrix(values.data());
  const Eigen::Matrix3d R = matrix.leftCols<3>();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance || R.determinant() < 0) {
    throw InputError(
        fmt::format("{}: the 3x3 part is not a rotation (off by {:.2g}); expected a row-major 3x4 pose", where, error));
  }
  // The nearest rotation: printed digits are never quite orthonormal.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return {Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())), matrix.col(3)};
}

std::vector<double> NumbersOf(const std::vector<std::string_view>& words, const std::string& where) {
  std::vector<double> values;
  for (const std::string_view word : words) {
    const auto value = ParseNumber<double>(word);
    if (!value || !std::isfinite(*value))
      throw InputError(fmt::format("{}: '{}' is not a finite number", where, Excerpt(word)));
    values.push_back(*value);
  }
  return values;
}

std::string Columns(size_t count) { return fmt::format("{} column{}", count, count == 1 ? "" : "s"); }

// Throws InputError where the first line names columns: a table, such as trajectory.csv or truth.csv, whose names
// suggest a trajectory file.
void RefuseTable(const std::vector<std::string_view>& words, const std::string& path) {
  const auto begins = [&](std::initializer_list<std::string_view> names) {
    return words.size() >= names.size() && std::equal(names.begin(), names.end(), words.begin());
  };
  if (begins({"frame", "time", "state"}))
    throw InputError(path +
                     ": is the table of the frames of a run, not a trajectory file; give trajectory.tum, which a run "
                     "writes beside it");
  if (begins({"frame", "time_s", "speed_mps"}))
    throw InputError(path +
                     ": is the table of a simulated car, not a trajectory file; give poses.txt, which simulate writes "
                     "beside it, or, for the speeds alone, calibrate --speed with this file");
  if (std::ranges::none_of(words, [](std::string_view word) { return ParseNumber<double>(word).has_value(); }))
    throw InputError(fmt::format(
        "{}: begins with '{}'; a trajectory has numbers, as TUM, KITTI and EuRoC write it; put # before a heading",
        path, Excerpt(words[0])));
}

class Parser {
 public:
  Parser(std::string path, const std::optional<std::vector<double>>& times) : path_(std::move(path)), times_(times) {}

  void Line(std::string text, const std::string& where) {
    const bool commas = text.find(',') != std::string::npos;
    std::replace(text.begin(), text.end(), ',', ' ');
    const auto words = SplitWords(text);
    if (words.empty() || words[0].starts_with('#')) return;
    if (columns_ == 0) RefuseTable(words, path_);
    if (commas) return AddEuroc(words, where);
    if (columns_ == 0) columns_ = words.size();
    if (columns_ != 8 && columns_ != 12 && columns_ != 13) {
      throw InputError(fmt::format("{}: {}; TUM has 8, KITTI 12 or 13", where, Columns(columns_)));
    }
    if (words.size() != columns_) {
      throw InputError(fmt::format("{}: {}, but the lines before have {}", where, Columns(words.size()), columns_));
    }
    const std::vector<double> values = NumbersOf(words, where);
    columns_ == 8 ? AddTum(values, where) : AddKitti(values, where);
  }

  TrajectoryFile Finish() && {
    if (file_.poses.empty()) throw InputError(path_ + ": holds no poses");
    const bool every_frame = columns_ == 12;
    if (every_frame && times_ && times_->size() != file_.poses.size()) {
      throw InputError(fmt::format("{}: {} poses, but {} times were given; give one time per pose", path_,
                                   file_.poses.size(), times_->size()));
    }
    if (file_.format != TrajectoryFormat::kKitti) ConvertTimes();
    return std::move(file_);
  }

 private:
  void ConvertTimes() {
    constexpr double kNanosecond = 1e-9;
    std::vector<double> times;
    for (const StampedPose& pose : file_.poses) times.push_back(pose.time);
    const bool nanoseconds = file_.format == TrajectoryFormat::kEuroc && AreNanoseconds(times);
    const double unit = nanoseconds ? kNanosecond : SecondsPerUnit(times);
    if (file_.format == TrajectoryFormat::kEuroc && unit == 1)
      throw InputError(
          fmt::format("{}: times {} and {} are too close for a EuRoC file, whose times are nanoseconds; give a TUM "
                      "file with blanks, not commas, between its columns",
                      path_, times[0], times[1]));
    for (StampedPose& pose : file_.poses) pose.time *= unit;
  }

  void AddEuroc(const std::vector<std::string_view>& words, const std::string& where) {
    file_.format = TrajectoryFormat::kEuroc;
    if (words.size() < kEurocColumns || (columns_ != 0 && words.size() != columns_)) {
      throw InputError(fmt::format("{}: {}; EuRoC has 'time [ns],px,py,pz,qw,qx,qy,qz' and optional further columns",
                                   where, Columns(words.size())));
    }
    columns_ = words.size();
    const std::vector<double> v = NumbersOf({words.begin(), words.begin() + kEurocColumns}, where);
    if (!ParseNumber<int64_t>(words[0]) && !(v[0] > kLeastNanoseconds)) {
      throw InputError(
          fmt::format("{}: time {}, but those of a EuRoC file are whole nanoseconds; give a TUM file with blanks, not "
                      "commas, between its columns",
                      where, Excerpt(words[0])));
    }
    AddTum(std::array{v[0], v[1], v[2], v[3], v[5], v[6], v[7], v[4]}, where);
  }

  void AddTum(std::span<const double> values, const std::string& where) {
    const double time = values[0];
    if (!file_.poses.empty() && time <= file_.poses.back().time) {
      throw InputError(
          fmt::format("{}: time {} does not come after {}; sort the file", where, time, file_.poses.back().time));
    }
    file_.poses.push_back({time, PoseFromTum(values.subspan(1), where)});
  }

  void AddKitti(std::span<const double> values, const std::string& where) {
    file_.format = TrajectoryFormat::kKitti;
    int frame = static_cast<int>(file_.frames.size());
    if (columns_ == 13) {
      if (values[0] != std::floor(values[0]) || values[0] < 0 || values[0] > 1e9) {
        throw InputError(
            fmt::format("{}: '{}' is not a frame number; a 13-column file begins with one", where, values[0]));
      }
      frame = static_cast<int>(values[0]);
      values = values.subspan(1);
    }
    if (!file_.frames.empty() && frame <= file_.frames.back()) {
      throw InputError(
          fmt::format("{}: frame {} does not come after {}; sort the file", where, frame, file_.frames.back()));
    }
    if (times_ && static_cast<size_t>(frame) >= times_->size()) {
      throw InputError(fmt::format("{}: frame {} has no time: only {} were given", where, frame, times_->size()));
    }
    file_.frames.push_back(frame);
    file_.poses.push_back({times_ ? (*times_)[frame] : frame, PoseFromKitti(values, where)});
  }

  std::string path_;
  const std::optional<std::vector<double>>& times_;
  size_t columns_ = 0;
  TrajectoryFile file_;
};

}  // namespace

std::filesystem::path TrajectoryOf(const std::filesystem::path& named) {
  std::error_code none;
  if (!std::filesystem::is_directory(named, none)) return named;
  std::filesystem::path file = named / RunFiles::kTrajectoryTum;
  if (std::filesystem::is_regular_file(file, none)) return file;
  throw InputError(named.string() +
                   ": is a folder without the trajectory.tum of a run; give the file of the trajectory");
}

TrajectoryFile ReadTrajectoryFile(const std::filesystem::path& path, const std::optional<std::vector<double>>& times) {
  TextLines lines(path, "trajectory file");
  Parser parser(path.string(), times);
  while (lines.Next()) parser.Line(lines.Line(), lines.Where());
  return std::move(parser).Finish();
}

Trajectory ReadTrajectory(const std::filesystem::path& path, const std::optional<std::vector<double>>& times) {
  return ReadTrajectoryFile(path, times).poses;
}

std::filesystem::path FindPoseTimes(const std::filesystem::path& kitti_poses) {
  namespace fs = std::filesystem;
  // Where a folder may not be examined, reading the poses says so.
  std::error_code error;
  fs::path beside = kitti_poses.parent_path() / "times.txt";
  if (fs::exists(beside, error)) return beside;
  fs::path benchmark =
      fs::absolute(kitti_poses, error).parent_path().parent_path() / "sequences" / kitti_poses.stem() / "times.txt";
  return fs::exists(benchmark, error) ? benchmark : fs::path();
}

Eigen::Quaterniond RotationFromFile(const Eigen::Quaterniond& read, const std::string& where,
                                    std::string_view columns) {
  const double norm = read.norm();
  if (!(std::abs(norm - 1) <= kRotationTolerance))
    throw InputError(fmt::format("{}: quaternion has norm {:.4g}, not 1; expected '{}'", where, norm, columns));
  return read.normalized();
}

std::array<double, 7> PoseNumbers(const RigidTransform& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  std::array<double, 7> numbers = {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
  for (double& number : numbers) number += 0.0;  // makes 0 of -0
  return numbers;
}

std::string TumLine(const StampedPose& pose) {
  std::string line = fmt::format("{:.6f}", pose.time);
  for (const double value : PoseNumbers(pose.world_from_camera))
    fmt::format_to(std::back_inserter(line), " {:.9g}", value);
  return line + "\n";
}

std::string KittiLine(const RigidTransform& world_from_camera, int digits) {
  Eigen::Matrix<double, 3, 4, Eigen::RowMajor> matrix;
  matrix << world_from_camera.rotation.toRotationMatrix(), world_from_camera.translation;
  std::string line;
  for (int i = 0; i < matrix.size(); ++i) {
    fmt::format_to(std::back_inserter(line), "{}{:.{}g}", i == 0 ? "" : " ", matrix.data()[i] + 0.0, digits);
  }
  return line + "\n";
}

}  // namespace turnscale
