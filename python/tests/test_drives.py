# SPDX-License-Identifier: MIT
"""Drives: the same bits as the program's files, whole and frame by frame (evaluate: nine digits)."""
import json
import time
import unittest

import numpy as np

import support
import turnscale

try:
    import pandas
except ImportError:
    pandas = None


def feed(odometry, frames):
    results = []
    # All images come in the same memory, rows apart.
    memory = None
    for frame in frames:
        if frame.image is None:
            results.append(odometry.process(None, frame.time))
            continue
        height, width = frame.image.shape
        if memory is None:
            memory = np.full((height + 3, width + 70), 77, dtype=np.uint8)
        view = memory[2:2 + height, 31:31 + width]
        view[:] = frame.image
        results.append(odometry.process(view, frame.time))
        view[:] = 0
    return results


class RenderedDrive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.drive = support.rendered_drive()
        cls.folder = support.run_of_program(cls.drive, "--lever-arm", 1.5)
        cls.results = turnscale.run(cls.drive, lever_arm=1.5)

    def test_tables_are_those_of_the_files(self):
        support.compare_with_folder(self, self.results, self.folder)
        self.assertGreater(len(self.results.turns), 0)

    def test_files_are_those_of_the_program(self):
        out = support.scratch() / "from python"
        begin = time.perf_counter()
        drive = turnscale.run(self.drive, lever_arm=1.5, out=out, no_report=True)
        self.assertLess(drive.summary["cost"]["wall_s"], time.perf_counter() - begin, "without the earlier runs")
        names = sorted(path.name for path in self.folder.iterdir())
        self.assertEqual(sorted(path.name for path in out.iterdir()), names)
        for name in set(names) - {"summary.json"}:
            self.assertEqual((out / name).read_bytes(), (self.folder / name).read_bytes(), name)

    def test_results_are_read_back(self):
        support.compare_with_folder(self, turnscale.read(self.folder), self.folder)

    def test_frame_by_frame_gives_the_same_bits(self):
        # Frame by frame, images are processed as they are.
        settings = support.scratch() / "unscaled.yaml"
        settings.write_text("images: {max_width: 0, min_width: 0}\n")
        folder = support.run_of_program(self.drive, "--lever-arm", 1.5, "--settings", settings)
        whole = turnscale.run(self.drive, lever_arm=1.5, settings=settings)
        frames = turnscale.Frames(self.drive)
        odometry = turnscale.Odometry(frames.camera, lever_arm=1.5)
        live = feed(odometry, frames)
        results = odometry.finish()
        support.compare_with_folder(self, results, folder)
        np.testing.assert_array_equal(results.landmarks, whole.landmarks)
        self.assertEqual(len(live), odometry.frames)
        self.assertFalse(live[0].metric)
        self.assertEqual(live[0].sigma, np.inf)
        self.assertTrue(np.isnan(live[0].scale))
        self.assertTrue(live[-1].metric)
        self.assertGreater(live[-1].scale, 0)
        self.assertLess(live[-1].sigma, 0.15)
        self.assertEqual(live[-1].pose.shape, (4, 4))
        np.testing.assert_allclose(live[-1].pose[:3, :3] @ live[-1].pose[:3, :3].T, np.eye(3), atol=1e-12)
        last = results.live[-1]
        np.testing.assert_allclose(live[-1].pose[:3, 3], [last["x"], last["y"], last["z"]], rtol=1e-8)
        for name in ("scale", "path", "vehicle", "warnings"):
            self.assertEqual(results.summary.get(name), whole.summary.get(name), name)

    def test_frame_by_frame_warns_as_a_run_does(self):
        frames = turnscale.Frames(self.drive)
        camera = frames.camera
        wrong = turnscale.Camera(1.3 * camera.fx, 1.3 * camera.fy, camera.cx, camera.cy)
        odometry = turnscale.Odometry(wrong, lever_arm=1.5)
        feed(odometry, frames)
        with self.assertWarnsRegex(UserWarning, "focal length"):
            results = odometry.finish()
        self.assertTrue(any("focal length" in warning for warning in results.summary["warnings"]))

    def test_times_that_are_no_seconds_are_refused(self):
        frames = turnscale.Frames(self.drive)
        odometry = turnscale.Odometry(frames.camera)
        with self.assertRaisesRegex(ValueError, "Give seconds"):
            for frame in frames:
                odometry.process(frame.image, 1e9 * frame.time)

    def test_a_drive_is_shown_on_one_line(self):
        summary = self.results.summary
        self.assertEqual(repr(self.results),
                         f"<Drive: {len(self.results.trajectory)} frames, {summary['distance_m']:.2f} m "
                         f"+-{100 * summary['path_sigma']:.1f} %, scale known>")
        self.assertRegex(repr(turnscale.run(self.drive, max_frames=40)),
                         r"^<Drive: 40 frames, \d+\.\d\d units, scale pending>$")

    def test_poses_are_matrices(self):
        poses = self.results.poses
        placed = ~np.isnan(self.results.trajectory["x"])
        self.assertEqual(poses.shape, (len(placed), 4, 4))
        np.testing.assert_allclose(np.linalg.det(poses[placed, :3, :3]), 1)
        kitti = np.loadtxt(self.folder / "trajectory.kitti.txt").reshape(-1, 3, 4)
        np.testing.assert_allclose(poses[placed, :3], kitti, atol=2e-7)

    def test_options_of_every_kind_reach_the_run(self):
        # Twice, as text and as values.
        arguments = ["--lever-arm", "1.4", "--lever-arm-sigma", "0.02", "--camera-height", "1.5,0.1", "--side-slip", "0.003",
                     "--side-slip-sigma", "0.001", "--camera-rotation", "0.5,-1,0.25", "--method", "turns", "--frame",
                     "vehicle", "--threads", "1", "--start", "0:01", "--end", "11.5", "--max-frames", "95"]
        folder = support.run_of_program(self.drive, *arguments)
        drive = turnscale.run(self.drive, lever_arm=1.4, lever_arm_sigma=0.02, camera_height=(1.5, 0.1), side_slip=0.003,
                              side_slip_sigma=0.001, camera_rotation=[0.5, -1, 0.25], method="turns", frame="vehicle",
                              threads=1, start="0:01", end=11.5, max_frames=95)
        support.compare_with_folder(self, drive, folder)
        self.assertEqual(drive.summary["frames"]["total"], 95)

    def test_a_camera_is_a_file_or_an_object(self):
        camera = turnscale.Frames(self.drive).camera
        file = self.drive / "camera.yaml"
        folder = support.run_of_program(self.drive, "--camera", file, "--max-frames", 60)
        of_file = turnscale.run(self.drive, camera=file, max_frames=60)
        of_object = turnscale.run(self.drive, camera=camera, max_frames=60)
        for drive in (of_file, of_object):
            support.compare_with_folder(self, drive, folder)
        self.assertEqual(of_file.summary["camera"], str(file))
        self.assertEqual(of_object.summary["camera"], "turnscale.Camera")
        self.assertEqual(turnscale.Frames(self.drive, camera=camera).camera, camera)
        for given, name in ((file, str(file)), (camera, "turnscale.Camera")):
            self.assertEqual(turnscale.Odometry(given).results().summary["camera"], name)
        with self.assertRaisesRegex(ValueError, "^--camera: excludes --fov"):
            turnscale.run(self.drive, camera=camera, fov=70)

    def test_images_are_rotated(self):
        folder = support.run_of_program(self.drive, "--rotate", "180", "--max-frames", 60)
        support.compare_with_folder(self, turnscale.run(self.drive, rotate=180, max_frames=60), folder)
        plain, rotated = (next(turnscale.Frames(self.drive, rotate=degrees)).image for degrees in (0, 180))
        np.testing.assert_array_equal(rotated, plain[::-1, ::-1])

    def test_settings_are_a_file_or_a_mapping(self):
        file = support.scratch() / "settings.yaml"
        file.write_text("corners: {target: 300}\nlens: {enabled: false}\n")
        folder = support.run_of_program(self.drive, "--settings", file, "--max-frames", 60)
        for settings in (file, {"corners": {"target": 300}, "lens": {"enabled": False}}):
            support.compare_with_folder(self, turnscale.run(self.drive, settings=settings, max_frames=60), folder)
        with self.assertRaisesRegex(ValueError, r"^settings:\d+: corners.targets: "):
            turnscale.Odometry(turnscale.Camera(190, 190, 159.5, 119.5), settings={"corners": {"targets": 300}})

    def test_a_mask_is_a_file_or_an_array(self):
        frames = list(turnscale.Frames(self.drive, max_frames=40))
        camera = turnscale.Frames(self.drive).camera
        mask = np.full(frames[0].image.shape, 255, dtype=np.uint8)
        mask[180:] = 0
        masked = turnscale.Odometry(camera, mask=mask)
        plain = turnscale.Odometry(camera)
        for odometry in (masked, plain):
            feed(odometry, frames)
        self.assertNotEqual(masked.results().trajectory["tracked"].tolist(), plain.results().trajectory["tracked"].tolist())
        with self.assertRaisesRegex(ValueError, "^mask: is 10x10, the images are 320x240"):
            turnscale.Odometry(camera, mask=np.ones((10, 10), dtype=np.uint8)).process(frames[0].image, 0.0)

    @unittest.skipIf(pandas is None, "no pandas")
    def test_tables_become_data_frames(self):
        frame = pandas.DataFrame(self.results.trajectory)
        self.assertEqual(list(frame.columns), list(self.results.trajectory.dtype.names))
        self.assertEqual(frame["state"].iloc[-1], "tracked")
        self.assertEqual(frame["keyframe"].dtype, bool)
        file = pandas.read_csv(self.folder / "trajectory.csv", float_precision="round_trip")
        np.testing.assert_array_equal(frame["x"], file["x"])

    def test_evaluate_says_what_the_program_says(self):
        said, code, text = support.program("evaluate", self.folder / "trajectory.tum", self.drive / "poses.txt", "--json", "-")
        self.assertEqual(code, 0, said)
        file = support.scratch() / "errors.json"
        errors = turnscale.evaluate(self.folder / "trajectory.tum", self.drive / "poses.txt", json=file)
        # Not to the bit: where another compiler made the package, the sums of the alignment are rounded differently.
        support.compare_numbers(self, json.loads(file.read_text()), json.loads(text))
        self.assertGreater(errors["poses"]["paired"], 100)

    def test_calibrate_writes_what_the_program_writes(self):
        yaml = support.scratch() / "calibration.yaml"
        history = support.scratch() / "history.csv"
        said, code, _ = support.program("calibrate", self.drive, "--lever-arm", 1.5, "--history", history, "--out", yaml)
        if code != 0:
            with self.assertRaises(ValueError) as raised:
                turnscale.calibrate(self.drive, lever_arm=1.5)
            self.assertEqual(f"turnscale: {raised.exception}", said.splitlines()[-1])
            return
        found = turnscale.calibrate(self.drive, lever_arm=1.5)
        self.assertEqual(found.yaml, yaml.read_text())
        self.assertEqual(found.lever_arm, 1.5)
        self.assertIsNone(found.lever_arm_sigma)
        self.assertRegex(repr(found), rf"^<Calibration: {found.frames} frames, yaw [^\n]* deg, lever arm 1\.500 m>$")
        support.compare_with_csv(self, found.history, history)
        # The same from the trajectory.
        up_to_scale = turnscale.calibrate(trajectory=self.folder / "trajectory.tum", axes="camera")
        self.assertIsNone(up_to_scale.lever_arm)
        self.assertAlmostEqual(up_to_scale.yaw_deg, found.yaw_deg, delta=2)

    def test_rescale_writes_what_the_program_writes(self):
        out = support.scratch() / "metric.tum"
        report = support.scratch() / "rescaled"
        path = support.run_of_program(self.drive) / "trajectory.tum"
        said, code, _ = support.program("rescale", path, "--lever-arm", 1.5, "--out", out, "--report", report)
        self.assertEqual(code, 0, said)
        rescaled = turnscale.rescale(path, lever_arm=1.5)
        support.compare_with_tum(self, rescaled.trajectory, out)
        support.compare_with_csv(self, rescaled.scale, report / "scale.csv")
        support.compare_with_csv(self, rescaled.turns, report / "turns.csv")
        self.assertEqual(rescaled.summary, json.loads((report / "summary.json").read_text()))
        self.assertGreater(rescaled.summary["length_m"], 10)
        self.assertRegex(repr(rescaled), r"^<Rescaled: \d+ poses, \d+\.\d\d m \+-\d+\.\d %>$")

    def test_rescale_takes_heights(self):
        out, heights = support.scratch() / "metric.tum", support.scratch() / "heights.csv"
        path = support.run_of_program(self.drive) / "trajectory.tum"
        times = [line.split()[0] for line in path.read_text().splitlines()]
        heights.write_text("time,height\n" + "".join(f"{time},2.8\n" for time in times))
        said, code, _ = support.program("rescale", path, "--heights", heights, "--camera-height", "1.4,0.02", "--out", out)
        self.assertEqual(code, 0, said)
        rescaled = turnscale.rescale(path, heights=heights, camera_height=(1.4, 0.02))
        support.compare_with_tum(self, rescaled.trajectory, out)
        self.assertAlmostEqual(rescaled.scale["metres_per_unit"][-1], 0.5, delta=0.01)
        self.assertAlmostEqual(rescaled.summary["camera_height_m"], 1.4, delta=0.02)


class Kitti(unittest.TestCase):
    """Recorded images."""

    @classmethod
    def setUpClass(cls):
        cls.drive = support.kitti_drive()
        cls.folder = support.run_of_program(cls.drive, "--lever-arm", 0.945, "--side-slip", 0.0041)

    def test_a_run_gives_the_bits_of_the_program(self):
        support.compare_with_folder(self, turnscale.run(self.drive, **support.KITTI_CAR), self.folder)

    def test_frame_by_frame_gives_the_bits_of_the_program(self):
        odometry = turnscale.Odometry(self.drive / "calib.txt", threads=1, **support.KITTI_CAR)
        feed(odometry, turnscale.Frames(self.drive))
        support.compare_with_folder(self, odometry.finish(), self.folder)


if __name__ == "__main__":
    unittest.main()
