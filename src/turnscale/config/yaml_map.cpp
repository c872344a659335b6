// SPDX-License-Identifier: MIT
#include "turnscale/config/yaml_map.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>

#include "turnscale/base/error.h"
#include "turnscale/base/escaped_text.h"
#include "turnscale/base/input_file.h"
#include "turnscale/base/number_text.h"
#include "turnscale/base/text_lines.h"

namespace turnscale {
namespace {

std::string ReadText(const std::filesystem::path& path) {
  CheckInputFile(path, "file");
  std::error_code none;
  // Reading a device or a pipe may not end.
  if (!std::filesystem::is_regular_file(path, none))
    throw InputError(path.string() + ": cannot be read as a YAML file");
  std::ifstream stream = OpenInputFile(path, "file");
  return {std::istreambuf_iterator<char>(stream), {}};
}

// OpenCV heads its files with "%YAML:1.0", which is no YAML directive; as a comment it keeps the line numbers.
YAML::Node Parse(const std::filesystem::path& path) {
  std::string text = ReadText(path);
  if (text.starts_with(kByteOrderMark)) text.erase(0, kByteOrderMark.size());
  if (text.starts_with("%YAML:")) text[0] = '#';
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw InputError(path.string() + ":" + std::to_string(error.mark.line + 1) + ": not valid YAML: " + error.msg);
  }
}

std::optional<double> NumberOf(std::string_view text) {
  // YAML spells .nan and .inf with a dot.
  if (text == ".nan" || text == ".NaN" || text == ".NAN") return std::numeric_limits<double>::quiet_NaN();
  if (text == ".inf" || text == "-.inf") return std::numeric_limits<double>::infinity();
  return ParseNumber<double>(text);
}

bool Contains(std::span<const std::string> names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

bool IsGroup(std::span<const std::string> names, const std::string& name) {
  return std::ranges::any_of(names, [&](const std::string& other) { return other.starts_with(name + "."); });
}

// "'a'", "'a' and 'b'", "'a', 'b' and 'c'".
std::string Enumeration(const std::vector<std::string>& names, const std::string& last) {
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " " + last + " ") + ("'" + names[i] + "'");
  return text;
}

// A key of a nested map by its dotted name, which YAML takes for one long key.
std::string NestingHint(const std::string& name) {
  std::vector<std::string> lines;
  for (size_t begin = 0; begin <= name.size();) {
    const size_t end = std::min(name.find('.', begin), name.size());
    lines.push_back(name.substr(begin, end - begin) + ":");
    begin = end + 1;
  }
  return "write " + Enumeration(lines, "and") + " on separate lines, each indented below the one before";
}

// Whether a complaint (base/check_part.h) says the value itself: "is 3; ...", "is 'red'; ...", "3 has to be ...".
bool BeginsWithValue(std::string_view why) {
  if (why.starts_with("is ")) why.remove_prefix(3);
  return !why.empty() &&
         (std::isdigit(static_cast<unsigned char>(why.front())) != 0 || why.front() == '-' || why.front() == '\'');
}

// Whether it goes on after "it".
bool BeginsWithVerb(std::string_view why) {
  return std::ranges::any_of(std::array{"has ", "must ", "is "},
                             [&](const char* verb) { return why.starts_with(verb); });
}

// Whether a key is likely meant for this name: few of its letters are wrong, or one is the beginning of the other.
bool IsNear(std::string_view key, std::string_view name, size_t edits) {
  constexpr size_t kLeastBeginning = 3;
  if (edits <= std::max<size_t>(2, key.size() / 3)) return true;
  return std::min(key.size(), name.size()) >= kLeastBeginning && (name.starts_with(key) || key.starts_with(name));
}

std::string Suggestion(const std::string& name) {
  return name.empty() ? "remove it, or correct its name" : "did you mean '" + name + "'?";
}

// What may be meant by a key below `prefix` ("" or "scale.") that is not among all the dotted names.
std::string HintFor(const std::string& prefix, const std::string& key, std::span<const std::string> known) {
  if (key.find('.') != std::string::npos) {
    if (Contains(known, prefix + key)) return NestingHint(prefix + key);
    if (Contains(known, key)) return "at the top level, " + NestingHint(key);
  }
  std::vector<std::string> groups;  // that have such a key
  std::string nearest;
  size_t least = std::string::npos;
  for (const std::string& name : known) {
    const size_t split = name.rfind('.') + 1;  // 0 at the top
    const std::string parent = name.substr(0, split);
    if (name == key) return "it belongs at the top level";
    if (name.substr(split) == key) groups.push_back(name.substr(0, split - 1));
    // Twice the edits, so that the one for another level only decides between equals.
    const size_t edits = std::min(EditDistance(key, name.substr(split)), EditDistance(prefix + key, name));
    const size_t distance = 2 * edits + (parent == prefix ? 0 : 1);
    if (distance >= least || !IsNear(key, name.substr(split), edits)) continue;
    least = distance;
    nearest = name;
  }
  if (!groups.empty()) return "it belongs below " + Enumeration(groups, "or");
  return Suggestion(nearest);
}

}  // namespace

size_t EditDistance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t replaced = diagonal + (lower(a[i]) == lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

std::string NearestName(std::string_view name, std::span<const std::string> known) {
  const auto nearest = std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
    return EditDistance(name, a) < EditDistance(name, b);
  });
  return nearest == known.end() ? std::string() : *nearest;
}

YamlMap::YamlMap(const std::filesystem::path& path) : YamlMap(path.string(), "", Parse(path)) {
  if (!node_.IsMap()) throw InputError(path_ + ": has no keys; expected lines of the form 'key: value'");
}

YamlMap::YamlMap(std::string path, std::string prefix, const YAML::Node& node)
    : path_(std::move(path)), prefix_(std::move(prefix)), node_(node) {
  RefuseRepeatedKeys();
}

// Of two values, one would be ignored.
void YamlMap::RefuseRepeatedKeys() const {
  if (!node_.IsMap()) return;
  std::vector<std::string> keys = Keys();
  std::ranges::sort(keys);
  const auto repeated = std::ranges::adjacent_find(keys);
  if (repeated != keys.end()) Reject(*repeated, "stands twice; leave one of them");
}

bool YamlMap::Has(const std::string& key) const { return static_cast<bool>(node_[key]); }

bool YamlMap::IsMap(const std::string& key) const { return Has(key) && node_[key].IsMap(); }

std::vector<std::string> YamlMap::Keys() const {
  std::vector<std::string> keys;
  for (const auto& entry : node_) keys.push_back(entry.first.IsScalar() ? entry.first.Scalar() : std::string());
  return keys;
}

YamlMap YamlMap::Map(const std::string& key) const {
  const YAML::Node value = Value(key);
  if (!value.IsMap()) Reject(key, "is not a map; give its keys on indented lines below it");
  return {path_, prefix_ + key + ".", value};
}

std::string YamlMap::Text(const std::string& key) const { return Scalar(key, "a text"); }

double YamlMap::Number(const std::string& key) const {
  const std::string text = Scalar(key, "a number");
  const std::optional<double> value = NumberOf(text);
  if (!value || !std::isfinite(*value)) Reject(key, "is '" + Excerpt(text) + "'; give a finite number");
  return *value;
}

std::optional<double> YamlMap::NumberOrNone(const std::string& key) const {
  if (Value(key).IsNull() || Scalar(key, "a number or none") == "none") return std::nullopt;
  if (!NumberOf(Text(key))) Reject(key, "is '" + Excerpt(Text(key)) + "'; give a number or none");
  return Number(key);
}

int YamlMap::Integer(const std::string& key) const {
  const double value = Number(key);
  if (value != std::floor(value) || std::abs(value) > std::numeric_limits<int>::max()) {
    Reject(key, "is '" + Excerpt(Text(key)) + "'; give a whole number");
  }
  return static_cast<int>(value);
}

bool YamlMap::Bool(const std::string& key) const {
  const std::string text = Scalar(key, "true or false");
  if (text != "true" && text != "false") Reject(key, "is '" + Excerpt(text) + "'; give true or false");
  return text == "true";
}

std::vector<double> YamlMap::Numbers(const std::string& key) const {
  const YAML::Node value = Value(key);
  if (!value.IsSequence()) Reject(key, "is not a list; give numbers as [a, b, ...]");
  std::vector<double> numbers;
  for (const YAML::Node& item : value) {
    const std::optional<double> number = item.IsScalar() ? NumberOf(item.Scalar()) : std::nullopt;
    if (!number || !std::isfinite(*number)) {
      Reject(key, std::string("has '") + (item.IsScalar() ? Excerpt(item.Scalar()) : "?") + "' at position " +
                      std::to_string(numbers.size() + 1) + "; give finite numbers");
    }
    numbers.push_back(*number);
  }
  return numbers;
}

double YamlMap::Positive(const std::string& key) const {
  const double value = Number(key);
  if (!(value > 0)) Reject(key, std::string("is ") + Text(key) + "; give a number above 0");
  return value;
}

double YamlMap::Angle(const std::string& key) const {
  const double degrees = Number(key);
  if (!(std::abs(degrees) <= 180)) Reject(key, "is " + Text(key) + "; give an angle from -180 to 180 degrees");
  return degrees;
}

void YamlMap::AllowOnly(std::span<const std::string> known) const {
  for (const std::string& key : Keys()) {
    if (Contains(known, key)) continue;
    const std::string nearest = NearestName(key, known);
    const bool is_near = IsNear(key, nearest, EditDistance(key, nearest));
    Reject(key, "unknown key; " + Suggestion(is_near ? prefix_ + nearest : ""));
  }
}

void YamlMap::AllowOnlyNested(std::span<const std::string> known, std::span<const std::string> passed_over) const {
  for (const std::string& key : Keys()) {
    const bool is_dotted = key.find('.') != std::string::npos;
    if (!is_dotted && Contains(passed_over, prefix_ + key)) continue;
    if (is_dotted || !Contains(known, prefix_ + key)) Reject(key, "unknown key; " + HintFor(prefix_, key, known));
    if (IsGroup(known, prefix_ + key) && IsMap(key)) Map(key).AllowOnlyNested(known, passed_over);
  }
}

void YamlMap::RejectRead(const std::string& complaint) const {
  constexpr std::string_view kSeparator = ": ";
  const size_t end = complaint.find(kSeparator);
  const std::string name = complaint.substr(0, end);
  const std::string key = name.substr(0, name.find('.'));
  if (end == std::string::npos || !Has(key)) throw InputError(path_ + ": " + prefix_ + complaint);
  if (key != name && IsMap(key)) Map(key).RejectRead(complaint.substr(key.size() + 1));
  const std::string why = complaint.substr(end + kSeparator.size());
  if (BeginsWithValue(why) || !node_[key].IsScalar()) Reject(key, why);
  Reject(key, "is " + Excerpt(Text(key)) + "; " + (BeginsWithVerb(why) ? "it " : "") + why);
}

void YamlMap::Reject(const std::string& key, std::string_view why) const {
  int line = 0;
  for (const auto& entry : node_) {
    if (entry.first.IsScalar() && entry.first.Scalar() == key) line = entry.first.Mark().line + 1;
  }
  const std::string place = line > 0 ? path_ + ":" + std::to_string(line) : path_;
  throw InputError(place + ": " + prefix_ + Excerpt(key) + ": " + std::string(why));
}

YAML::Node YamlMap::Value(const std::string& key) const {
  if (!Has(key)) Reject(key, "is missing; add it");
  return node_[key];
}

std::string YamlMap::Scalar(const std::string& key, std::string_view wanted) const {
  const YAML::Node value = Value(key);
  if (!value.IsScalar()) Reject(key, std::string("is not a scalar; give ").append(wanted));
  return value.Scalar();
}

}  // namespace turnscale
