// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace turnscale {

/// How a test's video is written. The extension of its name chooses the container.
struct TestVideo {
  std::string codec = "mpeg4";       ///< of libavcodec
  int ticks_per_second = 25;         ///< unit of `stamps`, and frames per second without them
  std::vector<int64_t> stamps = {};  ///< of each frame, ticks; empty: evenly spaced
  int b_frames = 0;                  ///< between two frames that others refer to
  int key_interval = 12;             ///< frames
  int bits = 8;                      ///< 8 or 10
  bool full_range = false;           ///< of luma, rather than 16 to 235
  int quarter_turns = 0;             ///< clockwise, by which a player is to rotate the images
  bool mirrored = false;             ///< a player is to mirror the images left to right, after rotating them
  double pixel_aspect = 1;           ///< width of a pixel over its height
  bool interlaced = false;
  std::string created = {};               ///< ISO 8601
  std::vector<cv::Mat> first_track = {};  ///< gray or BGR images of a track before the one that players choose
};

/// Writes gray or BGR images of one size.
void WriteTestVideo(const std::filesystem::path& path, const std::vector<cv::Mat>& images, const TestVideo& video = {});

/// `count` images (160x90) of a texture that moves by the same distance from one to the next, from the `first` on.
std::vector<cv::Mat> MovingTestImages(int first, int count);

}  // namespace turnscale
