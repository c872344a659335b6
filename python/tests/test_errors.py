# SPDX-License-Identifier: MIT
"""What cannot be used, what fails, Ctrl-C, and other threads."""
import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
import unittest
import warnings

import numpy as np

import support
import turnscale

CAMERA = turnscale.Camera(190, 190, 159.5, 119.5)


def image(height=240, width=320, seed=0):
    return np.random.default_rng(seed).integers(0, 255, (height, width), dtype=np.uint8)


def python(script, **options):
    return subprocess.Popen([sys.executable, "-c", textwrap.dedent(script)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                            text=True, **options)


class SameLine(unittest.TestCase):
    """Errors have the line of the program, and its exit code decides their type."""

    def check(self, call, *arguments):
        said, code, _ = support.program(*arguments)
        self.assertEqual(code, 2, said)
        with self.assertRaises(ValueError) as raised:
            call()
        self.assertEqual(f"turnscale: {raised.exception}", said.splitlines()[-1])

    def test_no_drive(self):
        self.check(lambda: turnscale.run("nowhere"), "run", "nowhere")
        self.check(lambda: turnscale.run(os.fsdecode(b"now\xffhere\n")), "run", b"now\xffhere\n".decode(errors="surrogateescape"))

    def test_values_out_of_range(self):
        for name, value in (("lever_arm", -1.0), ("side_slip", 7.0), ("lever_arm_sigma", 3.0), ("threads", 0),
                            ("camera_height", "tall"), ("camera_rotation", "1,2")):
            option = "--" + name.replace("_", "-")
            self.check(lambda: turnscale.run("nowhere", **{name: value}), "run", "nowhere", f"{option}={value:g}"
                       if isinstance(value, float) else f"{option}={value}")

    def test_files(self):
        settings = support.scratch() / "bad.yaml"
        settings.write_text("corners: {target: many}\n")
        self.check(lambda: turnscale.run("nowhere", settings=settings), "run", "nowhere", "--settings", settings)
        self.check(lambda: turnscale.evaluate("a.tum", "b.tum"), "evaluate", "a.tum", "b.tum")
        self.check(lambda: turnscale.rescale("a.tum", lever_arm=1), "rescale", "a.tum", "--lever-arm", 1)
        self.check(lambda: turnscale.calibrate(), "calibrate")

    def test_a_drive_without_anything_to_track(self):
        folder = support.scratch() / "dark"
        folder.mkdir()
        for i in range(6):
            (folder / f"{i}.pgm").write_bytes(b"P5 320 240 255\n" + bytes(320 * 240))
        (folder / "camera.yaml").write_text("Camera.fx: 190\nCamera.fy: 190\nCamera.cx: 159.5\nCamera.cy: 119.5\n")
        self.check(lambda: turnscale.run(folder, fps=10), "run", folder, "--fps", 10, "--out", support.scratch() / "o",
                   "--quiet")


class Refused(unittest.TestCase):
    def refuse(self, pattern, call, *arguments, **options):
        with self.assertRaisesRegex(ValueError, pattern) as raised:
            call(*arguments, **options)
        self.assertEqual(len(str(raised.exception).splitlines()), 1)

    def test_what_the_command_line_refuses_by_itself(self):
        self.refuse("^--method best: give one of smoothed, turns, paper", turnscale.run, "nowhere", method="best")
        self.refuse("^--frame car: give one of", turnscale.run, "nowhere", frame="car")
        self.refuse("^--timestamps: excludes --fps", turnscale.run, "nowhere", fps=1, timestamps="t")
        self.refuse("^--camera: excludes --fov", turnscale.run, "nowhere", camera="c", fov=70)
        self.refuse("^--max-frames 0: ", turnscale.run, "nowhere", max_frames=0)
        self.refuse("^input: ", turnscale.run, [])
        self.refuse("^input: excludes --trajectory", turnscale.calibrate, "nowhere", trajectory="t")
        self.refuse("^--metric: needs --trajectory", turnscale.calibrate, "nowhere", metric=True)
        self.refuse("^--speed: excludes --lever-arm", turnscale.calibrate, "nowhere", speed="s", lever_arm=1)
        self.refuse("^--drift some: ", turnscale.rescale, "nowhere", lever_arm=1, drift="some")
        self.refuse("^--lever-arm: is missing", turnscale.rescale, "nowhere")
        self.refuse("^--camera-height: needs --heights", turnscale.rescale, "nowhere", camera_height=1.4)
        self.refuse("^--floor-plan: needs --picture or --report", turnscale.evaluate, "a", "b", floor_plan="p")
        self.refuse("^--truth: ", turnscale.run, "nowhere", truth="t")

    def test_images(self):
        odometry = turnscale.Odometry(CAMERA)
        refuse = lambda pattern, given: self.refuse(pattern, odometry.process, given, 1.0)
        refuse(r"^image: is float64 of shape \(240, 320\); give gray", np.zeros((240, 320)))
        refuse(r"^image: is uint8 of shape \(240, 320, 3\)", np.zeros((240, 320, 3), dtype=np.uint8))
        refuse(r"^image: is uint8 of shape \(0, 320\)", np.zeros((0, 320), dtype=np.uint8))
        for strided in (image(240, 640)[:, ::2], image(320, 240).T, image()[::-1], image()[:, ::-1],
                        np.broadcast_to(image(1, 320), (240, 320))):
            refuse("^image: has strides", strided)
        odometry.process(image(), 0.0)
        self.refuse("^image: is 100x50, the camera has 320x240", odometry.process, image(50, 100), 1.0)
        self.refuse("time", odometry.process, image(), 0.0)
        self.refuse("time", odometry.process, image(), float("nan"))
        self.assertEqual(odometry.process(None, 2.0).state, "unreadable")

    def test_an_image_may_be_read_only(self):
        fixed = image()
        fixed.flags.writeable = False
        self.assertEqual(turnscale.Odometry(CAMERA).process(fixed, 0.0).state, "initializing")

    def test_after_the_end(self):
        odometry = turnscale.Odometry(CAMERA)
        drive = odometry.finish()
        self.assertEqual(len(drive.trajectory), 0)
        self.assertEqual(drive.trajectory.dtype.names[:3], ("frame", "time", "state"))
        self.refuse("^process: the drive has been finished", odometry.process, image(), 0.0)

    def test_cameras(self):
        self.refuse("^Camera: fx and fy", turnscale.Camera, 0, 1, 2, 3)
        self.refuse("^Camera: give width and height", turnscale.Camera, 1, 1, 2, 3, width=5)
        self.refuse("^Camera: lens 'cheap'", turnscale.Camera, 1, 1, 2, 3, lens="cheap")
        self.refuse("^Camera: distortion has 6 numbers", turnscale.Camera, 1, 1, 2, 3, distortion=[0.1] * 6)
        self.refuse("nowhere.yaml", turnscale.Odometry, "nowhere.yaml")
        bent = turnscale.Camera(400, 401, 320, 240, width=640, height=480, distortion=[-0.3, 0.1])
        self.assertEqual((bent.lens, bent.distortion, bent.fy), ("radial-tangential", (-0.3, 0.1, 0, 0, 0), 401))
        self.assertEqual(eval(repr(bent), {"Camera": turnscale.Camera}), bent)
        self.assertEqual(CAMERA.lens, "pinhole")

    def test_kinds_of_values(self):
        for name, value, said in (("lever_arm", "0.945", "a number, got str '0.945'"), ("threads", 2.5, "an integer, got float 2.5"),
                                  ("camera_refine", "yes", "True or False, got str 'yes'"),
                                  ("mask", np.zeros((50, 50)), r"a path \(str or os.PathLike\), got ndarray$"),
                                  ("topic", 5, "a string, got int 5")):
            with self.assertRaisesRegex(TypeError, f"^{name}: expected {said}"):
                turnscale.run("nowhere", **{name: value})
        with self.assertRaises(TypeError):
            turnscale.run("nowhere", leverarm=1)
        with self.assertRaises(TypeError):
            turnscale.Odometry(CAMERA, out="nowhere")
        # Those of numpy are as good as Python's.
        self.refuse("nowhere", turnscale.run, "nowhere", lever_arm=np.float32(1.5), threads=np.int64(2),
                    camera_rotation=np.array([1.0, 2.0, 3.0]), camera_height=np.float64(1.2))

    def test_no_results(self):
        self.refuse("holds no results", turnscale.read, support.scratch() / "nothing here")


class Failures(unittest.TestCase):
    def test_a_full_disk_is_a_runtime_error(self):
        drive = support.rendered_drive()
        out = support.scratch() / "full"
        script = f"""
            import resource, turnscale
            resource.setrlimit(resource.RLIMIT_FSIZE, (9000, 9000))
            try:
                turnscale.run({str(drive)!r}, max_frames=80, out={str(out)!r}, no_report=True)
            except RuntimeError as error:
                print(error)
        """
        said, trouble = python(script).communicate()
        self.assertRegex(said, r"(?i)^.*full/.*too large.*; the results so far are in .*full\n$", trouble)

    def test_ctrl_c_keeps_the_results_so_far(self):
        drive = support.rendered_drive()
        out = support.scratch() / "interrupted"
        script = f"""
            import turnscale
            try:
                turnscale.run({str(drive)!r}, lever_arm=1.5, out={str(out)!r})
            except KeyboardInterrupt:
                print("interrupted", turnscale.read({str(out)!r}).summary["stopped"])
        """
        process = python(script)
        for _ in range(600):
            part = out / "live.tum.part"
            if part.exists() and part.stat().st_size > 0:
                break
            time.sleep(0.05)
        process.send_signal(signal.SIGINT)
        said, trouble = process.communicate()
        self.assertRegex(said, r"^interrupted interrupted after \d+ frames\n$", trouble)

    def test_warnings_are_those_of_python(self):
        path = support.scratch() / "kitti.txt"
        lines = []
        for i in range(40):
            angle = 0.05 * min(max(i - 10, 0), 20)
            c, s = np.cos(angle), np.sin(angle)
            lines.append(f"{c} 0 {s} {np.sin(angle) * i} 0 1 0 0 {-s} 0 {c} {i * np.cos(angle)}\n")
        path.write_text("".join(lines))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            try:
                turnscale.rescale(path, lever_arm=1.0)
            except ValueError:
                pass
        self.assertIn("no timestamps", str(caught[0].message))
        self.assertEqual(caught[0].category, UserWarning)
        self.assertEqual(caught[0].filename, __file__)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with self.assertRaisesRegex(UserWarning, "no timestamps"):
                turnscale.rescale(path, lever_arm=1.0)


class Threads(unittest.TestCase):
    def test_other_threads_go_on(self):
        drive = support.rendered_drive()
        done = threading.Event()

        def work():
            turnscale.run(drive, lever_arm=1.5)
            done.set()

        thread = threading.Thread(target=work)
        thread.start()
        ticks = 0
        longest = 0.0
        while not done.is_set():
            before = time.monotonic()
            time.sleep(0.001)
            longest = max(longest, time.monotonic() - before)
            ticks += 1
        thread.join()
        self.assertGreater(ticks, 100)

    def test_calls_of_two_threads_come_one_after_the_other(self):
        odometry = turnscale.Odometry(CAMERA)
        clock = iter(range(1000))
        turn = threading.Lock()
        failures = []

        def work():
            try:
                for i in range(20):
                    with turn:
                        moment = float(next(clock))
                        thread = threading.Thread(target=odometry.results)
                        thread.start()
                        odometry.process(image(seed=i), moment)
                    thread.join()
            except Exception as error:  # noqa: BLE001
                failures.append(error)

        threads = [threading.Thread(target=work) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])
        self.assertEqual(odometry.frames, 40)


if __name__ == "__main__":
    unittest.main()
