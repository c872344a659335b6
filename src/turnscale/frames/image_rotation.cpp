// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_rotation.h"

#include <cstdint>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"

namespace turnscale {
namespace {

constexpr int kQuarter = 90;  // degrees

// By a quarter clockwise: what was on the left is at the top. The tangential coefficients (p2, p1) turn as a vector.
void TurnByQuarter(CameraModel& camera, int rotated_width) {
  Pinhole& pinhole = camera.pinhole;
  pinhole = {pinhole.fy, pinhole.fx, rotated_width - 1 - pinhole.cy, pinhole.cx};
  std::swap(camera.width, camera.height);
  if (camera.lens != LensModel::kRadialTangential) return;
  double& p1 = camera.distortion[2];
  double& p2 = camera.distortion[3];
  std::tie(p1, p2) = std::pair(p2, -p1);
}

}  // namespace

void CheckRotation(int degrees) {
  if (degrees % kQuarter != 0 || degrees < 0 || degrees >= 4 * kQuarter)
    throw InputError(fmt::format("--rotate {}: give 90, 180 or 270 degrees, clockwise", degrees));
}

cv::Mat Rotated(const cv::Mat& image, int degrees) {
  if (image.empty() || degrees == 0) return image;
  constexpr int kCodes[] = {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180, cv::ROTATE_90_COUNTERCLOCKWISE};
  cv::Mat rotated;
  cv::rotate(image, rotated, kCodes[degrees / kQuarter - 1]);
  return rotated;
}

ReadDirection ReadDirectionAfter(const std::function<cv::Mat(const cv::Mat&)>& turned) {
  const cv::Mat rows = (cv::Mat_<uint8_t>(2, 2) << 0, 0, 1, 1);
  const cv::Mat after = turned(rows);
  return {after.at<uint8_t>(0, 1) - after.at<uint8_t>(0, 0), after.at<uint8_t>(1, 0) - after.at<uint8_t>(0, 0)};
}

ReadDirection Rotated(const ReadDirection& read, int degrees) {
  ReadDirection rotated = read;
  for (int quarter = 0; quarter < degrees / kQuarter; ++quarter) rotated = {-rotated.y, rotated.x};
  return rotated;
}

CameraModel Rotated(CameraModel stored, int degrees, const cv::Size& rotated) {
  const int quarters = degrees / kQuarter;
  // Of the images between, every second one has the sides of the last one.
  for (int left = quarters - 1; left >= 0; --left)
    TurnByQuarter(stored, left % 2 == 0 ? rotated.width : rotated.height);
  if (stored.is_read_direction_stated) stored.read_direction = Rotated(stored.read_direction, degrees);
  return stored;
}

}  // namespace turnscale
