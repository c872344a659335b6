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

TEST(YamlMap, AKeyThatStandsTwiceIsRefused) {
  EXPECT_NE(MessageOf([] { MapOf("alpha: 1\nbeta: 2\nalpha: 3\n"); }).find(":3: alpha: stands twice"),
            std::string::npos);
  EXPECT_NE(MessageOf([] { MapOf("a:\n  b: 1\n  b: 2\n").Map("a"); }).find(":3: a.b: stands twice"), std::string::npos);
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
  EXPECT_NE(MessageOf([&] { MapOf("alp: 1\n").AllowOnly(known); }).find("did you mean 'alpha'?"), std::string::npos);
  EXPECT_NE(MessageOf([&] {
              MapOf("wheelbase_m: 1\n").AllowOnly(known);
            }).find(":1: wheelbase_m: unknown key; remove it, or correct its name"),
            std::string::npos);
  EXPECT_NO_THROW(MapOf("beta: 1\n").AllowOnly(known));
}

TEST(YamlMap, UnknownKeyNamesThePlaceOrTheNearestOfAllLevels) {
  const std::vector<std::string> known = {"top", "a.b", "a", "a.size", "a.b.width", "a.wit", "c", "c.size", "c.length"};
  const auto complaint = [&](const std::string& text) {
    return MessageOf([&] { MapOf(text).AllowOnlyNested(known); });
  };
  const auto expect = [&](const std::string& text, const std::string& part) {
    EXPECT_NE(complaint(text).find(part), std::string::npos) << complaint(text);
  };
  EXPECT_EQ(complaint("a:\n  b:\n    width: 1\n  size: 2\nc:\n"), "no error");
  EXPECT_EQ(complaint("top:\n  more: 1\n"), "no error") << "a value, not a map: whoever reads it says so";
  expect("top: 1\nb:\n  width: 1\n", ":2: b: unknown key; it belongs below 'a'");
  expect("c:\n  width: 1\n", ":2: c.width: unknown key; it belongs below 'a.b'");
  expect("c:\n  top: 1\n", ":2: c.top: unknown key; it belongs at the top level");
  expect("size: 1\n", ":1: size: unknown key; it belongs below 'a' or 'c'");
  expect("a.b.width: 1\n", "write 'a:', 'b:' and 'width:' on separate lines, each indented below the one before");
  expect("a:\n  b.width: 1\n", ":2: a.b.width: unknown key; write 'a:', 'b:' and 'width:' on separate lines");
  expect("c:\n  a.size: 1\n", ":2: c.a.size: unknown key; at the top level, write 'a:' and 'size:' on separate lines");
  expect("a.b.widht: 1\n", "did you mean 'a.b.width'?");
  expect("lenght: 1\n", "did you mean 'c.length'?");
  expect("c:\n  sizes: 1\n", "did you mean 'c.size'?");
  expect("a:\n  widt: 1\n", "did you mean 'a.wit'?");
  expect("wheelbase_m: 1\n", ":1: wheelbase_m: unknown key; remove it, or correct its name");
}

TEST(YamlMap, AComplaintOfACheckGetsLineAndValue) {
  struct Part {
    std::string complaint;
    void Check() const { throw InputError(complaint); }
  };
  const YamlMap map = MapOf("a:\n  b: 1e3\n  c: [1]\nd: 2\n");
  const auto complaint = [&](const std::string& text) {
    const std::string message = MessageOf([&] { map.CheckRead(Part{text}); });
    return message.substr(message.find("yaml_map_test.yaml") + std::string_view("yaml_map_test").size());
  };
  EXPECT_EQ(complaint("a.b: has to be below 1"), ".yaml:2: a.b: is 1e3; it has to be below 1");
  EXPECT_EQ(complaint("d: must not be negative"), ".yaml:4: d: is 2; it must not be negative");
  EXPECT_EQ(complaint("d: must be at least 3"), ".yaml:4: d: is 2; it must be at least 3");
  EXPECT_EQ(complaint("d: is longer than e"), ".yaml:4: d: is 2; it is longer than e");
  EXPECT_EQ(complaint("d: the sum of it and e is above 1"), ".yaml:4: d: is 2; the sum of it and e is above 1");
  EXPECT_EQ(complaint("d: 2 has to be below e"), ".yaml:4: d: 2 has to be below e");
  EXPECT_EQ(complaint("a.c: has to be short"), ".yaml:3: a.c: has to be short");
  EXPECT_EQ(complaint("d: is 2; give 1"), ".yaml:4: d: is 2; give 1");
  EXPECT_EQ(complaint("a.e: has to be below 1"), ".yaml: a.e: has to be below 1");
  EXPECT_EQ(complaint("e.b: has to be below 1"), ".yaml: e.b: has to be below 1");
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
