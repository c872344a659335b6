// SPDX-License-Identifier: MIT
#include "turnscale/simulation/image_output.h"

#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "turnscale/base/error.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

// Noise cannot be packed: higher levels only take longer.
constexpr int kPngLevel = 1;

void WriteImage(const std::filesystem::path& path, const cv::Mat& image) {
  std::vector<uchar> bytes;
  if (!cv::imencode(".png", image, bytes, {cv::IMWRITE_PNG_COMPRESSION, kPngLevel})) {
    throw OutputError(path.string() + ": the image cannot be encoded as PNG");
  }
  // Not for each of thousands does the disk have to be waited for.
  ReplaceFile(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, Durability::kProcess);
}

}  // namespace

ImageOutput::ImageOutput(const std::filesystem::path& folder, const Rig& rig) : images_(folder / kImageFolder) {
  if (!rig.recorder.video) return;
  VideoWriterOptions options;
  options.rate_hz = rig.rate_hz;
  options.megabits_per_second = rig.recorder.megabits_per_second;
  video_.emplace(folder / kVideoFile, cv::Size(rig.camera.width, rig.camera.height), options);
}

void ImageOutput::Write(const cv::Mat& image, double stamp) {
  if (video_) {
    video_->Add(image, stamp);
  } else {
    WriteImage(images_ / fmt::format("{:06}.png", count_), image);
  }
  ++count_;
}

void ImageOutput::Finish() {
  if (video_) video_->Finish();
}

}  // namespace turnscale
