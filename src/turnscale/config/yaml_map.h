// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "turnscale/base/error.h"

namespace turnscale {

/// Letters to insert, remove or replace to turn one name into the other, upper and lower case taken as equal.
size_t EditDistance(std::string_view a, std::string_view b);

/// The known name that a mistyped one most likely meant; the first of equals. Empty when nothing is known.
std::string NearestName(std::string_view name, std::span<const std::string> known);

/// A map in a YAML file. Every complaint is an InputError that names the file, the line, the key and the value.
class YamlMap {
 public:
  /// Reads a whole file, OpenCV's `%YAML:1.0` header included. Throws InputError where the file cannot be read, is no
  /// YAML, is no map at its top or has a key twice.
  explicit YamlMap(const std::filesystem::path& path);
  YamlMap(const YamlMap&) = default;
  /// A YAML node that is assigned to changes the document it stands in.
  YamlMap& operator=(const YamlMap&) = delete;

  bool Has(const std::string& key) const;
  std::vector<std::string> Keys() const;
  /// The map under a key.
  YamlMap Map(const std::string& key) const;
  bool IsMap(const std::string& key) const;

  /// Values; all throw where the key is missing or the value is of another kind. Numbers are finite.
  std::string Text(const std::string& key) const;
  double Number(const std::string& key) const;
  /// Nothing for `none`, or for YAML's null.
  std::optional<double> NumberOrNone(const std::string& key) const;
  int Integer(const std::string& key) const;
  bool Bool(const std::string& key) const;
  std::vector<double> Numbers(const std::string& key) const;
  /// Number that is above zero, e.g. a focal length.
  double Positive(const std::string& key) const;
  /// Number from -180 to 180, degrees.
  double Angle(const std::string& key) const;

  /// Throws for the first key that is not among `known`, and names the nearest that is.
  void AllowOnly(std::span<const std::string> known) const;
  /// The same for the maps below, too: `known` has every key of a file, maps included, with those above it, such as
  /// "scale" and "scale.drift". Says where a key belongs that is known elsewhere. Keys in `passed_over` may stand in
  /// the file, but are not suggested.
  void AllowOnlyNested(std::span<const std::string> known, std::span<const std::string> passed_over = {}) const;
  /// Calls Check() of what was read from this map. A complaint "key: why" (base/check_part.h), with the keys above,
  /// gets file, line and, where it does not begin with it, the value if the key is in the file, else the file.
  template <class Options>
  void CheckRead(const Options& options) const {
    try {
      options.Check();
    } catch (const InputError& error) {
      RejectRead(error.what());
    }
  }
  /// Throws InputError "file:line: key: why".
  [[noreturn]] void Reject(const std::string& key, std::string_view why) const;

 private:
  YamlMap(std::string path, std::string prefix, const YAML::Node& node);
  void RefuseRepeatedKeys() const;
  YAML::Node Value(const std::string& key) const;
  std::string Scalar(const std::string& key, std::string_view wanted) const;
  [[noreturn]] void RejectRead(const std::string& complaint) const;

  std::string path_;
  std::string prefix_;  // of keys in messages, e.g. "cam0."
  YAML::Node node_;
};

}  // namespace turnscale
