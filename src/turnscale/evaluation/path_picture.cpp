// SPDX-License-Identifier: MIT
#include "turnscale/evaluation/path_picture.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"

namespace turnscale {
namespace {

// All lengths of the page in its own units, about pixels.
constexpr double kSide = 800;  // of the longer side of what is drawn
constexpr double kMargin = 24;
constexpr double kHeading = 60;

// An outline within another one is darker.
constexpr auto kStyle =
    "text{font-family:sans-serif;font-size:13px;fill:#333}.title{font-size:15px;font-weight:bold}"
    "path{fill:none;stroke-linejoin:round}.plan{fill:#9aa0a8;fill-opacity:.3;stroke:#9aa0a8;stroke-width:1}"
    ".truth{stroke:#222;stroke-width:5;stroke-opacity:.35}.estimate{stroke:#c2185b;stroke-width:1.8}"
    ".bar{stroke:#333;stroke-width:2}";

class Page {
 public:
  explicit Page(const Eigen::AlignedBox2d& box) : low_(box.min()) {
    const Eigen::Vector2d size = box.sizes().cwiseMax(1.0);
    scale_ = kSide / size.maxCoeff();
    height_ = scale_ * size.y();
    width_ = scale_ * size.x();
  }

  double PageWidth() const { return std::max(width_, kSide / 2) + 2 * kMargin; }
  double PageHeight() const { return height_ + kHeading + 2 * kMargin; }
  double scale() const { return scale_; }

  std::string Line(const char* style, const std::vector<Eigen::Vector2d>& places, bool closed) const {
    if (places.empty()) return "";
    std::string text = fmt::format("<path class=\"{}\" d=\"M", style);
    for (const Eigen::Vector2d& place : places) {
      text += fmt::format("{:.1f},{:.1f} ", kMargin + scale_ * (place.x() - low_.x()),
                          kMargin + kHeading + height_ - scale_ * (place.y() - low_.y()));
    }
    text.back() = closed ? 'Z' : '"';
    return text + (closed ? "\"/>\n" : "/>\n");
  }

 private:
  Eigen::Vector2d low_;
  double scale_ = 1;  // page units in a metre
  double width_ = 0;
  double height_ = 0;
};

Eigen::AlignedBox2d Extent(const PathPicture& picture) {
  Eigen::AlignedBox2d box;
  const auto extend = [&](const std::vector<Eigen::Vector2d>& places) {
    for (const Eigen::Vector2d& place : places) {
      if (!place.allFinite()) throw InputError("the top view: a position is not finite");
      box.extend(place);
    }
  };
  extend(picture.truth);
  extend(picture.estimate);
  for (const auto& outline : picture.outlines) extend(outline);
  if (box.isEmpty()) throw InputError("the top view: nothing to draw");
  return box;
}

// The round length whose bar is nearest to a fifth of the page from below.
double BarMetres(double scale) {
  const double most = kSide / 5 / scale;
  const double decade = std::pow(10, std::floor(std::log10(most)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * decade <= most) return factor * decade;
  }
  return decade;
}

std::string Heading(const std::string& title, double scale) {
  const double metres = BarMetres(scale);
  return fmt::format(
      "<text x=\"{0}\" y=\"28\" class=\"title\">{1}</text>\n"
      "<path class=\"truth\" d=\"M{0},47h30\"/><text x=\"{2}\" y=\"51\">true</text>\n"
      "<path class=\"estimate\" d=\"M{3},47h30\"/><text x=\"{4}\" y=\"51\">estimated</text>\n"
      "<path class=\"bar\" d=\"M{5},47h{6:.1f}\"/><text x=\"{7:.1f}\" y=\"51\">{8:g} m</text>\n",
      kMargin, EscapedXml(title), kMargin + 36, kMargin + 84, kMargin + 120, kMargin + 208, metres * scale,
      kMargin + 214 + metres * scale, metres);
}

}  // namespace

std::string PathSvg(const PathPicture& picture) {
  const Page page(Extent(picture));
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\">\n<style>{2}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
      page.PageWidth(), page.PageHeight(), kStyle);
  text += Heading(picture.title, page.scale());
  for (const auto& outline : picture.outlines) text += page.Line("plan", outline, true);
  text += page.Line("truth", picture.truth, false);
  text += page.Line("estimate", picture.estimate, false);
  return text + "</svg>\n";
}

}  // namespace turnscale
