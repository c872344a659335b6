# SPDX-License-Identifier: MIT
"""The program and the drives that the tests of the package share."""
import atexit
import csv
import functools
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(os.environ.get("TURNSCALE_COMMAND", ROOT / "build/release/apps/turnscale/turnscale"))
DATA = pathlib.Path(os.environ.get("TURNSCALE_DATA", ROOT / "../shared/data"))
# Of the car of KITTI 05.
KITTI_CAR = {"lever_arm": 0.945, "side_slip": 0.0041}


@functools.lru_cache(maxsize=None)
def scratch():
    folder = tempfile.mkdtemp(prefix="turnscale_python_")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return pathlib.Path(folder)


def program(*arguments):
    """What the program prints on standard error, its exit code, and standard output."""
    if not PROGRAM.exists():
        raise unittest.SkipTest(f"no program at {PROGRAM} (TURNSCALE_COMMAND names another)")
    result = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, errors="surrogateescape")
    return result.stderr, result.returncode, result.stdout


@functools.lru_cache(maxsize=None)
def rendered_drive():
    """Sixteen seconds in a garage: parking, then a turn."""
    folder = scratch() / "drive"
    rig = scratch() / "rig.yaml"
    rig.write_text("preset: paper\ncamera: {width: 320, height: 240, fx: 190, fy: 190, cx: 159.5, cy: 119.5}\n")
    said, code, _ = program("simulate", "garage", "--seed", 1, "--seconds", 20, "--max-frames", 160, "--rig", rig,
                            "--out", folder, "--quiet")
    if "has no" in said:
        raise unittest.SkipTest("the program was built without the simulation")
    assert code == 0, said
    return folder


def kitti_drive():
    folder = DATA / "kitti_05_f100-159"
    if not (folder / "calib.txt").exists():
        raise unittest.SkipTest(f"no drive in {folder} (TURNSCALE_DATA names another)")
    return folder


@functools.lru_cache(maxsize=None)
def run_of_program(drive, *options):
    """The folder with the program's results."""
    folder = pathlib.Path(tempfile.mkdtemp(dir=scratch()))
    said, code, _ = program("run", drive, "--out", folder, "--quiet", "--no-report", *options)
    assert code == 0, said
    return folder


def rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def compare_with_csv(test, table, path):
    """Holds a table against a CSV file: the same columns, and the same bits in every cell."""
    with open(path, newline="", encoding="utf-8") as file:
        header, *lines = csv.reader(file)
    test.assertEqual(list(table.dtype.names), header)
    test.assertEqual(len(table), len(lines))
    test.assertGreater(len(lines), 0)
    for name, cells in zip(header, zip(*lines)):
        for value, cell in zip(table[name].tolist(), cells):
            if isinstance(value, str):
                test.assertEqual(value, cell)
            elif cell == "":
                test.assertTrue(value != value, f"{path.name}: {name}")
            elif isinstance(value, bool):
                test.assertEqual(value, cell == "1")
            else:
                test.assertEqual(value.hex() if isinstance(value, float) else value,
                                 float(cell).hex() if isinstance(value, float) else int(cell))


def compare_with_tum(test, table, path):
    lines = [tuple(map(float, line.split())) for line in path.read_text().splitlines()]
    test.assertGreater(len(lines), 0)
    test.assertEqual([tuple(row) for row in table.tolist()], lines)


def compare_numbers(test, found, expected):
    """Holds what is read from JSON against the same, numbers to nine digits or 1e-12."""
    test.assertIs(type(found), type(expected))
    if isinstance(expected, dict):
        test.assertEqual(list(found), list(expected))
        for key, value in expected.items():
            with test.subTest(key=key):
                compare_numbers(test, found[key], value)
    elif isinstance(expected, list):
        test.assertEqual(len(found), len(expected))
        for one, other in zip(found, expected):
            compare_numbers(test, one, other)
    elif isinstance(expected, float):
        test.assertAlmostEqual(found, expected, delta=max(1e-9 * abs(expected), 1e-12))
    else:
        test.assertEqual(found, expected)


TABLES = ("trajectory", "turns", "speed", "scale", "camera_rotation")


def compare_with_folder(test, drive, folder):
    for name in TABLES:
        with test.subTest(table=name):
            if (folder / f"{name}.csv").exists() and len(rows(folder / f"{name}.csv")) > 0:
                compare_with_csv(test, getattr(drive, name), folder / f"{name}.csv")
            else:
                test.assertEqual(len(getattr(drive, name)), 0)
    compare_with_tum(test, drive.live, folder / "live.tum")
