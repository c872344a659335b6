// SPDX-License-Identifier: MIT
#include "turnscale/mapping/lens_refinement.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "turnscale/base/refused_field.h"
#include "turnscale/base/test_seeds.h"
#include "turnscale/camera/camera_model.h"
#include "turnscale/mapping/synthetic_map.h"

namespace turnscale {
namespace {

// Takes in the window that ends at the latest keyframe. True when the estimate changed.
bool Observe(LensRefinement& lens, const Map& map) {
  std::optional<IntrinsicsProblem> window = lens.TakeWindow(map);
  return window && lens.Read(*window);
}

const std::vector<DriveSegment> kStreetCornerStreet = {{20, 0.8, 0}, {20, 0.7, 0.07}, {25, 0.8, 0}};

// A drive seen through a lens whose pixels would need `distortion` as correction.
Map MapThroughLens(const std::vector<DriveSegment>& segments, double distortion, double noise, unsigned seed,
                   double unit = 1) {
  const CarDrive drive = MakeCarDrive(segments, 0.1, {1.2, 0}, Eigen::Quaterniond::Identity());
  Map map = MakeMap(drive, {.points_per_step = 25, .pixel_noise = noise, .seed = seed});
  for (Keyframe& keyframe : map.keyframes) {
    keyframe.camera_from_world.translation *= unit;
    for (KeyframeObservation& seen : keyframe.observations)
      seen.pixel = UndoRadialCorrection(map.camera.pinhole, distortion, seen.pixel);
  }
  for (Landmark& landmark : map.landmarks) {
    landmark.position *= unit;
    for (LandmarkObservation& seen : landmark.observations)
      seen.pixel = UndoRadialCorrection(map.camera.pinhole, distortion, seen.pixel);
  }
  return map;
}

LensRefinement RefineAlong(const Map& whole, const LensRefinementOptions& options = {}) {
  LensRefinement lens(options);
  for (int keyframes = 1; keyframes <= CountKeyframes(whole); ++keyframes) Observe(lens, MapUpTo(keyframes, whole));
  return lens;
}

TEST(LensRefinement, FindsTheDistortionFromOneCorner) {
  for (const double distortion : {-0.012, 0.0, 0.008}) {
    const LensRefinement lens = RefineAlong(MapThroughLens(kStreetCornerStreet, distortion, 0, 3));
    EXPECT_NEAR(lens.correction(), distortion, 0.0001);
  }
}

TEST(LensRefinement, FindsTheDistortionFromTurnsInNoise) {
  for (const double distortion : {-0.012, 0.0, 0.008})
    for (int seed = 3; seed < 3 + SeedsToTest(2); ++seed) {
      const LensRefinement lens =
          RefineAlong(MapThroughLens(kRightAndLeft, distortion, 0.3, static_cast<unsigned>(seed)));
      EXPECT_NEAR(lens.correction(), distortion, 0.0014);
      EXPECT_LT(lens.sigma(), 0.0006);
      EXPECT_GT(lens.sigma(), 0.0001);
    }
}

TEST(LensRefinement, NoiseDoesNotBiasIt) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  double sum = 0;
  double variance = 0;
  int drives = 0;
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    const LensRefinement lens = RefineAlong(MapThroughLens(kRightAndLeft, 0, 0.5, seed));
    sum += lens.correction();
    variance += lens.sigma() * lens.sigma();
    ++drives;
  }
  EXPECT_LT(std::abs(sum), 2 * std::sqrt(variance)) << sum / drives;
  EXPECT_NEAR(sum / drives, 0, 0.0004);
}

TEST(LensRefinement, OneWindowFindsALargeCorrection) {
  for (const double distortion : {-0.016, -0.04, 0.05, 0.085}) {
    LensRefinement lens({});
    ASSERT_TRUE(Observe(lens, MapUpTo(36, MapThroughLens(kStreetCornerStreet, distortion, 0, 3)))) << distortion;
    EXPECT_NEAR(lens.correction(), distortion, std::abs(0.013 * distortion));
  }
}

// Options that look at straight windows as well.
LensRefinementOptions AnyWindow() {
  LensRefinementOptions options;
  options.min_turn_deg = 0;
  return options;
}

TEST(LensRefinement, AsksOnlyWindowsThatTurn) {
  const Map whole = MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 3);
  LensRefinement lens({});
  EXPECT_FALSE(Observe(lens, MapUpTo(18, whole))) << "a street";
  EXPECT_EQ(lens.correction(), 0);
  EXPECT_TRUE(Observe(lens, MapUpTo(36, whole))) << "a corner";
  EXPECT_NE(lens.correction(), 0);
}

TEST(LensRefinement, ANumberThatIsNoneTellsNothing) {
  Map map = MapUpTo(36, MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 3));
  for (const KeyframeObservation& seen : map.keyframes.back().observations)
    map.landmarks[seen.landmark].position.x() = std::nan("");
  LensRefinement lens({});
  EXPECT_FALSE(Observe(lens, map));
  EXPECT_EQ(lens.correction(), 0);
}

TEST(LensRefinement, ATurnTellsMoreThanAStreet) {
  LensRefinement street(AnyWindow());
  LensRefinement turn(AnyWindow());
  const Map whole = MapThroughLens(kStreetCornerStreet, 0, 0.3, 3);
  ASSERT_TRUE(Observe(street, MapUpTo(18, whole)));
  ASSERT_TRUE(Observe(turn, MapUpTo(36, whole)));
  EXPECT_LT(turn.sigma(), 0.3 * street.sigma());
}

TEST(LensRefinement, DoesNotDependOnTheUnitOfLength) {
  const LensRefinement one = RefineAlong(MapThroughLens(kRightAndLeft, -0.006, 0.3, 4));
  const LensRefinement ten = RefineAlong(MapThroughLens(kRightAndLeft, -0.006, 0.3, 4, 10));
  EXPECT_NEAR(ten.correction(), one.correction(), 1e-6);
  EXPECT_NEAR(ten.sigma() / one.sigma(), 1.0, 1e-3);
}

TEST(LensRefinement, PixelsThatAreCorrectedAlreadySayTheSame) {
  const double distortion = 0.008;
  const double applied = 0.005;
  const Map raw = MapUpTo(40, MapThroughLens(kStreetCornerStreet, distortion, 0.3, 5));
  Map corrected = raw;
  corrected.camera.radial_correction = applied;
  for (Landmark& landmark : corrected.landmarks)
    for (LandmarkObservation& seen : landmark.observations)
      seen.pixel = CorrectRadially(corrected.camera.pinhole, applied, seen.pixel);
  LensRefinement from_raw({});
  LensRefinement from_corrected({});
  EXPECT_TRUE(Observe(from_raw, raw));
  EXPECT_TRUE(Observe(from_corrected, corrected));
  EXPECT_GT(std::abs(from_raw.correction()), 0.001);
  EXPECT_NEAR(from_corrected.correction(), from_raw.correction(), 1e-6);
}

TEST(LensRefinement, WindowsThatContradictOneAnotherWidenSigma) {
  const auto sigma_after = [](double first, double second) {
    LensRefinement lens({});
    EXPECT_TRUE(Observe(lens, MapUpTo(34, MapThroughLens(kStreetCornerStreet, first, 0.3, 3))));
    EXPECT_TRUE(Observe(lens, MapUpTo(40, MapThroughLens(kStreetCornerStreet, second, 0.3, 3))));
    return lens.sigma();
  };
  EXPECT_GT(sigma_after(-0.004, -0.02), 1.5 * sigma_after(-0.012, -0.012));
}

// Standard deviation of the mixture.
double PriorSigma(const LensRefinementOptions& options) {
  return std::sqrt(options.accurate_share * options.accurate_sigma * options.accurate_sigma +
                   (1 - options.accurate_share) * options.prior_sigma * options.prior_sigma);
}

TEST(LensRefinement, KnowsThePriorUntilTheWindowIsFull) {
  const Map whole = MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 6);
  LensRefinement lens(AnyWindow());
  for (int keyframes = 1; keyframes < 12; ++keyframes) EXPECT_FALSE(Observe(lens, MapUpTo(keyframes, whole)));
  EXPECT_EQ(lens.correction(), 0);
  EXPECT_NEAR(lens.sigma(), PriorSigma({}), 1e-12);
  EXPECT_TRUE(Observe(lens, MapUpTo(12, whole)));
  EXPECT_LT(lens.sigma(), PriorSigma({}));
  EXPECT_FALSE(Observe(lens, MapUpTo(13, whole))) << "the next look is half a window on";
}

TEST(LensRefinement, DoesNotLookAcrossAGap) {
  Map map = MapUpTo(40, MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 7));
  map.keyframes[35].after_gap = true;
  LensRefinement lens({});
  EXPECT_FALSE(Observe(lens, map));
  EXPECT_EQ(lens.correction(), 0);
}

TEST(LensRefinement, CanBeSwitchedOff) {
  LensRefinementOptions options;
  options.enabled = false;
  const LensRefinement lens = RefineAlong(MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 8), options);
  EXPECT_EQ(lens.correction(), 0);
  EXPECT_NEAR(lens.sigma(), PriorSigma(options), 1e-12);
}

LensRefinementOptions ForNoise(double pixel_sigma) {
  LensRefinementOptions options;
  options.pixel_sigma = pixel_sigma;
  return options;
}

// Without the part of the prior for accurate calibrations.
LensRefinementOptions OffOnly(LensRefinementOptions options) {
  options.accurate_share = 0;
  return options;
}

TEST(LensRefinement, NoiseHardlyChangesAnAccurateCalibration) {
  if (kSanitized) GTEST_SKIP() << "statistics over many seeds";
  double sum = 0;
  double without = 0;
  for (unsigned seed = 21; seed < 29; ++seed) {
    const Map whole = MapThroughLens(kStreetCornerStreet, 0, 2.0, seed);
    sum += std::abs(RefineAlong(whole, ForNoise(2)).correction());
    without += std::abs(RefineAlong(whole, OffOnly(ForNoise(2))).correction());
  }
  EXPECT_GT(without, 0.008) << "noise hides a correction";
  EXPECT_LT(sum, 0.5 * without);
}

TEST(LensRefinement, TakesASignificantCorrectionAsItIs) {
  const Map whole = MapThroughLens(kRightAndLeft, -0.012, 0.5, 31);
  const LensRefinement lens = RefineAlong(whole);
  const LensRefinement off = RefineAlong(whole, OffOnly({}));
  ASSERT_GT(std::abs(off.correction()), 8 * off.sigma());
  EXPECT_NEAR(lens.correction(), off.correction(), 1e-9);
  EXPECT_NEAR(lens.sigma(), off.sigma(), 1e-9);
}

// Against the posterior integrated numerically.
TEST(LensRefinement, IsThePosteriorMeanOfTheMixture) {
  const Map whole = MapThroughLens(kStreetCornerStreet, 0.003, 1.5, 34);
  const LensRefinementOptions options = ForNoise(1.5);
  const LensRefinement off = RefineAlong(whole, OffOnly(options));
  const double prior = 1 / (options.prior_sigma * options.prior_sigma);
  const double posterior = 1 / (off.sigma() * off.sigma());
  const double information = posterior - prior;
  const double centre = off.correction() * posterior / information;
  const auto density = [](double x, double sigma) { return std::exp(-0.5 * x * x / (sigma * sigma)) / sigma; };
  double mass = 0;
  double first = 0;
  double second = 0;
  for (double x = -0.1; x <= 0.1; x += 1e-6) {
    const double p = density(x - centre, 1 / std::sqrt(information)) *
                     (options.accurate_share * density(x, options.accurate_sigma) +
                      (1 - options.accurate_share) * density(x, options.prior_sigma));
    mass += p;
    first += p * x;
    second += p * x * x;
  }
  const double mean = first / mass;
  ASSERT_LT(std::abs(mean), 0.9 * std::abs(off.correction()));
  // A window is measured near the estimate, which is not the same for both.
  const LensRefinement lens = RefineAlong(whole, options);
  EXPECT_NEAR(lens.correction(), mean, 0.02 * off.sigma());
  EXPECT_NEAR(lens.sigma(), std::sqrt(second / mass - mean * mean), 0.02 * off.sigma());
}

TEST(LensRefinement, ReadsAWindowThatWasCopiedBeforeTheMapChanged) {
  const Map whole = MapThroughLens(kStreetCornerStreet, -0.012, 0.3, 3);
  LensRefinement at_once({});
  LensRefinement later({});
  Map map = MapUpTo(36, whole);
  std::optional<IntrinsicsProblem> window = later.TakeWindow(map);
  ASSERT_TRUE(window);
  ASSERT_TRUE(Observe(at_once, map));
  for (Keyframe& keyframe : map.keyframes) keyframe.camera_from_world = {};
  map.landmarks.clear();
  EXPECT_EQ(later.correction(), 0) << "not before it is read";
  ASSERT_TRUE(later.Read(*window));
  EXPECT_EQ(later.correction(), at_once.correction());
}

TEST(LensRefinement, OptionsNameTheFieldThatMakesNoSense) {
  using Options = LensRefinementOptions;
  EXPECT_EQ(RefusedField<Options>([](auto&) {}), "");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.window = 2; }), "window");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.prior_sigma = 0; }), "prior_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.accurate_share = 1; }), "accurate_share");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.accurate_sigma = 0; }), "accurate_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.accurate_sigma = o.prior_sigma; }), "accurate_sigma");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.step = -1; }), "step");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.max_landmarks = 19; }), "max_landmarks");
  EXPECT_EQ(RefusedField<Options>([](auto& o) { o.pixel_sigma = std::nan(""); }), "pixel_sigma");
}

}  // namespace
}  // namespace turnscale
