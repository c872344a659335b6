// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace turnscale {

/// The numbers in the names of consecutive images, such as 551 of img_0551.png, and by how much they usually increase.
class ImageNumbers {
 public:
  /// Of images in natural order. Nothing if their names differ in more than one number, or that number is a time (a
  /// date and time of day, or 1e9 and more), or the numbers do not increase in multiples of one step, by which at least
  /// half of them do.
  static std::optional<ImageNumbers> Find(const std::vector<std::filesystem::path>& images);

  /// Times of the images at so many images per second, from 0. Missing images take time.
  std::vector<double> TimesAt(double fps) const;

  /// One line if images from `first` to before `last` seem to be missing, or were picked from more; else empty.
  std::string Notice(const std::vector<std::filesystem::path>& images, double fps, size_t first, size_t last) const;

 private:
  ImageNumbers(std::vector<int64_t> positions, int64_t step) : positions_(std::move(positions)), step_(step) {}

  std::vector<int64_t> positions_;  // of each image, in steps from the first one
  int64_t step_;
};

/// Throws InputError if the names of most images are of two or more kinds, such as left_0001.png and right_0001.png:
/// they are of several cameras or drives, which would be processed one after another. `folder`: for the message.
void RefuseSeveralSeries(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& images);

/// One line if the numbers of the names repeat, as in cam0_0001.png and cam1_0001.png: the images may be of several
/// cameras, or of parts of one drive that have the same length. Else empty.
std::string RepeatedNumbersNotice(const std::vector<std::filesystem::path>& images);

}  // namespace turnscale
