# SPDX-License-Identifier: MIT
"""The progress and its estimate of the end."""
import io
import unittest

from turnscale_batch.progress import Progress, spoken


class Terminal(io.StringIO):
    def isatty(self):
        return True


def record(exit_code=0, error=""):
    return {"drive": "one", "exit_code": exit_code, "error": error}


class ProgressTest(unittest.TestCase):
    def test_end_is_told_once_it_is_known(self):
        progress = Progress(10, False, io.StringIO())
        self.assertEqual(progress.text(), "0 of 10 runs, end not known yet")
        progress.add(record())
        progress.expect(9, 360)
        self.assertEqual(progress.text(), "1 of 10 runs, about 6 min left")
        progress.expect(0, 0)
        self.assertEqual(progress.text(), "1 of 1 runs")

    def test_bar_on_a_terminal(self):
        stream = Terminal()
        progress = Progress(2, False, stream)
        progress.add(record())
        progress.expect(1, 5)
        progress.show()
        self.assertIn("[############............] 1 of 2 runs, about 5 s left", stream.getvalue())

    def test_plain_lines_otherwise(self):
        stream, now = io.StringIO(), [0.0]
        progress = Progress(3, False, stream, lambda: now[0])
        progress.show()
        self.assertEqual(stream.getvalue(), "")
        now[0] = 31
        progress.show()
        self.assertEqual(stream.getvalue().count("\n"), 1)

    def test_failures_are_told_at_once_and_cannot_write_to_the_terminal(self):
        stream = io.StringIO()
        Progress(3, True, stream).add(record(2, "bad\x1b[31m file"))
        self.assertEqual(stream.getvalue(), "turnscale: one: bad\\x1b[31m file\n")

    def test_times_in_words(self):
        self.assertEqual([spoken(s) for s in (5, 61, 7199, 7260)], ["5 s", "1 min", "119 min", "2 h 01 min"])


if __name__ == "__main__":
    unittest.main()
