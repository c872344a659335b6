// SPDX-License-Identifier: MIT
#include "turnscale/simulation/image_output.h"

#include <fmt/format.h>

#include "turnscale/image_file/image_encoder.h"
#include "turnscale/io/output_file.h"

namespace turnscale {

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
    // Not for each of thousands does the disk have to be waited for.
    ReplaceFile(images_ / fmt::format("{:06}.png", count_), EncodePng(image), Durability::kProcess);
  }
  ++count_;
}

void ImageOutput::Finish() {
  if (video_) video_->Finish();
}

}  // namespace turnscale
