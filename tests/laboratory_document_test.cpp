// SPDX-License-Identifier: MIT
// Every number in docs/laboratory.md comes from docs/laboratory.json, which is what `turnscale lab` measured.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

namespace fs = std::filesystem;

std::string Document(const std::string& name) { return TextOf(fs::path(TURNSCALE_SOURCE_FOLDER) / "docs" / name); }

std::vector<double> Numbers(const nlohmann::json& json) {
  std::vector<double> numbers;
  const nlohmann::json flat = json.flatten();
  for (const auto& [key, value] : flat.items()) {
    if (value.is_number()) numbers.push_back(value.get<double>());
  }
  return numbers;
}

// What has digits and is no number: code, links, and the names of figures and equations. Line by line, since a regular
// expression of the standard library takes stack for every character that it matches.
std::string WithoutNames(const std::string& text) {
  std::istringstream lines(text);
  std::string plain;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("    ")) continue;
    for (const char* name :
         {"`[^`]*`", "\\]\\([^)]*\\)", "Fig\\. [0-9]+( \\([a-c]\\))?", "\\([0-9]+\\)", "drive 00", "V-[AB]"}) {
      line = std::regex_replace(line, std::regex(name), " ");
    }
    plain += line + "\n";
  }
  return plain;
}

// True where a number of the set, rounded as the text has it, is the text's.
bool Measured(const std::string& token, const std::vector<double>& numbers) {
  const auto point = token.find('.');
  const double decimals = point == std::string::npos ? 0 : static_cast<double>(token.size() - point - 1);
  const double unit = std::pow(10, -decimals);
  const double wanted = std::stod(token);
  return std::ranges::any_of(
      numbers, [&](double number) { return std::abs(std::abs(number) - wanted) <= 0.5 * unit * (1 + 1e-9); });
}

std::vector<std::string> NotMeasured(const std::string& text, const std::vector<double>& numbers) {
  const std::string plain = WithoutNames(text);
  const std::regex number("[0-9]+(\\.[0-9]+)?");
  std::vector<std::string> missing;
  for (std::sregex_iterator match(plain.begin(), plain.end(), number), end; match != end; ++match) {
    if (!Measured(match->str(), numbers)) missing.push_back(match->str());
  }
  return missing;
}

TEST(LaboratoryDocument, HoldsNoNumberThatWasNotMeasured) {
  const std::string text = Document("laboratory.md");
  const std::vector<double> numbers = Numbers(nlohmann::json::parse(Document("laboratory.json")));
  ASSERT_GT(text.size(), 1000U);
  ASSERT_GT(numbers.size(), 50U);
  for (const std::string& token : NotMeasured(text, numbers)) ADD_FAILURE() << token << " is not in laboratory.json";
}

TEST(LaboratoryDocument, NumbersOfOnesOwnAreFound) {
  const std::vector<double> numbers = {0.1234, 12};
  EXPECT_TRUE(NotMeasured("0.12 m in 12 runs; see Fig. 7 and (22), `x 99`", numbers).empty());
  EXPECT_EQ(NotMeasured("0.13 m in 13 runs", numbers), (std::vector<std::string>{"0.13", "13"}));
}

}  // namespace
}  // namespace turnscale
