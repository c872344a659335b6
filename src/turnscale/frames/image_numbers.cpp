// SPDX-License-Identifier: MIT
#include "turnscale/frames/image_numbers.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <iterator>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "turnscale/base/error.h"
#include "turnscale/frames/recording_time.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

// A name without its extension: its runs of digits, and the text with a # in the place of each.
struct NameParts {
  std::string text;
  std::vector<std::string> digits;
};

NameParts PartsOf(const fs::path& image) {
  NameParts parts;
  bool in_digits = false;
  for (const char c : image.stem().string()) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!is_digit) {
      parts.text += c;
    } else if (in_digits) {
      parts.digits.back() += c;
    } else {
      parts.text += '#';
      parts.digits.emplace_back(1, c);
    }
    in_digits = is_digit;
  }
  return parts;
}

std::string ImageName(const fs::path& image) { return image.filename().string(); }

// Which number of the names differs; nothing if none or more than one does, or their text.
std::optional<size_t> NumberThatDiffers(const std::vector<NameParts>& names) {
  std::optional<size_t> found;
  for (const NameParts& name : names) {
    if (name.text != names.front().text || name.digits.size() != names.front().digits.size()) return std::nullopt;
    for (size_t i = 0; i < name.digits.size(); ++i) {
      if (name.digits[i] == names.front().digits[i]) continue;
      if (found && *found != i) return std::nullopt;
      found = i;
    }
  }
  return found;
}

// Nothing for what is not a count.
std::optional<int64_t> CountIn(const std::string& digits) {
  constexpr int64_t kLeastTime = 1'000'000'000;  // seconds since 1970
  int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc() || number >= kLeastTime) return std::nullopt;
  return number;
}

// Single images that lie beside those of a drive do no harm.
constexpr size_t kFewestOfSeries = 10;
constexpr size_t kMostSeries = 8;

}  // namespace

std::optional<ImageNumbers> ImageNumbers::Find(const std::vector<fs::path>& images) {
  // One step of two is no usual one.
  constexpr size_t kFewest = 3;
  if (images.size() < kFewest) return std::nullopt;
  if (TimeInName(ImageName(images.front())) != TimeInName(ImageName(images.back()))) return std::nullopt;
  std::vector<NameParts> names;
  for (const fs::path& image : images) names.push_back(PartsOf(image));
  const std::optional<size_t> differing = NumberThatDiffers(names);
  if (!differing) return std::nullopt;
  std::vector<int64_t> numbers;
  for (const NameParts& name : names) {
    const std::optional<int64_t> number = CountIn(name.digits[*differing]);
    if (!number || (!numbers.empty() && *number <= numbers.back())) return std::nullopt;
    numbers.push_back(*number);
  }
  int64_t step = numbers[1] - numbers[0];
  for (size_t i = 1; i < numbers.size(); ++i) step = std::min(step, numbers[i] - numbers[i - 1]);
  size_t usual = 0;
  for (size_t i = 1; i < numbers.size(); ++i) {
    const int64_t difference = numbers[i] - numbers[i - 1];
    if (difference % step != 0) return std::nullopt;
    usual += difference == step ? 1 : 0;
  }
  if (2 * usual < numbers.size() - 1) return std::nullopt;
  const int64_t origin = numbers.front();
  for (int64_t& number : numbers) number = (number - origin) / step;
  return ImageNumbers(std::move(numbers), step);
}

std::vector<double> ImageNumbers::TimesAt(double fps) const {
  std::vector<double> times;
  for (const int64_t position : positions_) times.push_back(static_cast<double>(position) / fps);
  return times;
}

std::string ImageNumbers::Notice(const std::vector<fs::path>& images, double fps, size_t first, size_t last) const {
  int64_t missing = 0;
  int64_t most = 0;
  size_t after = first;
  for (size_t i = first + 1; i < last; ++i) {
    const int64_t between = positions_[i] - positions_[i - 1] - 1;
    missing += between;
    if (between <= most) continue;
    most = between;
    after = i;
  }
  std::string notice;
  if (missing > 0)
    notice = fmt::format(
        "{} image{} missing by the numbers of the names, {} of them between {} and {}, and count{} as {:.1f} s "
        "at --fps {:g}; give --timestamps FILE if no time has passed there",
        missing, missing > 1 ? "s are" : " is", most, ImageName(images[after - 1]), ImageName(images[after]),
        missing > 1 ? "" : "s", static_cast<double>(missing) / fps, fps);
  if (step_ > 1 && last > first + 1)
    notice += fmt::format(
        "{}the numbers of the image names increase by {} ({}, {}); --fps {:g} is taken as the rate of these images: if "
        "it is the rate of all numbers, give --fps {:g}",
        notice.empty() ? "" : "; ", step_, ImageName(images[first]), ImageName(images[first + 1]), fps,
        fps / static_cast<double>(step_));
  return notice;
}

void RefuseSeveralSeries(const fs::path& folder, const std::vector<fs::path>& images) {
  // Names that hold arbitrary letters are of many kinds.
  constexpr double kLeastShare = 0.9;
  struct Series {
    size_t first;
    size_t last;
    size_t count;
  };
  std::map<std::string, Series> all;
  for (size_t i = 0; i < images.size(); ++i) {
    Series& series = all.try_emplace(PartsOf(images[i]).text, Series{i, i, 0}).first->second;
    series.last = i;
    ++series.count;
  }
  std::erase_if(all, [](const auto& item) { return item.second.count < kFewestOfSeries; });
  size_t of_series = 0;
  for (const auto& [text, series] : all) of_series += series.count;
  if (all.size() < 2 || all.size() > kMostSeries ||
      static_cast<double>(of_series) < kLeastShare * static_cast<double>(images.size())) {
    return;
  }
  const auto range = [&](const Series& series) {
    return fmt::format("{} to {} ({} images)", ImageName(images[series.first]), ImageName(images[series.last]),
                       series.count);
  };
  throw InputError(fmt::format(
      "{}: holds images of several cameras or drives, {} and {}; give a folder with the images of one camera only",
      folder.string(), range(all.begin()->second), range(std::next(all.begin())->second)));
}

std::string RepeatedNumbersNotice(const std::vector<fs::path>& images) {
  std::vector<NameParts> names;
  for (const fs::path& image : images) {
    names.push_back(PartsOf(image));
    if (names.back().text != names.front().text) return {};
  }
  const size_t numbers = names.empty() ? 0 : names.front().digits.size();
  for (size_t counter = 0; counter < numbers; ++counter) {
    // The values of this number for each combination of the others.
    std::map<std::vector<std::string>, std::vector<std::string>> series;
    for (const NameParts& name : names) {
      std::vector<std::string> others = name.digits;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(counter));
      series[std::move(others)].push_back(name.digits[counter]);
    }
    const std::vector<std::string>& first = series.begin()->second;
    const bool repeat = std::ranges::all_of(series, [&](const auto& item) { return item.second == first; });
    if (!repeat || series.size() < 2 || series.size() > kMostSeries || first.size() < kFewestOfSeries) continue;
    return fmt::format(
        "{} images have each number of the names ({} to {}), and all are read as one drive; if they are of several "
        "cameras, give a folder with the images of one camera only",
        series.size(), ImageName(images.front()), ImageName(images.back()));
  }
  return {};
}

}  // namespace turnscale
