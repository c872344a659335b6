// SPDX-License-Identifier: MIT
#include "turnscale/bag/camera_info.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

constexpr std::string_view kCompressedTransport = "/compressed";

std::string_view WithoutTransport(std::string_view topic) {
  if (topic.ends_with(kCompressedTransport)) topic.remove_suffix(kCompressedTransport.size());
  return topic;
}

[[noreturn]] void RefuseInfo(const std::string& where, const std::string& why) {
  throw InputError(fmt::format("{}: {}; give --camera FILE", where, why));
}

void CheckWholeImage(const BagCameraInfo& info, const std::string& where) {
  if (info.binning_x > 1 || info.binning_y > 1)
    RefuseInfo(where, fmt::format("binning {} x {} is not supported", info.binning_x, info.binning_y));
  const auto [x, y, height, width] = info.roi;
  // Zero stands for the whole image.
  const bool all = x == 0 && y == 0 && (height == 0 || height == info.height) && (width == 0 || width == info.width);
  if (!all) RefuseInfo(where, "a region of interest is not supported");
}

LensModel LensOf(const BagCameraInfo& info, const std::string& where) {
  const std::string model = info.distortion_model.substr(0, 32);
  const size_t count = info.d.size();
  if (model == "equidistant" || model == "fisheye") {
    if (count != 4) RefuseInfo(where, fmt::format("{} has 4 coefficients, not {}", model, count));
    return LensModel::kEquidistant;
  }
  constexpr std::array<std::string_view, 4> kRadial = {"", "plumb_bob", "radtan", "rational_polynomial"};
  if (std::find(kRadial.begin(), kRadial.end(), model) == kRadial.end())
    RefuseInfo(where, fmt::format("distortion model '{}' is not supported", Printable(model)));
  if (count != 0 && count < 4) RefuseInfo(where, fmt::format("{} has 5 coefficients, not {}", model, count));
  if (std::any_of(info.d.begin() + static_cast<std::ptrdiff_t>(std::min<size_t>(count, 5)), info.d.end(),
                  [](double k) { return k != 0; })) {
    RefuseInfo(where, fmt::format("{} with more than k1 k2 p1 p2 k3 is not supported", model));
  }
  const bool plain = std::all_of(info.d.begin(), info.d.end(), [](double k) { return k == 0; });
  return plain ? LensModel::kPinhole : LensModel::kRadialTangential;
}

}  // namespace

std::string CameraInfoTopic(std::string_view image_topic) {
  const std::string_view topic = WithoutTransport(image_topic);
  const size_t slash = topic.rfind('/');
  return std::string(slash == std::string_view::npos ? "" : topic.substr(0, slash + 1)) + "camera_info";
}

bool IsRectified(std::string_view image_topic) {
  const std::string_view topic = WithoutTransport(image_topic);
  const size_t slash = topic.rfind('/');
  return topic.substr(slash == std::string_view::npos ? 0 : slash + 1).starts_with("image_rect");
}

std::optional<CameraModel> CameraOf(const BagCameraInfo& info, bool rectified, const std::string& where) {
  const auto& k = info.k;
  const auto& p = info.p;
  const std::array<double, 9> matrix =
      rectified ? std::array<double, 9>{p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]} : k;
  const auto zero = [](double value) { return value == 0; };
  if (std::all_of(matrix.begin(), matrix.end(), zero)) return std::nullopt;
  const auto finite = [](double value) { return std::isfinite(value); };
  if (!std::all_of(matrix.begin(), matrix.end(), finite) || !std::all_of(info.d.begin(), info.d.end(), finite))
    RefuseInfo(where, "a parameter is not a finite number");
  if (!(matrix[0] > 0) || !(matrix[4] > 0))
    RefuseInfo(where, fmt::format("focal length {:g} x {:g} is not above 0", matrix[0], matrix[4]));
  if (matrix[1] != 0 || matrix[3] != 0 || matrix[6] != 0 || matrix[7] != 0 || matrix[8] != 1)
    RefuseInfo(where, "the camera matrix is not of the form [fx 0 cx; 0 fy cy; 0 0 1]");
  if (info.width > INT_MAX || info.height > INT_MAX) RefuseInfo(where, "the image size is not a size");
  CheckWholeImage(info, where);
  CameraModel camera;
  camera.pinhole = {matrix[0], matrix[4], matrix[2], matrix[5]};
  if (info.width > 0 && info.height > 0) {
    camera.width = static_cast<int>(info.width);
    camera.height = static_cast<int>(info.height);
  }
  if (rectified) return camera;
  camera.lens = LensOf(info, where);
  std::copy_n(info.d.begin(), std::min(info.d.size(), camera.distortion.size()), camera.distortion.begin());
  return camera;
}

}  // namespace turnscale
