# SPDX-License-Identifier: MIT
"""Manifests, good and bad."""
import pathlib
import tempfile
import unittest

from turnscale_batch.errors import InputError
from turnscale_batch.manifest import COLUMNS, read_manifest


class Manifest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        (self.folder / "cam.yaml").touch()

    def read(self, text, encoding="utf-8"):
        path = self.folder / "drives.csv"
        path.write_bytes(text.encode(encoding))
        return read_manifest(path)

    def refused(self, text):
        with self.assertRaises(InputError) as raised:
            self.read(text)
        self.assertNotIn("\n", str(raised.exception))
        return str(raised.exception)

    def test_options_are_those_of_run(self):
        drive, = self.read("drive,input,vehicle,camera,lever_arm,camera_height,camera_refine,start\n"
                           "one,a.mp4;b.mp4,golf,cam.yaml,1.45,\"1.3,0.02\",yes,1:30\n")
        self.assertEqual(drive.vehicle, "golf")
        self.assertEqual(drive.inputs, (str(self.folder / "a.mp4"), str(self.folder / "b.mp4")))
        self.assertEqual(drive.arguments()[2:], [f"--camera={self.folder / 'cam.yaml'}", "--lever-arm=1.45",
                                                 "--start=1:30", "--camera-height=1.3,0.02", "--camera-refine"])
        self.assertNotIn("--lever-arm=1.45", drive.arguments(without=["--lever-arm"]))

    def test_empty_cells_and_lines_count_as_absent(self):
        drives = self.read("drive,input,lever_arm,camera_refine\n\none,a,,no\n,,,\ntwo,b,1.2,\n")
        self.assertEqual([drive.name for drive in drives], ["one", "two"])
        self.assertEqual(drives[0].options, ())

    def test_spreadsheets_write_byte_order_marks_and_carriage_returns(self):
        drive, = self.read("\ufeffdrive,input\r\none,a\r\n")
        self.assertEqual(drive.name, "one")

    def test_unknown_column_is_named_with_the_nearest(self):
        said = self.refused("drive,input,lever_am\none,a,1\n")
        self.assertIn("drives.csv:1: column 3: unknown column 'lever_am'; did you mean 'lever_arm'?", said)

    def test_columns_of_spreadsheets_that_are_parted_by_semicolons(self):
        said = self.refused("drive;input;lever_arm\none;a;1,2\n")
        self.assertIn("drives.csv:1: the only column is 'drive;input;lever_arm'; separate columns by commas", said)

    def test_columns_that_are_missing_or_twice(self):
        self.assertIn("no column 'input'", self.refused("drive\none\n"))
        self.assertIn("column 3: 'drive' is there twice", self.refused("drive,input,drive\na,b,c\n"))

    def test_unsafe_names(self):
        for name in ("../one", "a/b", ".hidden", "-rf", "a b", "ü", "x" * 200, "table.csv", "failed", "a\tb"):
            self.assertIn("drives.csv:2: drive: ", self.refused(f"drive,input\n\"{name}\",a\n"))
        self.assertIn("is empty", self.refused("drive,input\n,a\n"))

    def test_names_given_twice(self):
        self.assertIn("drives.csv:4: drive: 'One' is in line 2 too",
                      self.refused("drive,input\none,a\ntwo,b\nOne,c\n"))

    def test_cells_that_make_no_sense(self):
        self.assertIn("drives.csv:2: lever_arm: 'long' is no number", self.refused("drive,input,lever_arm\na,b,long\n"))
        self.assertIn("lever_arm: 'nan'", self.refused("drive,input,lever_arm\na,b,nan\n"))
        self.assertIn("camera: 'no.yaml' does not exist", self.refused("drive,input,camera\na,b,no.yaml\n"))
        self.assertIn("camera_refine: 'maybe'", self.refused("drive,input,camera_refine\na,b,maybe\n"))
        self.assertIn("input: is empty", self.refused("drive,input\na, ; \n"))
        self.assertIn("has 3 cells", self.refused("drive,input\na,b,c\n"))

    def test_files_that_are_no_manifest(self):
        self.assertIn("names no drive", self.refused("drive,input\n"))
        self.assertIn("names no drive", self.refused(""))
        with self.assertRaisesRegex(InputError, "cannot be read"):
            read_manifest(self.folder / "none.csv")
        with self.assertRaisesRegex(InputError, "no text in UTF-8"):
            self.read("drive,input\nä,b\n", encoding="latin-1")
        with self.assertRaises(InputError):
            self.read("drive,input\n\"a,b\n")

    def test_a_missing_input_costs_its_drive_only(self):
        self.assertEqual(len(self.read("drive,input\na,nowhere.mp4\n")), 1)

    def test_keys_tell_rows_apart(self):
        one, same, arm, threads = self.read("drive,input,lever_arm,threads\na,x,1.2,\nb,x,1.2,\nc,x,1.3,\nd,x,1.2,4\n")
        self.assertEqual(one.key(), same.key())
        self.assertNotEqual(one.key(), arm.key())
        self.assertEqual(one.key(), threads.key(), "threads do not change the result")
        self.assertNotEqual(one.key(), one.key("car"))

    def test_the_contents_of_files_count(self):
        camera = self.folder / "camera.yaml"
        camera.write_text("fx: 700")
        key = self.read("drive,input,camera\na,x,camera.yaml\n")[0].key()
        self.assertEqual(self.read("drive,input,camera\na,x,camera.yaml\n")[0].key(), key)
        camera.write_text("fx: 701")
        self.assertNotEqual(self.read("drive,input,camera\na,x,camera.yaml\n")[0].key(), key)

    def test_every_column_is_known(self):
        self.assertEqual(len(COLUMNS), len(set(COLUMNS)))


if __name__ == "__main__":
    unittest.main()
