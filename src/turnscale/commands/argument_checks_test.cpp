// SPDX-License-Identifier: MIT
#include "turnscale/commands/argument_checks.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "turnscale/base/test_files.h"

namespace turnscale {
namespace {

template <class Work>
std::string Complaint(const Work& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(ArgumentChecks, TwoOptionsMayExcludeEachOther) {
  EXPECT_EQ(Complaint([] { RefuseBoth({"--fps", true}, {"--timestamps", true}); }), "--fps: excludes --timestamps");
  EXPECT_EQ(Complaint([] { RefuseBoth({"--fps", true}, {"--timestamps", false}); }), "");
  EXPECT_EQ(Complaint([] { RefuseBoth({"--fps", false}, {"--timestamps", true}); }), "");
}

TEST(ArgumentChecks, AnOptionMayNeedAnother) {
  EXPECT_EQ(Complaint([] { RequireFor({"--metric", true}, false, "--trajectory"); }), "--metric: needs --trajectory");
  EXPECT_EQ(Complaint([] { RequireFor({"--metric", true}, true, "--trajectory"); }), "");
  EXPECT_EQ(Complaint([] { RequireFor({"--metric", false}, false, "--trajectory"); }), "");
}

TEST(ArgumentChecks, RulesAreOfTheOptionsThatTheyName) {
  const OptionRules rules = {.exclusive = {{"--fps", "--timestamps"}}, .needs = {{"--metric", "--trajectory"}}};
  const auto complaint = [&](bool timestamps, bool metric, bool trajectory) {
    return Complaint([&] {
      CheckTogether(
          rules, {{"--fps", true}, {"--timestamps", timestamps}, {"--metric", metric}, {"--trajectory", trajectory}});
    });
  };
  EXPECT_EQ(complaint(false, false, false), "");
  EXPECT_EQ(complaint(false, true, true), "");
  EXPECT_EQ(complaint(true, false, false), "--fps: excludes --timestamps");
  EXPECT_EQ(complaint(false, true, false), "--metric: needs --trajectory");
  EXPECT_THROW(CheckTogether(rules, {{"--fps", true}}), InternalError);
}

TEST(ArgumentChecks, AChoiceNamesWhatThereIs) {
  EXPECT_EQ(Complaint([] {
              CheckChoice("--drift", "some", {"auto", "none"});
            }),
            "--drift some: give one of auto, none");
  EXPECT_EQ(Complaint([] { CheckChoice("--drift", "none", {"auto", "none"}); }), "");
}

TEST(ArgumentChecks, ASigmaIsBelowItsLeverArm) {
  EXPECT_EQ(CheckedLeverArmSigma(0.4, 0.5), 0.4);
  EXPECT_EQ(CheckedLeverArmSigma(0.9, {}), 0.9);
  EXPECT_EQ(Complaint([] { CheckedLeverArmSigma(0.03, 0.02); }),
            "--lever-arm-sigma 0.03: has to be below the lever arm, 0.02 m");
}

TEST(ArgumentChecks, AnOutputFileIsNoInputFile) {
  const std::filesystem::path folder = ScratchPath("overwrite");
  std::filesystem::create_directories(folder);
  const std::filesystem::path input = folder / "a.csv.part";
  std::ofstream(input) << "1";
  const auto complaint = [&](const char* output) {
    return Complaint([&] { CheckOutputs({{"--out", folder / output}}, {"", folder / "none", input}); });
  };
  const std::string refused =
      "--out " + input.string() + ": is also an input file, and would be replaced; choose another --out";
  EXPECT_EQ(complaint("a.csv.part"), refused);
  EXPECT_EQ(complaint("a.csv"), refused) << "its name while it is being written";
  EXPECT_EQ(complaint("b.csv"), "");
  EXPECT_EQ(Complaint([&] { CheckOutputs({{"--out", ""}}, {input}); }), "");
  std::filesystem::remove_all(folder);
}

TEST(ArgumentChecks, TwoOutputsAreTwoFiles) {
  const auto complaint = [](const char* json, const char* picture) {
    return Complaint([&] { CheckOutputs({{"--json", json}, {"--picture", picture}}, {}); });
  };
  EXPECT_EQ(complaint("out/a", "out/../out/./a"),
            "--picture out/../out/./a: is also a file of --json; choose another --picture");
  EXPECT_EQ(complaint("a", "a.part"), "--picture a.part: is also a file of --json; choose another --picture");
  EXPECT_EQ(complaint("out/a", "a"), "");
  EXPECT_EQ(complaint("/dev/null", "/dev/null"), "");
  const std::string nowhere(300, 'x');
  EXPECT_EQ(complaint((nowhere + "/a").c_str(), (nowhere + "/b").c_str()), "") << "writing says why";
  EXPECT_EQ(complaint("", ""), "");
}

TEST(ArgumentChecks, AHeightMayHaveASigma) {
  EXPECT_EQ(ParseCameraHeight("1.5").metres, 1.5);
  EXPECT_FALSE(ParseCameraHeight("1.5").sigma);
  EXPECT_EQ(ParseCameraHeight("1.5,0.1").sigma, 0.1);
  for (const char* text : {"", "tall", "0", "11", "1.5,", "1.5,0", "1.5,2", "nan"})
    EXPECT_NE(Complaint([&] { ParseCameraHeight(text); }), "") << text;
  EXPECT_EQ(ParseCameraHeight("1.5,0.3").sigma, 0.3);
  EXPECT_EQ(Complaint([] { ParseCameraHeight("2,1"); }),
            "--camera-height 2,1: means 2 m with a standard deviation of 1 m, which is above 20 %; measure the height, "
            "and write decimals with a point");
}

}  // namespace
}  // namespace turnscale
