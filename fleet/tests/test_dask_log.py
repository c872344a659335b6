# SPDX-License-Identifier: MIT
"""Messages of the batch and what Dask prints go different ways."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

PRINTS = """
import os, sys
from turnscale_batch.dask_log import stderr_in_file
with stderr_in_file(sys.argv[1]) as messages:
    print("noise", file=sys.stderr)
    os.system("echo of a child >&2")
    print("message", file=messages)
print("end", file=sys.stderr)
"""
SILENT = """
import sys
from turnscale_batch.dask_log import stderr_in_file
with stderr_in_file(sys.argv[1]):
    pass
"""


class DaskLog(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.log = pathlib.Path(folder.name) / "dask.log"

    @staticmethod
    def printed(code, log):
        return subprocess.run([sys.executable, "-c", code, log], capture_output=True, text=True, check=True,
                              cwd=pathlib.Path(__file__).resolve().parent.parent).stderr

    def test_holds_what_this_process_and_its_children_print(self):
        self.log.write_text("of an earlier call\n")
        self.assertEqual(self.printed(PRINTS, self.log), "message\nend\n")
        self.assertEqual(self.log.read_text(), "noise\nof a child\n")

    def test_that_is_empty_goes(self):
        self.printed(SILENT, self.log)
        self.assertFalse(self.log.exists())

    def test_that_cannot_be_written_is_given_up(self):
        self.assertEqual(self.printed(PRINTS, self.log / "none"), "message\nend\n")


if __name__ == "__main__":
    unittest.main()
