// SPDX-License-Identifier: MIT
// Optical flow or ORB matching? Finds corners of one frame again some frames later, both ways, and holds what was
// found against the epipolar lines of the true motion. Prints a Markdown table.
#include <algorithm>
#include <ctime>
#include <iostream>
#include <vector>

#include <CLI/CLI.hpp>
#include <Eigen/LU>
#include <fmt/format.h>
#include <opencv2/features2d.hpp>
#include <opencv2/video/tracking.hpp>

#include "turnscale/base/error.h"
#include "turnscale/camera/camera_file.h"
#include "turnscale/features/corners.h"
#include "turnscale/frames/image_source.h"
#include "turnscale/geometry/rotation.h"
#include "turnscale/io/trajectory_file.h"

namespace turnscale {
namespace {

constexpr int kCells = 4000;              // each gives at most one corner; sky and road leave most of them empty
constexpr double kShortestTravel = 0.1;   // metres; below it the epipolar lines mean nothing
constexpr float kMaxReturnError = 1.0F;   // pixels, optical flow forth and back
constexpr float kMatchingRatio = 0.8F;    // nearest to second nearest descriptor
constexpr float kMatchingRadius = 80.0F;  // pixels around the prediction
constexpr int kMatchingMaxDistance = 64;  // bits of 256
const std::vector<int> kGaps = {1, 2, 3, 5, 8};

struct Match {
  cv::Point2f first;
  cv::Point2f last;
};
using Matches = std::vector<Match>;

// CPU time, so that other work on the machine does not show.
class Stopwatch {
 public:
  double Milliseconds() const { return 1e3 * static_cast<double>(std::clock() - start_) / CLOCKS_PER_SEC; }

 private:
  std::clock_t start_ = std::clock();
};

class TrueMotion {
 public:
  TrueMotion(const Pinhole& pinhole, const RigidTransform& world_from_first, const RigidTransform& world_from_last)
      : last_from_first_(world_from_last.inverse() * world_from_first) {
    Eigen::Matrix3d K;
    K << pinhole.fx, 0, pinhole.cx, 0, pinhole.fy, pinhole.cy, 0, 0, 1;
    const Eigen::Matrix3d back = K.inverse();
    const Eigen::Matrix3d R = last_from_first_.rotation.toRotationMatrix();
    fundamental_ = back.transpose() * Skew(last_from_first_.translation) * R * back;
    at_infinity_ = K * R * back;
  }

  double Travel() const { return last_from_first_.translation.norm(); }

  double EpipolarError(const Match& match) const {
    const Eigen::Vector3d line = fundamental_ * Eigen::Vector3d(match.first.x, match.first.y, 1);
    return std::abs(line.dot(Eigen::Vector3d(match.last.x, match.last.y, 1))) / line.head<2>().norm();
  }

  // Where the pixel would go if only the camera's rotation moved it.
  cv::Point2f Predict(const cv::Point2f& pixel) const {
    const Eigen::Vector2d last = (at_infinity_ * Eigen::Vector3d(pixel.x, pixel.y, 1)).hnormalized();
    return {static_cast<float>(last.x()), static_cast<float>(last.y())};
  }

 private:
  RigidTransform last_from_first_;
  Eigen::Matrix3d fundamental_;
  Eigen::Matrix3d at_infinity_;
};

using Pyramid = std::vector<cv::Mat>;

Pyramid BuildPyramid(const cv::Mat& gray) {
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(gray, pyramid, {21, 21}, 3);
  return pyramid;
}

// Forward and backward optical flow with 21x21 pixels on 4 levels; `matches[i].last` moves on or the match goes.
void Flow(const Pyramid& first, const Pyramid& last, std::vector<cv::Point2f> guesses, Matches& matches) {
  if (matches.empty()) return;
  std::vector<cv::Point2f> points;
  for (const Match& match : matches) points.push_back(match.last);
  std::vector<uchar> found;
  std::vector<uchar> found_back;
  const cv::TermCriteria criteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 0.01);
  cv::calcOpticalFlowPyrLK(first, last, points, guesses, found, cv::noArray(), {21, 21}, 3, criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  std::vector<cv::Point2f> back = points;
  cv::calcOpticalFlowPyrLK(last, first, guesses, back, found_back, cv::noArray(), {21, 21}, 3, criteria,
                           cv::OPTFLOW_USE_INITIAL_FLOW);
  const cv::Rect2f inside(0, 0, static_cast<float>(last[0].cols), static_cast<float>(last[0].rows));
  Matches kept;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (!found[i] || !found_back[i] || !inside.contains(guesses[i])) continue;
    if (cv::norm(back[i] - points[i]) > kMaxReturnError) continue;
    kept.push_back({matches[i].first, guesses[i]});
  }
  matches = std::move(kept);
}

struct OrbFrame {
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
};

// ORB over 8 levels; of an oversupply, the strongest of each grid cell.
OrbFrame ExtractOrb(const cv::Mat& gray) {
  const auto orb = cv::ORB::create(4 * kCells, 1.2F, 8, 31, 0, 2, cv::ORB::HARRIS_SCORE, 31, 10);
  std::vector<cv::KeyPoint> all;
  orb->detect(gray, all);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.response > b.response; });
  const double cell = std::sqrt(static_cast<double>(gray.total()) / kCells);
  const int columns = static_cast<int>(gray.cols / cell) + 1;
  std::vector<bool> taken(static_cast<size_t>(columns) * (static_cast<size_t>(gray.rows / cell) + 1), false);
  OrbFrame frame;
  for (const cv::KeyPoint& keypoint : all) {
    const auto place =
        static_cast<size_t>(static_cast<int>(keypoint.pt.y / cell) * columns + static_cast<int>(keypoint.pt.x / cell));
    if (taken[place]) continue;
    taken[place] = true;
    frame.keypoints.push_back(keypoint);
  }
  orb->compute(gray, frame.keypoints, frame.descriptors);
  return frame;
}

// Nearest descriptor both ways, and clearly nearer than the second; within `radius` of the predictions if given.
Matches MatchOrb(const OrbFrame& first, const OrbFrame& last, const TrueMotion* prediction) {
  cv::Mat allowed;
  if (prediction != nullptr) {
    allowed = cv::Mat::zeros(first.descriptors.rows, last.descriptors.rows, CV_8U);
    for (int i = 0; i < allowed.rows; ++i) {
      const cv::Point2f expected = prediction->Predict(first.keypoints[i].pt);
      uchar* row = allowed.ptr<uchar>(i);
      for (int j = 0; j < allowed.cols; ++j) {
        const cv::Point2f offset = last.keypoints[j].pt - expected;
        row[j] = offset.dot(offset) < kMatchingRadius * kMatchingRadius ? 1 : 0;
      }
    }
  }
  const cv::BFMatcher matcher(cv::NORM_HAMMING);
  std::vector<std::vector<cv::DMatch>> forth;
  std::vector<std::vector<cv::DMatch>> back;
  matcher.knnMatch(first.descriptors, last.descriptors, forth, 2, allowed);
  matcher.knnMatch(last.descriptors, first.descriptors, back, 1, allowed.empty() ? cv::Mat() : cv::Mat(allowed.t()));
  Matches matches;
  for (const auto& nearest : forth) {
    if (nearest.empty() || nearest[0].distance > kMatchingMaxDistance) continue;
    if (nearest.size() > 1 && nearest[0].distance > kMatchingRatio * nearest[1].distance) continue;
    const auto& returned = back[nearest[0].trainIdx];
    if (returned.empty() || returned[0].trainIdx != nearest[0].queryIdx) continue;
    matches.push_back({first.keypoints[nearest[0].queryIdx].pt, last.keypoints[nearest[0].trainIdx].pt});
  }
  return matches;
}

struct Tally {
  int pairs = 0;
  size_t detected = 0;
  double milliseconds = 0;
  std::vector<double> errors;

  void Add(const Matches& matches, size_t corners, const TrueMotion& motion, double time) {
    ++pairs;
    detected += corners;
    milliseconds += time;
    for (const Match& match : matches) errors.push_back(motion.EpipolarError(match));
  }

  std::string Row(const std::string& method, int gap) {
    if (errors.empty()) return "";
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    const auto share = [&](double limit) {
      return 100.0 *
             static_cast<double>(std::count_if(errors.begin(), errors.end(), [&](double e) { return e < limit; })) /
             static_cast<double>(errors.size());
    };
    const double found = static_cast<double>(errors.size()) / pairs;
    return fmt::format("| {} | {} | {} | {:.0f} | {:.1f} | {:.1f} | {:.0f} | {:.2f} | {:.1f} |\n", gap, method,
                       detected / pairs, found, share(1), share(2), found * share(1) / 100, *middle,
                       milliseconds / pairs);
  }
};

struct Drive {
  Pinhole pinhole;
  Trajectory truth;
  std::vector<cv::Mat> images;  // of frames first, first + 1, ...
  int first = 0;
};

Drive Load(const std::string& input, const std::string& camera, const std::string& poses, int first, int last) {
  Drive drive;
  drive.first = first;
  drive.pinhole = ReadCameraFile(camera).pinhole;
  drive.truth = ReadTrajectory(poses);
  ImageSource source(FindDrive(input), {.fps = 10});
  while (auto frame = source.Next()) {
    if (frame->index > last) break;
    if (frame->gray.empty()) throw InputError(frame->problem);
    if (frame->index >= first) drive.images.push_back(frame->gray.clone());
  }
  if (drive.truth.size() < first + drive.images.size()) throw InputError(poses + ": fewer poses than frames");
  return drive;
}

std::string Measure(const Drive& drive, int gap, int stride) {
  Tally chained;
  Tally direct;
  Tally brute_force;
  Tally windowed;
  CornerOptions corner_options;
  corner_options.target = kCells;
  corner_options.min_distance = 8;
  for (size_t k = 0; k + gap < drive.images.size(); k += stride) {
    const TrueMotion motion(drive.pinhole, drive.truth[drive.first + k].world_from_camera,
                            drive.truth[drive.first + k + gap].world_from_camera);
    if (motion.Travel() < kShortestTravel) continue;
    const cv::Mat& first = drive.images[k];
    const cv::Mat& last = drive.images[k + gap];

    const Stopwatch detection;
    Matches start;
    for (const cv::Point2f& corner : DetectCorners(corner_options, first, {})) start.push_back({corner, corner});
    const double detection_time = detection.Milliseconds();

    const Stopwatch chained_time;
    Matches matches = start;
    Pyramid previous = BuildPyramid(first);
    for (int i = 1; i <= gap; ++i) {
      Pyramid next = BuildPyramid(drive.images[k + i]);
      std::vector<cv::Point2f> guesses;
      for (const Match& match : matches) guesses.push_back(match.last);
      Flow(previous, next, std::move(guesses), matches);
      previous = std::move(next);
    }
    chained.Add(matches, start.size(), motion, detection_time + chained_time.Milliseconds() / gap);

    const Stopwatch direct_time;
    matches = start;
    std::vector<cv::Point2f> guesses;
    for (const Match& match : matches) guesses.push_back(motion.Predict(match.first));
    Flow(BuildPyramid(first), BuildPyramid(last), std::move(guesses), matches);
    direct.Add(matches, start.size(), motion, detection_time + direct_time.Milliseconds());

    const OrbFrame orb_first = ExtractOrb(first);
    const Stopwatch extraction;
    const OrbFrame orb_last = ExtractOrb(last);
    const double extraction_time = extraction.Milliseconds();
    const Stopwatch matching;
    matches = MatchOrb(orb_first, orb_last, nullptr);
    brute_force.Add(matches, orb_first.keypoints.size(), motion, extraction_time + matching.Milliseconds());
    const Stopwatch window_matching;
    matches = MatchOrb(orb_first, orb_last, &motion);
    windowed.Add(matches, orb_first.keypoints.size(), motion, extraction_time + window_matching.Milliseconds());
  }
  return chained.Row("flow, frame by frame", gap) + direct.Row("flow, in one step", gap) +
         brute_force.Row("ORB, whole image", gap) + windowed.Row("ORB, 80 px window", gap);
}

}  // namespace
}  // namespace turnscale

int main(int argc, char** argv) {
  CLI::App app{"Compares optical flow with ORB matching on the frames of a drive whose true motion is known"};
  std::string input;
  std::string camera;
  std::string poses;
  int first = 0;
  int last = 1 << 30;
  int stride = 5;
  app.add_option("INPUT", input, "folder or video of the drive")->required();
  app.add_option("--camera", camera, "camera file")->required();
  app.add_option("--poses", poses, "true camera poses, one a frame")->required();
  app.add_option("--first", first, "first frame");
  app.add_option("--last", last, "last frame");
  app.add_option("--stride", stride, "frames from one measurement to the next")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);
  try {
    const turnscale::Drive drive = turnscale::Load(input, camera, poses, first, last);
    std::cout
        << "| gap, frames | method | corners | found | < 1 px, % | < 2 px, % | found < 1 px | median error, px | ms |\n"
           "|--:|:--|--:|--:|--:|--:|--:|--:|--:|\n";
    for (const int gap : turnscale::kGaps) std::cout << turnscale::Measure(drive, gap, stride) << std::flush;
  } catch (const turnscale::InputError& error) {
    std::cerr << "feature_tracking: " << error.what() << "\n";
    return 2;
  }
  return 0;
}
