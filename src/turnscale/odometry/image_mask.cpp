// SPDX-License-Identifier: MIT
#include "turnscale/odometry/image_mask.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <opencv2/imgproc.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

// Evidence is bounded, so that a cell that has shown the scene for long can become dirty, and the other way round.
constexpr double kMostEvidence = 2;
// No features are detected where pixels are left out. Their evidence fades at this rate per keyframe, so that the cell
// is looked at again after some hundreds.
constexpr double kFading = 0.01;
// In small images cells stay larger than the distance between features, pixels.
constexpr double kLeastCell = 16;

}  // namespace

void StaticRegionOptions::Check() const {
  if (columns < 4) throw InputError("columns: has to be at least 4");
  if (!(max_motion > 0)) throw InputError("max_motion: has to be positive");
  if (!(min_expected_motion > max_motion)) throw InputError("min_expected_motion: has to be above max_motion");
  if (min_evidence < 1) throw InputError("min_evidence: has to be at least 1");
}

double LeastSceneMotion(const Pinhole& pinhole, const RigidTransform& second_from_first,
                        const Eigen::Vector2d& undistorted) {
  const Eigen::Vector3d far = second_from_first.rotation * pinhole.Ray(undistorted);
  if (!(far.z() > 0)) return HUGE_VAL;
  // Nearer points lie on a line from where the infinitely far one is.
  const Eigen::Vector2d from_far = undistorted - pinhole.Project(far);
  const Eigen::Vector3d& t = second_from_first.translation;
  const Eigen::Vector2d nearer(pinhole.fx * (t.x() * far.z() - far.x() * t.z()),
                               pinhole.fy * (t.y() * far.z() - far.y() * t.z()));
  const double along = from_far.dot(nearer);
  if (!(along > 0)) return from_far.norm();
  return (from_far - along / nearer.squaredNorm() * nearer).norm();
}

bool HasStayed(const Landmark& landmark, const Eigen::Vector2d& undistorted, double max_motion) {
  return std::ranges::all_of(landmark.observations, [&](const LandmarkObservation& seen) {
    return (seen.pixel - undistorted).norm() <= max_motion;
  });
}

bool IsKept(const cv::Mat& mask, const cv::Point2f& point) {
  if (mask.empty()) return true;
  const int column = std::clamp(cvRound(point.x), 0, mask.cols - 1);
  const int row = std::clamp(cvRound(point.y), 0, mask.rows - 1);
  return mask.at<uchar>(row, column) != 0;
}

bool HidesBelow(const cv::Mat& mask) {
  // Of the lower half, more than a clock or a logo covers.
  constexpr double kLeastShare = 0.15;
  if (mask.empty()) return false;
  const cv::Mat above = mask.rowRange(0, mask.rows / 2);
  const cv::Mat below = mask.rowRange(mask.rows - above.rows, mask.rows);
  const int more = cv::countNonZero(above) - cv::countNonZero(below);
  return more >= kLeastShare * static_cast<double>(below.total());
}

void ImageMask::SetSize(const cv::Size& size) {
  if (!given_.empty() && given_.size() != size)
    throw InputError("mask: is " + std::to_string(given_.cols) + "x" + std::to_string(given_.rows) +
                     ", the images are " + std::to_string(size.width) + "x" + std::to_string(size.height));
  size_ = size;
  cell_size_ = std::max(kLeastCell, static_cast<double>(size.width) / options_.columns);
  columns_ = static_cast<int>(std::ceil(size.width / cell_size_));
  const int rows = static_cast<int>(std::ceil(size.height / cell_size_));
  cells_.assign(static_cast<size_t>(columns_) * rows, {});
  Render();
}

void ImageMask::SetGiven(const cv::Mat& mask) {
  Ensure(mask.type() == CV_8UC1, "a mask is an 8-bit gray image");
  given_ = mask != 0;
}

std::vector<int> ImageMask::Votes(const std::vector<ObservedMotion>& motion) {
  std::vector<int> votes(cells_.size(), 0);
  for (const ObservedMotion& feature : motion) {
    const int column = std::clamp(static_cast<int>(feature.pixel.x / cell_size_), 0, columns_ - 1);
    const int row = std::clamp(static_cast<int>(feature.pixel.y / cell_size_), 0, rows() - 1);
    const size_t cell = static_cast<size_t>(row) * columns_ + column;
    votes[cell] += feature.stands_still ? 1 : -1;
    cells_[cell].seen = true;
  }
  return votes;
}

void ImageMask::Observe(const std::vector<ObservedMotion>& motion) {
  const std::vector<int> votes = Votes(motion);
  bool changed = false;
  for (size_t i = 0; i < cells_.size(); ++i) {
    Cell& cell = cells_[i];
    const double limit = options_.min_evidence + kMostEvidence;
    cell.evidence = std::clamp(cell.evidence + std::clamp(votes[i], -1, 1), -kMostEvidence, limit);
    if (cell.left_out) cell.evidence -= kFading;
    const bool left_out = cell.evidence >= options_.min_evidence - (cell.left_out ? 1 : 0);
    changed |= left_out != cell.left_out;
    cell.left_out = left_out;
  }
  if (changed) Render();
}

void ImageMask::LeaveOut(const std::vector<ObservedMotion>& motion) {
  const std::vector<int> votes = Votes(motion);
  for (size_t i = 0; i < cells_.size(); ++i) {
    if (votes[i] <= 0) continue;
    cells_[i].evidence = options_.min_evidence + kMostEvidence;
    cells_[i].left_out = true;
  }
  Render();
}

bool ImageMask::IsLeftOut(int column, int row) const {
  const auto is_left_out = [&](int x, int y) {
    return x >= 0 && x < columns_ && y >= 0 && y < rows() && cells_[static_cast<size_t>(y) * columns_ + x].left_out;
  };
  if (is_left_out(column, row)) return true;
  // Too plain for a feature, but in the middle of what is left out.
  const bool seen = cells_[static_cast<size_t>(row) * columns_ + column].seen;
  return !seen && ((is_left_out(column - 1, row) && is_left_out(column + 1, row)) ||
                   (is_left_out(column, row - 1) && is_left_out(column, row + 1)));
}

void ImageMask::Render() {
  // Copies that were handed out stay as they are.
  cv::Mat pixels = given_.empty() ? cv::Mat(size_, CV_8U, cv::Scalar(255)) : given_.clone();
  for (size_t i = 0; i < cells_.size(); ++i) {
    const int column = static_cast<int>(i) % columns_;
    const int row = static_cast<int>(i) / columns_;
    if (!IsLeftOut(column, row)) continue;
    const cv::Point begin(cvRound(column * cell_size_), cvRound(row * cell_size_));
    const cv::Point end(cvRound((column + 1) * cell_size_), cvRound((row + 1) * cell_size_));
    pixels(cv::Rect(begin, end) & cv::Rect({}, size_)).setTo(0);
  }
  pixels_ = cv::countNonZero(pixels) < static_cast<int>(pixels.total()) ? pixels : cv::Mat();
}

}  // namespace turnscale
