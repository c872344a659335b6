// SPDX-License-Identifier: MIT
#include "turnscale/export/utc_time.h"

#include <chrono>
#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "turnscale/base/number_text.h"
#include "turnscale/frames/recording_time.h"

namespace turnscale {
namespace {

namespace chrono = std::chrono;

constexpr double kSecondsPerDay = 86400;

// Takes numbers of a fixed number of digits, and the signs between them, from the front of a text.
class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  int Number(size_t digits) {
    const std::string_view word = text_.substr(0, digits);
    const auto value = word.size() == digits && word.find_first_not_of("0123456789") == std::string_view::npos
                           ? ParseNumber<int>(word)
                           : std::nullopt;
    if (!value) good_ = false;
    text_.remove_prefix(word.size());
    return value.value_or(0);
  }

  char Sign(std::string_view allowed) {
    const char sign = text_.empty() ? '\0' : text_[0];
    if (sign == '\0' || allowed.find(sign) == std::string_view::npos) good_ = false;
    if (!text_.empty()) text_.remove_prefix(1);
    return sign;
  }

  double Decimals() {
    if (!text_.starts_with('.')) return 0;
    const size_t end = std::min(text_.find_first_not_of("0123456789", 1), text_.size());
    const auto value = ParseNumber<double>(text_.substr(0, end));
    if (!value || end < 2) good_ = false;
    text_.remove_prefix(end);
    return value.value_or(0);
  }

  bool good() const { return good_ && text_.empty(); }

 private:
  std::string_view text_;
  bool good_ = true;
};

}  // namespace

std::optional<double> ParseUtcTime(std::string_view text) {
  Reader reader(text);
  const int year = reader.Number(4);
  reader.Sign("-");
  const int month = reader.Number(2);
  reader.Sign("-");
  const int day = reader.Number(2);
  reader.Sign("Tt ");
  const int hour = reader.Number(2);
  reader.Sign(":");
  const int minute = reader.Number(2);
  reader.Sign(":");
  const int second = reader.Number(2);
  const double decimals = reader.Decimals();
  const char zone = reader.Sign("Zz+-");
  int offset = 0;
  if (zone == '+' || zone == '-') {
    const int hours = reader.Number(2);
    reader.Sign(":");
    const int minutes = reader.Number(2);
    offset = (zone == '+' ? 1 : -1) * (hours * 60 + minutes) * 60;
  }
  const chrono::year_month_day date{chrono::year(year), chrono::month(static_cast<unsigned>(month)),
                                    chrono::day(static_cast<unsigned>(day))};
  if (!reader.good() || !date.ok() || hour > 23 || minute > 59 || second > 60) return std::nullopt;
  const auto days = chrono::sys_days(date).time_since_epoch().count();
  return kSecondsPerDay * static_cast<double>(days) + 3600 * hour + 60 * minute + second + decimals - offset;
}

std::string UtcTimeText(double seconds) {
  const auto milliseconds = static_cast<int64_t>(std::llround(seconds * 1000));
  const double whole = std::floor(static_cast<double>(milliseconds) / 1000);
  return fmt::format("{}.{:03}Z", RecorderTimeText(whole), milliseconds - 1000 * static_cast<int64_t>(whole));
}

}  // namespace turnscale
