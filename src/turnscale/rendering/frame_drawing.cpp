// SPDX-License-Identifier: MIT
#include "turnscale/rendering/frame_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "turnscale/base/error.h"
#include "turnscale/base/parallel.h"
#include "turnscale/base/random.h"

namespace turnscale {
namespace {

// Neighbours whose distances differ by more than this part of the nearer one are not of one surface.
constexpr float kDistanceStep = 0.1F;
// Each of several rays through a pixel gathers over so much of its width.
constexpr float kSampleWidth = 0.5F;

// Points of a pixel, from its centre: a lattice of which every row and column has one, so that edges of all directions
// are found and the mean is the centre. `shuffle`: rows in an order that has nothing to do with the columns'.
std::vector<Eigen::Vector2f> PixelPattern(int count, bool shuffle) {
  std::vector<int> rows(count);
  int stride = std::max(1, static_cast<int>(std::lround(0.382 * count)));
  while (std::gcd(stride, count) != 1) ++stride;
  for (int i = 0; i < count; ++i) rows[i] = i * stride % count;
  std::vector<int> columns(count);
  std::iota(columns.begin(), columns.end(), 0);
  if (shuffle) {
    Random random(3);
    for (int i = count - 1; i > 0; --i) std::swap(columns[i], columns[random.Below(i + 1)]);
  }
  std::vector<Eigen::Vector2f> pattern;
  for (int i = 0; i < count; ++i)
    pattern.emplace_back((static_cast<float>(columns[i]) + 0.5F) / static_cast<float>(count) - 0.5F,
                         (static_cast<float>(rows[i]) + 0.5F) / static_cast<float>(count) - 0.5F);
  return pattern;
}

// The pattern as one pixel uses it. Samples of neighbouring rows and columns interleave, and half of the pixels have it
// mirrored: along an edge, whatever its slope, pixels together find it more finely than each alone.
class VariedPattern {
 public:
  VariedPattern(const std::vector<Eigen::Vector2f>& pattern, int row, int column) : pattern_(pattern) {
    const auto place = (static_cast<std::uint64_t>(row) << 32U) + static_cast<std::uint64_t>(column);
    if ((Hash(place) & 1U) != 0) mirror_ = -1;
    const auto shift = [&](int index) {
      return (static_cast<float>(index % 4) - 1.5F) / (4 * static_cast<float>(pattern.size()));
    };
    shift_ = {shift(row), shift(column)};
  }

  Eigen::Vector2f operator[](size_t sample) const {
    return {mirror_ * pattern_[sample].x() + shift_.x(), pattern_[sample].y() + shift_.y()};
  }

 private:
  const std::vector<Eigen::Vector2f>& pattern_;
  float mirror_ = 1;
  Eigen::Vector2f shift_;
};

Ray MakeRay(const CameraMoment& moment, const Eigen::Vector3f& direction, float width) {
  Ray ray;
  ray.origin = moment.position;
  ray.direction = moment.world_from_camera * direction;
  ray.time = moment.time;
  ray.width = width;
  return ray;
}

// Rays that gather until they make a packet.
class PacketQueue {
 public:
  explicit PacketQueue(const Tracer& tracer) : tracer_(tracer) {}

  template <typename Use>
  void Add(const Ray& ray, int tag, const Use& use) {
    rays_[count_] = ray;
    tags_[count_++] = tag;
    if (count_ == kPacket) Finish(use);
  }

  template <typename Use>
  void Finish(const Use& use) {
    tracer_.Trace({rays_.data(), count_}, {seen_.data(), count_});
    for (size_t i = 0; i < count_; ++i) use(tags_[i], seen_[i]);
    count_ = 0;
  }

 private:
  const Tracer& tracer_;
  std::array<Ray, kPacket> rays_;
  std::array<Seen, kPacket> seen_;
  std::array<int, kPacket> tags_ = {};
  size_t count_ = 0;
};

struct Centres {
  cv::Mat brightness;  // CV_32F
  cv::Mat distance;    // CV_32F
  cv::Mat look;        // CV_32S
};

// Which pixels of a row show something else than a neighbour of theirs above, below, or to the side.
std::vector<uchar> EdgesOfRow(const Centres& centres, int row) {
  const int columns = centres.look.cols;
  std::vector<uchar> edges(columns, 0);
  const auto* look = centres.look.ptr<int>(row);
  const auto* distance = centres.distance.ptr<float>(row);
  const auto compare = [&](const int* looks, const float* distances, int shift) {
    for (int column = std::max(0, -shift); column < columns - std::max(0, shift); ++column) {
      const float here = distance[column];
      const float there = distances[column + shift];
      const bool step = std::abs(here - there) > kDistanceStep * std::min(here, there);
      edges[column] |= static_cast<uchar>((look[column] != looks[column + shift]) | step);
    }
  };
  compare(look, distance, -1);
  compare(look, distance, 1);
  if (row > 0) compare(centres.look.ptr<int>(row - 1), centres.distance.ptr<float>(row - 1), 0);
  if (row + 1 < centres.look.rows) compare(centres.look.ptr<int>(row + 1), centres.distance.ptr<float>(row + 1), 0);
  return edges;
}

Centres DrawCentres(const FrameDrawing& drawing) {
  const cv::Size size(drawing.table.camera().width, drawing.table.camera().height);
  Centres centres = {cv::Mat(size, CV_32F, cv::Scalar(0)), cv::Mat(size, CV_32F, cv::Scalar(0)),
                     cv::Mat(size, CV_32S, cv::Scalar(0))};
  ForEachIndex(size.height, drawing.threads, [&](int row) {
    PacketQueue queue(drawing.tracer);
    const auto keep = [&](int column, const Seen& seen) {
      centres.brightness.at<float>(row, column) = seen.brightness;
      centres.distance.at<float>(row, column) = seen.distance;
      centres.look.at<int>(row, column) = static_cast<int>(seen.look);
    };
    for (int column = 0; column < size.width; ++column) {
      if (!drawing.Wants(row, column)) continue;
      const PixelRay& pixel = drawing.table.At(row, column);
      queue.Add(MakeRay(drawing.moments[row][0], pixel.direction, pixel.width), column, keep);
    }
    queue.Finish(keep);
  });
  return centres;
}

}  // namespace

std::optional<Eigen::Vector3d> RayOf(const CameraModel& camera, const Eigen::Vector2d& pixel) {
  const std::optional<Eigen::Vector2d> ideal = camera.Undistort(pixel);
  if (!ideal) return std::nullopt;
  return camera.pinhole.Ray(*ideal).normalized();
}

RayTable::RayTable(const CameraModel& camera, int threads) : camera_(camera) {
  if (camera.width < 2 || camera.height < 2) throw InternalError("the camera has no image size");
  rays_.resize(static_cast<size_t>(camera.width) * camera.height);
  ForEachIndex(camera.height, threads, [&](int row) {
    for (int column = 0; column < camera.width; ++column) {
      const std::optional<Eigen::Vector3d> ray = RayOf(camera, Eigen::Vector2d(column, row));
      if (!ray) continue;
      PixelRay& pixel = rays_[static_cast<size_t>(row) * camera.width + column];
      pixel.direction = ray->cast<float>();
      pixel.width = 1;
    }
  });
  std::vector<float> widths(rays_.size());
  ForEachIndex(camera.height, threads, [&](int row) {
    for (int column = 0; column < camera.width; ++column) {
      if (!At(row, column).sees()) continue;
      // A pixel without a neighbour that sees stays dark.
      const Eigen::Vector3f across = Step(row, column, 0, 1);
      const Eigen::Vector3f down = Step(row, column, 1, 0);
      widths[static_cast<size_t>(row) * camera.width + column] = std::sqrt(across.cross(down).norm());
    }
  });
  for (size_t i = 0; i < rays_.size(); ++i) rays_[i].width = widths[i];
}

// How the ray changes to the next pixel in a direction; where there is none, as from the one opposite.
Eigen::Vector3f RayTable::Step(int row, int column, int down, int right) const {
  const Eigen::Vector3f& here = At(row, column).direction;
  for (const int sign : {1, -1}) {
    const int r = row + sign * down;
    const int c = column + sign * right;
    if (r < 0 || c < 0 || r >= camera_.height || c >= camera_.width) continue;
    const Eigen::Vector3f& there = At(r, c).direction;
    if (!there.isZero(0)) return static_cast<float>(sign) * (there - here);
  }
  return Eigen::Vector3f::Zero();
}

Eigen::Vector3f RayTable::Inside(int row, int column, const Eigen::Vector2f& offset) const {
  const int right = offset.x() < 0 ? -1 : 1;
  const int down = offset.y() < 0 ? -1 : 1;
  const Eigen::Vector3f direction = At(row, column).direction + std::abs(offset.x()) * Step(row, column, 0, right) +
                                    std::abs(offset.y()) * Step(row, column, down, 0);
  return direction.normalized();
}

std::shared_ptr<const RayTable> RayTableCache::Get(const CameraModel& camera, int threads) {
  const std::scoped_lock lock(mutex_);
  if (!table_ || !(table_->camera() == camera)) table_ = std::make_shared<RayTable>(camera, threads);
  return table_;
}

std::vector<std::vector<CameraMoment>> RowPoses(const View& view, int rows, int samples) {
  const double span = view.shutter.exposure + view.shutter.readout;
  std::vector<std::vector<CameraMoment>> moments(rows);
  for (int row = 0; row < rows; ++row) {
    // All rows of an instantaneous image share a pose.
    if (row > 0 && view.shutter.readout == 0) {
      moments[row] = moments[0];
      continue;
    }
    for (int i = 0; i < samples; ++i) {
      const double from_middle = rows > 1 ? static_cast<double>(row) / (rows - 1) - 0.5 : 0.0;
      const double time = view.shutter.readout * from_middle + view.shutter.exposure * ((i + 0.5) / samples - 0.5);
      const RigidTransform world_from_camera = view.world_from_camera(time);
      CameraMoment moment;
      moment.world_from_camera = world_from_camera.rotation.toRotationMatrix().cast<float>();
      moment.position = world_from_camera.translation.cast<float>();
      if (span > 0) moment.time = std::clamp(static_cast<float>(time / span + 0.5), 0.0F, 1.0F);
      moments[row].push_back(moment);
    }
  }
  return moments;
}

cv::Mat DrawSharp(const FrameDrawing& drawing, int edge_samples) {
  const Centres centres = DrawCentres(drawing);
  if (edge_samples < 2) return centres.brightness;
  const std::vector<Eigen::Vector2f> pattern = PixelPattern(edge_samples, false);
  cv::Mat image = centres.brightness.clone();
  ForEachIndex(image.rows, drawing.threads, [&](int row) {
    PacketQueue queue(drawing.tracer);
    const std::vector<uchar> edges = EdgesOfRow(centres, row);
    for (int column = 0; column < image.cols; ++column) {
      if (edges[column] == 0 || !drawing.Wants(row, column)) continue;
      const PixelRay& pixel = drawing.table.At(row, column);
      float sum = 0;
      const auto add = [&](int, const Seen& seen) { sum += seen.brightness; };
      const VariedPattern varied(pattern, row, column);
      for (size_t i = 0; i < pattern.size(); ++i) {
        const Eigen::Vector3f direction = drawing.table.Inside(row, column, varied[i]);
        queue.Add(MakeRay(drawing.moments[row][0], direction, kSampleWidth * pixel.width), column, add);
      }
      queue.Finish(add);
      image.at<float>(row, column) = sum / static_cast<float>(edge_samples);
    }
  });
  return image;
}

cv::Mat DrawBlurred(const FrameDrawing& drawing) {
  cv::Mat image(drawing.table.camera().height, drawing.table.camera().width, CV_32F, cv::Scalar(0));
  const int samples = static_cast<int>(drawing.moments.at(0).size());
  const std::vector<Eigen::Vector2f> pattern = PixelPattern(samples, true);
  ForEachIndex(image.rows, drawing.threads, [&](int row) {
    auto* out = image.ptr<float>(row);
    PacketQueue queue(drawing.tracer);
    const auto add = [&](int column, const Seen& seen) {
      out[column] += seen.brightness / static_cast<float>(samples);
    };
    for (int i = 0; i < samples; ++i) {
      for (int column = 0; column < image.cols; ++column) {
        if (!drawing.Wants(row, column)) continue;
        const PixelRay& pixel = drawing.table.At(row, column);
        const Eigen::Vector2f offset = VariedPattern(pattern, row, column)[i];
        const Eigen::Vector3f direction = drawing.table.Inside(row, column, offset);
        queue.Add(MakeRay(drawing.moments[row][i], direction, kSampleWidth * pixel.width), column, add);
      }
    }
    queue.Finish(add);
  });
  return image;
}

}  // namespace turnscale
