// SPDX-License-Identifier: MIT
#include "lab_output.h"

#include <cstdlib>

#include <fmt/format.h>

#include "turnscale/base/attempts.h"
#include "turnscale/io/output_file.h"

namespace turnscale {
namespace {

LabJson PointsJson(const PlotPoints& points) {
  LabJson json = LabJson::array();
  for (const Eigen::Vector2d& point : points) json.push_back({Rounded(point.x()), Rounded(point.y())});
  return json;
}

}  // namespace

double Rounded(double value) { return std::strtod(fmt::format("{:.6g}", value).c_str(), nullptr); }

LabJson FigureJson(const Figure& figure) {
  LabJson panels = LabJson::array();
  for (const PlotPanel& panel : figure.panels) {
    LabJson json = {{"title", panel.title}, {"x", panel.x_label}, {"y", panel.y_label}};
    for (const PlotLine& line : panel.lines) {
      json["lines"].push_back({{"label", line.label}, {"points", PointsJson(line.points)}});
    }
    for (const PlotBox& box : panel.boxes) {
      json["boxes"].push_back({{"label", box.label},
                               {"x", Rounded(box.x)},
                               {"mean", Rounded(box.mean)},
                               {"sigma", Rounded(box.sigma)},
                               {"low", Rounded(box.low)},
                               {"high", Rounded(box.high)}});
    }
    for (const PlotArea& area : panel.areas) {
      json["areas"].push_back({{"label", area.label}, {"outline", PointsJson(area.outline)}});
    }
    panels.push_back(std::move(json));
  }
  return {{"title", figure.title}, {"panels", std::move(panels)}};
}

void KeepResult(const std::filesystem::path& folder, const std::string& name, const LabResult& result, LabJson& all) {
  LabJson json = {{"values", result.values}};
  Attempts attempts;
  for (const auto& [file, figure] : result.figures) {
    const std::filesystem::path path = folder / (file + ".svg");
    attempts.Try([&, &drawn = figure] { ReplaceFile(path, FigureSvg(drawn)); });
    json["pictures"][file] = FigureJson(figure);
  }
  all[name] = std::move(json);
  // Numbers in one line each would make the file ten times as long: arrays of curves stay compact.
  std::string text = "{\n";
  for (auto entry = all.begin(); entry != all.end(); ++entry) {
    text += (entry == all.begin() ? "" : ",\n") + LabJson(entry.key()).dump() + ": ";
    if (!entry->is_object()) {
      text += entry->dump();
      continue;
    }
    text += "{\n";
    for (auto part = entry->begin(); part != entry->end(); ++part) {
      text += (part == entry->begin() ? "" : ",\n") + ("  " + LabJson(part.key()).dump()) + ": ";
      text += part.key() == "values" ? part->dump(2) : part->dump();
    }
    text += "\n}";
  }
  attempts.Try([&] { ReplaceFile(folder / "lab.json", text + "\n}\n"); });
  attempts.RethrowFirst();
}

}  // namespace turnscale
