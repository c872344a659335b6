// SPDX-License-Identifier: MIT
#include "common_options.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "turnscale/commands/drive_camera.h"
#include "turnscale/kinematics/ackermann.h"

namespace turnscale {

void AddCameraOptions(CLI::App& command, ImageArguments& arguments) {
  CLI::Option* camera = command.add_option(
      "--camera", arguments.camera,
      "Intrinsics: KITTI calib.txt, OpenCV, ORB-SLAM or Kalibr YAML [calib.txt or camera.yaml in the "
      "input folder; else estimated from the turns of the drive]");
  command
      .add_option(
          "--fov", arguments.field_of_view,
          fmt::format("Estimate the intrinsics, starting from this horizontal field of view, degrees [{}; if the "
                      "images are higher than wide, {} vertically]",
                      kUsualView, kUsualView))
      ->excludes(camera);
  command.add_flag("--camera-refine", arguments.refine_camera,
                   "Estimate the intrinsics, starting from the given ones, and use the estimate");
}

void AddPartOptions(CLI::App& command, ImageArguments& arguments) {
  command.add_option("--topic", arguments.topic,
                     "Topic of a bag's images, such as /camera/image_raw [the bag's only topic of images]");
  command.add_option(
      "--start", arguments.start,
      "Time since the first frame of the drive (HH:MM:SS, MM:SS or seconds) at which processing starts; the times "
      "in the results remain those of the whole drive");
  command.add_option("--end", arguments.end, "Time since the first frame of the drive at which processing ends");
  command.add_option("--rotate", arguments.rotate,
                     "Rotate the images clockwise by 90, 180 or 270 degrees, as those of a camera that hangs upside "
                     "down; --camera and --mask are of the rotated images [0]");
  command.add_option("--mask", arguments.mask,
                     "Image of the frames' size: black pixels (0) are left out of all frames, in addition to those "
                     "that are found to stand still while the scene moves");
}

void AddSideSlipOptions(CLI::App& command, std::optional<double>& side_slip, std::optional<double>& sigma) {
  command.add_option(
      "--side-slip", side_slip,
      fmt::format("Side slip of the rear axle: its slip angle per lateral acceleration, rad per m/s^2 (= s^2/m); c in "
                  "L_eff = L - c v^2. Refined from the drive unless its sigma is 0 [{}]",
                  kUsualSideSlip));
  command.add_option(
      "--side-slip-sigma", sigma,
      fmt::format(
          "Standard deviation of the side slip, s^2/m; 0: it is not refined [{}; with --side-slip above 0, {:.0f} "
          "% of it]",
          kUsualSideSlipSigma, 100 * kGivenSideSlipSigma));
}

void AddTruthOptions(CLI::App& command, TruthFiles& files) {
  CLI::Option* truth = command.add_option("--truth", files.truth,
                                          "Ground truth (TUM, EuRoC or KITTI file), shown with the errors in the page");
  command
      .add_option("--floor-plan", files.floor_plan,
                  "floor_plan.csv of a simulated drive, drawn under the path in the page")
      ->needs(truth);
}

void DeclareRules(const OptionRules& rules, CLI::App& command) {
  for (const auto& [one, other] : rules.exclusive) command.get_option(one)->excludes(command.get_option(other));
  for (const auto& [one, other] : rules.needs) command.get_option(one)->needs(command.get_option(other));
}

}  // namespace turnscale
