# SPDX-License-Identifier: MIT
"""The progress and its estimate of the end."""
import io
import unittest

from turnscale_batch.progress import Progress, spoken


class Terminal(io.StringIO):
    def isatty(self):
        return True


def record(wall, exit_code=0, error=""):
    return {"drive": "one", "wall_s": wall, "exit_code": exit_code, "error": error}


class ProgressTest(unittest.TestCase):
    def test_estimates_the_end_from_the_mean_run(self):
        progress = Progress(10, 2, False, io.StringIO())
        self.assertIsNone(progress.remaining())
        progress.add(record(60))
        progress.add(record(120))
        self.assertAlmostEqual(progress.remaining(), 8 * 90 / 2)
        self.assertIn("2 of 10 runs, about 6 min left", progress.text())

    def test_bar_on_a_terminal(self):
        stream = Terminal()
        Progress(2, 1, False, stream).add(record(1))
        self.assertIn("[############............] 1 of 2 runs", stream.getvalue())

    def test_plain_lines_otherwise(self):
        stream, now = io.StringIO(), [0.0]
        progress = Progress(3, 1, False, stream, lambda: now[0])
        progress.add(record(1))
        self.assertEqual(stream.getvalue(), "")
        now[0] = 31
        progress.add(record(1))
        self.assertEqual(stream.getvalue().count("\n"), 1)

    def test_failures_are_told_at_once_and_cannot_write_to_the_terminal(self):
        stream = io.StringIO()
        Progress(3, 1, True, stream).add(record(1, 2, "bad\x1b[31m file"))
        self.assertEqual(stream.getvalue(), "turnscale: one: bad\\x1b[31m file\n")

    def test_times_in_words(self):
        self.assertEqual([spoken(s) for s in (5, 61, 7199, 7260)], ["5 s", "1 min", "119 min", "2 h 01 min"])


if __name__ == "__main__":
    unittest.main()
