// SPDX-License-Identifier: MIT
#include "turnscale/config/yaml_map.h"

#include <fstream>

#include <gtest/gtest.h>

#include "turnscale/base/error.h"
#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

YamlMap MapOf(const std::string& text) {
  const std::string path = ScratchPath("yaml_map_test.yaml");
  std::ofstream(path) << text;
  return YamlMap(path);
}

template <class Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(NearestName, CountsEditsAndTakesTheNearest) {
  EXPECT_EQ(EditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(EditDistance("", "abc"), 3u);
  EXPECT_EQ(EditDistance("Abc", "abC"), 0u);
  const std::vector<std::string> known = {"lever_arm", "side_slip", "threads"};
  EXPECT_EQ(NearestName("thread", known), "threads");
  EXPECT_EQ(NearestName("leverarm", known), "lever_arm");
  EXPECT_EQ(NearestName("x", {}), "");
}

TEST(YamlMap, ReadsValuesOfEveryKind) {
  const YamlMap map = MapOf("%YAML:1.0\n---\na: 1.5\nb: -3\nc: true\nd: [1, 2.5]\ne: word\nf:\n  g: 2\n");
  EXPECT_EQ(map.Number("a"), 1.5);
  EXPECT_EQ(map.Integer("b"), -3);
  EXPECT_TRUE(map.Bool("c"));
  EXPECT_EQ(map.Numbers("d"), (std::vector<double>{1, 2.5}));
  EXPECT_EQ(map.Text("e"), "word");
  EXPECT_TRUE(map.IsMap("f"));
  EXPECT_EQ(map.Map("f").Positive("g"), 2);
  EXPECT_EQ(map.Keys(), (std::vector<std::string>{"a", "b", "c", "d", "e", "f"}));
  EXPECT_FALSE(map.Has("z"));
  EXPECT_EQ(MapOf("\xEF\xBB\xBF%YAML:1.0\n---\na: 1.5\n").Number("a"), 1.5) << "after a byte-order mark";
}

TEST(YamlMap, ANumberMayBeNone) {
  const YamlMap map = MapOf("a: none\nb: null\nc: ~\nd:\ne: 1.5\nf: some\ng: [1]\nh: .nan\n");
  for (const char* key : {"a", "b", "c", "d"}) EXPECT_EQ(map.NumberOrNone(key), std::nullopt) << key;
  EXPECT_EQ(map.NumberOrNone("e"), 1.5);
  EXPECT_NE(MessageOf([&] { map.NumberOrNone("f"); }).find(":6: f: is 'some'; give a number or none"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { map.NumberOrNone("g"); }).find("g: is not a scalar; give a number or none"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { map.NumberOrNone("h"); }).find("give a finite number"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.NumberOrNone("z"); }).find("z: is missing"), std::string::npos);
}

TEST(YamlMap, ComplaintsNameLineKeyAndValue) {
  const YamlMap map = MapOf("%YAML:1.0\n---\na: .nan\nb: 1.5\nc: maybe\nd: [1, x]\nf:\n  g: -2\n");
  EXPECT_NE(MessageOf([&] { map.Number("a"); }).find("yaml_map_test.yaml:3: a: is '.nan'"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Integer("b"); }).find("is '1.5'; give a whole number"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Bool("c"); }).find("'maybe'"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Numbers("d"); }).find("'x' at position 2"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Numbers("b"); }).find("is not a list"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Map("f").Positive("g"); }).find(":8: f.g: is -2"), std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Text("z"); }).find("z: is missing"), std::string::npos);
  EXPECT_EQ(MessageOf([&] { MapOf("a: " + std::string(99, 'x')).Number("a"); }).find(std::string(41, 'x')),
            std::string::npos);
  EXPECT_NE(MessageOf([&] { map.Number("f"); }).find("is not a scalar"), std::string::npos);
}

TEST(YamlMap, UnknownKeyNamesTheNearestKnown) {
  const std::vector<std::string> known = {"alpha", "beta"};
  EXPECT_NE(MessageOf([&] {
              MapOf("alpha: 1\nbeat: 2\n").AllowOnly(known);
            }).find(":2: beat: unknown key; did you mean 'beta'?"),
            std::string::npos);
  EXPECT_NE(MessageOf([&] {
              MapOf(std::string(99, 'x') + ": 1\n").AllowOnly(known);
            }).find(": " + std::string(40, 'x') + "...: unknown key"),
            std::string::npos);
  EXPECT_NO_THROW(MapOf("beta: 1\n").AllowOnly(known));
}

TEST(YamlMap, RejectsWhatIsNoYamlMap) {
  EXPECT_NE(MessageOf([] { MapOf("a: [1, 2\nb: 3\n"); }).find("not valid YAML"), std::string::npos);
  EXPECT_NE(MessageOf([] { MapOf("- 1\n- 2\n"); }).find("has no keys"), std::string::npos);
  EXPECT_NE(MessageOf([] { MapOf(""); }).find("has no keys"), std::string::npos);
  EXPECT_NE(MessageOf([] { YamlMap{"/nonexistent/cam.yaml"}; }).find("no such file"), std::string::npos);
  EXPECT_NE(MessageOf([] { YamlMap{::testing::TempDir()}; }).find("is a folder"), std::string::npos);
}

}  // namespace
}  // namespace turnscale
