// SPDX-License-Identifier: MIT
#include "turnscale/export/gps_fixes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "turnscale/base/csv_table.h"
#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/quantiles.h"
#include "turnscale/base/robust_weights.h"
#include "turnscale/export/fix_heights.h"
#include "turnscale/export/path_error.h"
#include "turnscale/export/utc_time.h"
#include "turnscale/geometry/rotation.h"

namespace turnscale {
namespace {

using Eigen::Vector2d;

// A fix and where the path is at its time; both in the plane, metres.
struct Correspondence {
  Vector2d path;  // right, ahead
  Vector2d fix;   // east, north
  double sigma = 1;
  double way = 0;  // along the path, from its beginning
  double own = 0;  // standard deviation of the path, against its place at the middle of the fixes
};

// With a scale, since the path's own error of it puts its ends kilometres on beyond any outlier's limit.
struct PlaneFit {
  double heading = 0;
  double scale = 1;
  Vector2d shift = Vector2d::Zero();

  Vector2d operator*(const Vector2d& path) const {
    return scale * EastNorthUp({path.x(), path.y(), 0}, heading).head<2>() + shift;
  }
};

constexpr size_t kMostPairsOf = 150;  // fixes whose pairs are tried as a start
constexpr size_t kMostJudges = 1000;  // fixes that judge them
constexpr double kLeastBaseline = 5;  // standard deviations of a fix
constexpr int kIterations = 50;
constexpr double kMostOwnShare = 10;
// Right fixes reach 1.5 where the path drifts twice as much as it should, 2.3 where their noise is twice their sigma.
constexpr double kMostMisfit = 2.5;
constexpr double kMostFar = 0.2;  // share of the fixes

double TukeyCost(double deviation) {
  const double share = std::min(1.0, deviation / kTukeyThreshold);
  return 1 - std::pow(1 - share * share, 3);
}

double HeadingBetween(const Vector2d& path, const Vector2d& fix) {
  return std::atan2(path.y(), path.x()) - std::atan2(fix.y(), fix.x());
}

// Between two fixes, metres.
struct LargestDistance {
  double on_path = 0;
  double of_fixes = 0;
  double sigma = 0;  // of those two fixes

  void Add(const Correspondence& a, const Correspondence& b) {
    on_path = std::max(on_path, (b.path - a.path).norm());
    const double distance = (b.fix - a.fix).norm();
    if (distance > of_fixes) sigma = std::hypot(a.sigma, b.sigma);
    of_fixes = std::max(of_fixes, distance);
  }
  // Where none is large enough on the path.
  std::string WhyNoHeading() const {
    constexpr double kMostRatio = 2;
    if (of_fixes > kMostRatio * on_path + kLeastBaseline * sigma)
      return fmt::format(
          "--fixes: two of them are {:.0f} m apart, but the path at their times extends over {:.1f} m only: check the "
          "order of latitude and longitude in every line, their times, and --start-time",
          of_fixes, on_path);
    return fmt::format(
        "--fixes: the path at their times extends over {:.1f} m only, too little to give a heading; give some from "
        "farther along the drive",
        on_path);
  }
};

class Fitter {
 public:
  explicit Fitter(std::vector<Correspondence> pairs) : pairs_(std::move(pairs)) {}

  PlaneFit BestPair() const {
    PlaneFit best;
    double least = std::numeric_limits<double>::infinity();
    LargestDistance largest;
    const size_t stride = pairs_.size() / kMostPairsOf + 1;
    const size_t judge_stride = pairs_.size() / kMostJudges + 1;
    for (size_t i = 0; i < pairs_.size(); i += stride) {
      for (size_t k = i + stride; k < pairs_.size(); k += stride) {
        const Correspondence& a = pairs_[i];
        const Correspondence& b = pairs_[k];
        largest.Add(a, b);
        if ((b.path - a.path).norm() < kLeastBaseline * std::hypot(a.sigma, b.sigma)) continue;
        PlaneFit fit;
        fit.heading = HeadingBetween(b.path - a.path, b.fix - a.fix);
        fit.scale = (b.fix - a.fix).norm() / (b.path - a.path).norm();
        fit.shift = 0.5 * (a.fix + b.fix) - fit * Vector2d(0.5 * (a.path + b.path));
        double cost = 0;
        for (size_t j = 0; j < pairs_.size(); j += judge_stride) cost += TukeyCost(Deviation(fit, pairs_[j]));
        if (cost >= least) continue;
        least = cost;
        best = fit;
      }
    }
    if (std::isinf(least)) throw InputError(largest.WhyNoHeading());
    return best;
  }

  PlaneFit Refined(PlaneFit fit) {
    for (int i = 0; i < kIterations; ++i) {
      own_share_ = OwnShare(fit);
      const Sums sums = SumsOf(fit);
      fit = {std::atan2(sums.sine, sums.cosine), sums.Scale(), Vector2d::Zero()};
      fit.shift = sums.fix - fit * sums.path;
    }
    return fit;
  }

  // The path as it is, laid on the middle of the fixes.
  PlaneFit Rigid(const PlaneFit& fit) const {
    const Sums sums = SumsOf(fit);
    PlaneFit rigid{fit.heading, 1, Vector2d::Zero()};
    rigid.shift = sums.fix - rigid * sums.path;
    return rigid;
  }

  FixPlacement Describe(const PlaneFit& fit, const PlaneFit& rigid) const {
    const Sums sums = SumsOf(fit);
    FixPlacement described;
    described.fixes = static_cast<int>(pairs_.size());
    double squares = 0;
    double weighted = 0;
    double last = 0;
    for (const Correspondence& pair : pairs_) {
      const double weight = TukeyWeight(Deviation(fit, pair), kTukeyThreshold);
      if (weight == 0) {
        ++described.outliers;
        continue;
      }
      last = pair.way;
      squares += (pair.fix - rigid * pair.path).squaredNorm();
      weighted += weight * std::pow(Deviation(fit, pair), 2);
    }
    const int used = described.fixes - described.outliers;
    described.rms = std::sqrt(squares / std::max(used, 1));
    // Two numbers per fix, four unknowns.
    const double excess = std::max(1.0, weighted / std::max(2 * used - 4, 1));
    const double of_fixes = std::sqrt(excess / sums.spread);
    // The path's own drift is not independent from fix to fix. That of a random walk against a straight line's fit to
    // its whole length: of the line against the beginning, and against the mean.
    constexpr double kOfBeginning = 0.61;
    constexpr double kOfMean = 0.07;
    const double drifts = std::max(1.0, own_share_) * std::sqrt(last / 100);
    described.heading_sigma = std::hypot(of_fixes, kOfBeginning * drifts * kHeadingDriftPer100m);
    described.scale = sums.Scale();
    described.scale_sigma = std::hypot(of_fixes, kOfMean * drifts * kScaleDriftPer100m);
    described.fits = Fits(fit);
    return described;
  }

 private:
  // Weighted means, and sums about them.
  struct Sums {
    Vector2d path = Vector2d::Zero();
    Vector2d fix = Vector2d::Zero();
    double sine = 0;
    double cosine = 0;
    double spread = 0;  // of the path

    double Scale() const { return std::hypot(sine, cosine) / spread; }
  };

  static double Sigma(const Correspondence& pair, double own_share) {
    return std::hypot(pair.sigma, own_share * pair.own);
  }

  double Deviation(const PlaneFit& fit, const Correspondence& pair) const {
    return (pair.fix - fit * pair.path).norm() / Sigma(pair, own_share_);
  }

  // How much of the error that the path may have it has, as the median distance shows: with all of it, gross errors
  // far from the middle would be none.
  double OwnShare(const PlaneFit& fit) const {
    if (pairs_.size() < 3) return 1;
    const std::vector<double> distances = Distances(fit);
    double low = 0;
    double high = kMostOwnShare;
    constexpr int kHalvings = 16;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (low + high);
      (MedianOverChance(distances, middle) > 1 ? low : high) = middle;
    }
    return low;
  }

  // With all of the error that the path may have. With the share that it has, right fixes at the ends can be outliers
  // where the path drifts little, and wrong ones are none where it is large. The share itself depends on how small that
  // error is, as on a short drive.
  bool Fits(const PlaneFit& fit) const {
    if (pairs_.size() < 3) return true;
    const auto is_far = [&](const Correspondence& pair) {
      return (pair.fix - fit * pair.path).norm() > kTukeyThreshold * Sigma(pair, 1);
    };
    const auto far = static_cast<double>(std::ranges::count_if(pairs_, is_far));
    return MedianOverChance(Distances(fit), 1) <= kMostMisfit && far <= kMostFar * static_cast<double>(pairs_.size());
  }

  std::vector<double> Distances(const PlaneFit& fit) const {
    const auto pairs = static_cast<double>(pairs_.size());
    const double lost = std::sqrt(pairs / (pairs - 2));  // by the fit itself
    std::vector<double> distances;
    for (const Correspondence& pair : pairs_) distances.push_back(lost * (pair.fix - fit * pair.path).norm());
    return distances;
  }

  // The median of the deviations over what the noise of the fixes explains.
  double MedianOverChance(const std::vector<double>& distances, double own_share) const {
    const double by_chance = kMedianLengthInPlane * (1 + 1 / std::sqrt(static_cast<double>(pairs_.size())));
    std::vector<double> deviations;
    for (size_t i = 0; i < pairs_.size(); ++i) deviations.push_back(distances[i] / Sigma(pairs_[i], own_share));
    return Median(deviations) / by_chance;
  }

  Sums SumsOf(const PlaneFit& fit) const {
    Sums sums;
    double total = 0;
    std::vector<double> weights;
    for (const Correspondence& pair : pairs_) {
      weights.push_back(TukeyWeight(Deviation(fit, pair), kTukeyThreshold) / std::pow(Sigma(pair, own_share_), 2));
      total += weights.back();
      sums.path += weights.back() * pair.path;
      sums.fix += weights.back() * pair.fix;
    }
    sums.path /= total;
    sums.fix /= total;
    for (size_t i = 0; i < pairs_.size(); ++i) {
      const Vector2d p = pairs_[i].path - sums.path;
      const Vector2d q = pairs_[i].fix - sums.fix;
      sums.cosine += weights[i] * p.dot(q);
      sums.sine += weights[i] * (p.y() * q.x() - p.x() * q.y());
      sums.spread += weights[i] * p.squaredNorm();
    }
    return sums;
  }

  std::vector<Correspondence> pairs_;
  double own_share_ = 1;
};

// A place of the path at the time of a fix.
struct PlaceOfFix {
  const GpsFix* fix = nullptr;
  Eigen::Vector3d position;
  double way = 0;  // along the path, from its beginning
  double sigma = 0;
};

std::vector<PlaceOfFix> PlacesOf(const std::vector<GpsFix>& fixes, const std::vector<LevelPlace>& path) {
  std::vector<PlaceOfFix> places;
  size_t after = 0;
  double way = 0;
  for (const GpsFix& fix : fixes) {
    if (fix.time < path.front().time) continue;
    while (after < path.size() && path[after].time < fix.time) {
      if (after > 0) way += (path[after].position - path[after - 1].position).norm();
      ++after;
    }
    if (after == path.size()) break;
    const LevelPlace& next = path[after];
    const LevelPlace& before = path[after > 0 ? after - 1 : 0];
    const double share = after > 0 ? (fix.time - before.time) / (next.time - before.time) : 0;
    const Eigen::Vector3d position = (1 - share) * before.position + share * next.position;
    places.push_back({&fix, position, way + (position - before.position).norm(), next.sigma});
  }
  return places;
}

std::vector<double> OwnErrors(const std::vector<PlaceOfFix>& places) {
  const double least = std::ranges::min(places, {}, &PlaceOfFix::sigma).sigma;
  const double middle = 0.5 * (places[(places.size() - 1) / 2].way + places[places.size() / 2].way);
  std::vector<double> errors;
  for (const PlaceOfFix& place : places) {
    const double sigma = std::sqrt(place.sigma * place.sigma - least * least);
    errors.push_back(OwnPathError(std::abs(place.way - middle), sigma));
  }
  return errors;
}

}  // namespace

std::vector<GpsFix> ReadGpsFixes(const std::filesystem::path& path, std::optional<double> start_time) {
  CsvTable table(path, "file of GPS fixes");
  const size_t time = table.Column("time");
  const size_t latitude = table.Column("latitude");
  const size_t longitude = table.Column("longitude");
  const bool has_sigma = table.HasColumn("sigma");
  const bool has_height = table.HasColumn("height");
  std::vector<GpsFix> fixes;
  while (table.Next()) {
    GpsFix fix;
    if (const auto seconds = ParseNumber<double>(table.Text(time))) {
      fix.time = *seconds;
      if (AreSince1970(fix.time)) {
        if (!start_time) {
          throw InputError(table.Where() + ": its time is in seconds since 1970, " + UtcTimeText(fix.time) +
                           "; give --start-time, the date and time of the drive's time 0, too");
        }
        fix.time -= *start_time;
      }
    } else if (const auto moment = ParseUtcTime(table.Text(time))) {
      if (!start_time) throw InputError(table.Where() + ": has a time of day; give --start-time too");
      fix.time = *moment - *start_time;
    } else {
      throw InputError(table.Where() + ": '" + Excerpt(table.Text(time)) +
                       "' is not a time; give time stamps as in trajectory.csv, or 2026-03-22T07:14:05+01:00");
    }
    fix.point.latitude = table.Value<double>(latitude);
    fix.point.longitude = table.Value<double>(longitude);
    const auto height = has_height ? table.ValueOrNone<double>(table.Column("height")) : std::nullopt;
    fix.has_height = height.has_value();
    fix.point.height = height.value_or(0);
    if (has_sigma) fix.sigma = table.ValueOrNone<double>(table.Column("sigma")).value_or(fix.sigma);
    if (std::abs(fix.point.latitude) > 90 && std::abs(fix.point.latitude) <= 180)
      throw InputError(fmt::format("{}: a latitude of {} is beyond 90 degrees; are latitude and longitude swapped?",
                                   table.Where(), fix.point.latitude));
    const bool sane = std::isfinite(fix.time) && std::abs(fix.point.latitude) < 90 &&
                      std::abs(fix.point.longitude) <= 180 && fix.sigma > 0 && std::isfinite(fix.sigma) &&
                      std::isfinite(fix.point.height);
    if (!sane) throw InputError(table.Where() + ": is not a position with degrees and a positive sigma");
    if (!fixes.empty() && fix.time <= fixes.back().time)
      throw InputError(table.Where() + ": its time does not come after that of the line before");
    fixes.push_back(fix);
  }
  return fixes;
}

FixPlacement PlaceByFixes(const std::vector<LevelPlace>& path, const std::vector<GpsFix>& fixes) {
  const std::vector<PlaceOfFix> places = PlacesOf(fixes, path);
  if (places.size() < 2) {
    const std::string of_fixes =
        fixes.empty() ? ""
                      : fmt::format(", and they are from {:.1f} s to {:.1f} s", fixes.front().time, fixes.back().time);
    throw InputError(fmt::format(
        "--fixes: {} of {} lie within the drive, which is from {:.1f} s to {:.1f} s{}; give at least 2, and "
        "check their times and --start-time",
        places.size(), fixes.size(), path.front().time, path.back().time, of_fixes));
  }
  const std::vector<double> own = OwnErrors(places);
  constexpr double kSigmaUp = 2;  // of a fix's height, over that of its place
  std::vector<HeightOfFix> heights;
  for (size_t i = 0; i < places.size(); ++i) {
    const GpsFix& fix = *places[i].fix;
    if (fix.has_height)
      heights.push_back({places[i].position, fix.point.height, std::hypot(kSigmaUp * fix.sigma, own[i])});
  }
  const HeightPlacement height = heights.empty() ? HeightPlacement() : PlaceHeights(heights);
  const GeoFrame frame(places.front().fix->point);
  std::vector<Correspondence> pairs;
  for (size_t i = 0; i < places.size(); ++i)
    pairs.push_back({(height.tilt * places[i].position).head<2>(), frame.ToLocal(places[i].fix->point).head<2>(),
                     places[i].fix->sigma, places[i].way, own[i]});
  Fitter fitter(std::move(pairs));
  const PlaneFit fit = fitter.Refined(fitter.BestPair());
  const PlaneFit rigid = fitter.Rigid(fit);
  FixPlacement placed = fitter.Describe(fit, rigid);
  GeoPoint origin = frame.FromLocal({rigid.shift.x(), rigid.shift.y(), 0});
  placed.has_height = !heights.empty();
  origin.height = height.height;
  placed.placement = {origin, std::remainder(fit.heading, 2 * M_PI), height.tilt};
  if (placed.placement.heading < 0) placed.placement.heading += 2 * M_PI;
  return placed;
}

}  // namespace turnscale
