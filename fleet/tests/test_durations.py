# SPDX-License-Identifier: MIT
"""How long runs are expected to take."""
import os
import pathlib
import tempfile
import unittest

from turnscale_batch.durations import Durations, frames
from turnscale_batch.manifest import Drive


def record(drive, seconds, exit_code=0):
    return {"drive": drive, "wall_s": seconds, "exit_code": exit_code}


class DurationsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def drive(self, name, images):
        folder = self.folder / name / "image_0"
        folder.mkdir(parents=True)
        for i in range(images):
            (folder / f"{i}.png").touch()
        return Drive(name, (str(self.folder / name),))

    def video(self, name, size):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "wb") as file:
            file.truncate(size)
        return str(path)

    def test_images_of_all_kinds_count_as_frames(self):
        # Those of frames/drive_input.cpp.
        for extension in ("png", "jpg", "jpeg", "bmp", "pgm", "ppm", "pnm", "tif", "tiff", "PNG"):
            self.assertEqual(frames(self.video(f"images.{extension}/0.{extension}", 3_000_000)), 1, extension)

    def test_longer_inputs_have_more_frames(self):
        short, long = self.video("short.mp4", 3_000_000), self.video("long.mp4", 30_000_000)
        self.assertAlmostEqual(frames(long), 10 * frames(short))
        self.video("card/DCIM/100/clip.mp4", 3_000_000)
        self.assertEqual(frames(str(self.folder / "card")), frames(short))
        self.assertEqual(frames(self.drive("images", 40).inputs[0]), 40)

    def test_of_inputs_that_cannot_be_seen(self):
        os.mkfifo(self.folder / "pipe.mp4")
        (self.folder / "empty").mkdir()
        drives = [Drive(name, (str(self.folder / name),)) for name in ("pipe.mp4", "empty", "missing")]
        durations = Durations(drives)
        self.assertEqual([durations.seen(drive.name) for drive in drives], [False] * 3)
        durations.learn(record("pipe.mp4", 100, -9))
        self.assertTrue(durations.seen("pipe.mp4"))
        self.assertEqual(durations.seconds("pipe.mp4"), 100)

    def test_are_learnt_from_runs(self):
        durations = Durations([self.drive("one", 10), self.drive("two", 20)])
        self.assertLess(durations.seconds("one"), durations.seconds("two"))
        self.assertFalse(durations.known())
        durations.learn(record("one", 5))
        self.assertTrue(durations.known())
        self.assertEqual((durations.seconds("one"), durations.seconds("two")), (5, 10))

    def test_of_a_drive_that_failed_early(self):
        durations = Durations([self.drive("one", 10), self.drive("two", 20)])
        durations.seconds("one")
        durations.learn(record("one", 5))
        durations.learn(record("two", 0.1, 1))
        self.assertEqual(durations.seconds("two"), 10)

    def test_end_at_the_timeout(self):
        durations = Durations([self.drive("one", 10)], timeout=3)
        durations.learn(record("one", 5))
        self.assertEqual(durations.seconds("one"), 3)


if __name__ == "__main__":
    unittest.main()
