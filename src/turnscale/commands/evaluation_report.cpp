// SPDX-License-Identifier: MIT
#include "turnscale/commands/evaluation_report.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace turnscale {
namespace {

using Json = nlohmann::ordered_json;

double Percent(double share) { return 100 * share; }
double DegreesPer100Metres(double radians_per_metre) { return 100 * kDegreesPerRadian * radians_per_metre; }

std::string Number(double value) { return std::isfinite(value) ? fmt::format("{:.3f}", value) : "-"; }

template <typename Quantity>
std::string Row(const Evaluation& evaluation, const std::string& name, const std::string& unit, Quantity quantity) {
  const std::string rescaled = evaluation.rescaled ? Number(quantity(*evaluation.rescaled)) : "-";
  return fmt::format("{:<34}{:>10}{:>12}{:>18}\n", name, unit, Number(quantity(evaluation.as_given)), rescaled);
}

std::string Row(const std::string& name, const std::optional<PositionErrors>& errors) {
  const ErrorStatistics statistics = errors ? errors->distance : ErrorStatistics();
  return fmt::format("{:<34}{:>10}{:>12}{:>18}{:>12}\n", name, "m", Number(statistics.rms), Number(statistics.median),
                     Number(statistics.max));
}

std::string Lengths(const SegmentErrors& segments) {
  std::string text;
  for (const SegmentLengthError& error : segments.by_length) {
    text += fmt::format("{}{:g}", text.empty() ? "" : ", ", error.length);
  }
  return text;
}

// A run measures its path along the keyframes, as the noise of all poses would add up.
std::string OfRunText(const std::optional<double>& length, double from_pose_to_pose) {
  constexpr double kShown = 0.05;
  if (!length || std::abs(*length - from_pose_to_pose) < kShown) return {};
  return fmt::format("; the run states {:.1f} m for its whole path, along the keyframes", *length);
}

Json StatisticsJson(const ErrorStatistics& statistics, const std::string& unit, double factor) {
  return {{"count", statistics.count},
          {"rmse_" + unit, factor * statistics.rms},
          {"median_" + unit, factor * statistics.median},
          {"max_" + unit, factor * statistics.max}};
}

Json PositionJson(const PositionErrors& errors) {
  Json json = StatisticsJson(errors.distance, "m", 1);
  json["scale"] = errors.truth_from_estimate.scale;
  return json;
}

Json ScaledJson(const ScaledErrors& errors) {
  Json lengths = Json::array();
  for (const SegmentLengthError& error : errors.segments.by_length) {
    lengths.push_back({{"length_m", error.length},
                       {"segments", error.segments},
                       {"translation_percent", Percent(error.translation)},
                       {"rotation_deg_per_100m", DegreesPer100Metres(error.rotation)}});
  }
  return {{"scale", errors.scale},
          {"path_length_error_percent", Percent(errors.path_length_error)},
          {"kitti",
           {{"segments", errors.segments.segments},
            {"translation_percent", Percent(errors.segments.translation)},
            {"rotation_deg_per_100m", DegreesPer100Metres(errors.segments.rotation)},
            {"by_length", lengths}}},
          {"scale_error_ratio",
           {{"all", StatisticsJson(errors.all_steps.scale, "percent", 100)},
            {"turning", StatisticsJson(errors.turning_steps.scale, "percent", 100)}}}};
}

}  // namespace

std::string EvaluationTable(const Evaluation& evaluation, const EvaluationSources& sources) {
  const ScaledErrors& given = evaluation.as_given;
  std::string text = fmt::format("estimate      {}\nground truth  {}\n", sources.estimate, sources.ground_truth);
  text += fmt::format(
      "paired        {} of {} poses with {} of ground truth, by {}; ground-truth path length {:.1f} m\n",
      evaluation.poses, sources.estimated_poses, sources.true_poses, sources.pairing, evaluation.true_path_length);
  text += fmt::format("path length   estimate {:.1f} m from pose to pose{}\n\n", evaluation.estimated_path_length,
                      OfRunText(sources.run_length, evaluation.estimated_path_length));

  const std::string rescaled =
      evaluation.rescaled ? fmt::format("scaled by {:.5g}", evaluation.rescaled->scale) : "scaled";
  text += fmt::format("{:<44}{:>12}{:>18}\n", "", "as given", rescaled);
  text += Row(evaluation, "path length error", "%", [](const auto& e) { return Percent(e.path_length_error); });
  text +=
      Row(evaluation, "translation error (KITTI)", "%", [](const auto& e) { return Percent(e.segments.translation); });
  text += Row(evaluation, "rotation error (KITTI)", "deg/100 m",
              [](const auto& e) { return DegreesPer100Metres(e.segments.rotation); });
  text += Row(evaluation, "scale error ratio, RMSE", "%", [](const auto& e) { return Percent(e.all_steps.scale.rms); });
  text += Row(evaluation, "scale error ratio, median", "%",
              [](const auto& e) { return Percent(e.all_steps.scale.median); });
  text +=
      Row(evaluation, "  turning steps, RMSE", "%", [](const auto& e) { return Percent(e.turning_steps.scale.rms); });
  text += Row(evaluation, "  turning steps, median", "%",
              [](const auto& e) { return Percent(e.turning_steps.scale.median); });
  text += fmt::format("{:<34}{:>10}{:>12}\n\n", "turning angle, turning steps, RMSE", "deg",
                      Number(kDegreesPerRadian * given.turning_steps.psi.rms));

  text += fmt::format("{:<44}{:>12}{:>18}{:>12}\n", "position error (ATE)", "RMSE", "median", "max");
  text += Row("  first poses aligned", evaluation.from_first_pose);
  text += Row("  after SE(3) alignment", evaluation.rigid);
  text += Row("  after Sim(3) alignment", evaluation.similarity);

  text += fmt::format("\nKITTI errors over {} segments of {} m; scale errors over {} steps {}, {} of them turning\n",
                      given.segments.segments, Lengths(given.segments), given.all_steps.scale.count, sources.steps,
                      given.turning_steps.scale.count);
  if (!evaluation.alignment_problem.empty()) text += evaluation.alignment_problem + "\n";
  return text;
}

Json EvaluationJson(const Evaluation& evaluation, const EvaluationSources& sources) {
  const Json none = nullptr;
  return {
      {"estimate", sources.estimate},
      {"ground_truth", sources.ground_truth},
      {"paired_by", sources.pairing},
      {"poses", {{"paired", evaluation.poses}, {"estimated", sources.estimated_poses}, {"true", sources.true_poses}}},
      {"true_path_length_m", evaluation.true_path_length},
      {"estimated_path_length", evaluation.estimated_path_length},
      {"path_length_of_run", sources.run_length ? Json(*sources.run_length) : none},
      {"steps", sources.steps},
      {"as_given", ScaledJson(evaluation.as_given)},
      {"rescaled", evaluation.rescaled ? ScaledJson(*evaluation.rescaled) : none},
      {"turning_angle",
       {{"all", StatisticsJson(evaluation.as_given.all_steps.psi, "deg", kDegreesPerRadian)},
        {"turning", StatisticsJson(evaluation.as_given.turning_steps.psi, "deg", kDegreesPerRadian)}}},
      {"position_error",
       {{"first_poses_equal", PositionJson(evaluation.from_first_pose)},
        {"se3", evaluation.rigid ? PositionJson(*evaluation.rigid) : none},
        {"sim3", evaluation.similarity ? PositionJson(*evaluation.similarity) : none}}},
      {"alignment_problem", evaluation.alignment_problem.empty() ? none : Json(evaluation.alignment_problem)},
      {"warnings", sources.warnings}};
}

}  // namespace turnscale
