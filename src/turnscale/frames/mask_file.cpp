// SPDX-License-Identifier: MIT
#include "turnscale/frames/mask_file.h"

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "turnscale/base/error.h"
#include "turnscale/base/input_file.h"
#include "turnscale/frames/frame_reader.h"

namespace turnscale {

cv::Mat ReadMask(const std::filesystem::path& path) {
  OpenInputFile(path, "mask");
  const GrayImage read = ReadGrayImage(path);
  const cv::Mat& mask = read.gray;
  // It begins with the name without the folder.
  if (mask.empty()) throw InputError((path.parent_path() / read.problem).string());
  if (cv::countNonZero(mask) == 0)
    throw InputError(path.string() + ": is black, which leaves out the whole image; paint what is to be kept white");
  double darkest = 0;
  cv::minMaxLoc(mask, &darkest);
  if (darkest > 0)
    throw InputError(
        fmt::format("{}: leaves nothing out: its darkest pixel has the gray level {:.0f}; paint what is to be left out "
                    "black (0), the rest white, and store it as PNG",
                    path.string(), darkest));
  return mask;
}

void CheckMaskSize(const std::filesystem::path& path, const cv::Mat& mask, const cv::Size& images) {
  if (mask.size() == images) return;
  throw InputError(fmt::format("{}: is {}x{} pixels, but the images are {}x{}; a mask needs their size", path.string(),
                               mask.cols, mask.rows, images.width, images.height));
}

}  // namespace turnscale
