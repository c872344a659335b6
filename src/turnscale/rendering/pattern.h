// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

namespace turnscale {

/// Seamless CV_32F patterns of `side` x `side` (a power of two), values around `mean`. Detail is everywhere and of
/// every size, so that a corner detector finds something near and far. Same arguments, same pattern.
struct PatternOptions {
  int side = 1024;
  std::uint64_t seed = 1;
  float mean = 0.5F;
  float contrast = 0.15F;  ///< standard deviation
};

/// Clouds: noise of all sizes, the amplitude falling with the frequency to the power `roughness` (1: natural).
cv::Mat CloudPattern(const PatternOptions& options, double roughness = 1.0);

/// Asphalt or concrete: clouds, pebbles, stains, cracks and patches.
cv::Mat PavementPattern(const PatternOptions& options);

/// Rows of bricks, each of its own brightness, `rows` to the side.
cv::Mat BrickPattern(const PatternOptions& options, int rows);

/// Leaves: overlapping blobs, bright and dark.
cv::Mat FoliagePattern(const PatternOptions& options);

/// A facade: `floors` x `columns` windows with frames, sills and blinds, in a plastered wall.
cv::Mat FacadePattern(const PatternOptions& options, int floors, int columns);

}  // namespace turnscale
