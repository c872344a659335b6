# SPDX-License-Identifier: MIT
"""Whole batches of a program that only pretends, on real Dask clusters: every drive is right or listed, none twice."""
import contextlib
import csv
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from turnscale_batch.attempt import run_task
from turnscale_batch.batch import Batch, BatchOptions
from turnscale_batch.manifest import read_manifest
from turnscale_batch.store import Store

HERE = pathlib.Path(__file__).resolve().parent
BATCH = [sys.executable, str(HERE.parent / "turnscale_batch")]
FAKE = str(HERE / "fake_turnscale.py")
PATIENCE = 60  # seconds


def wait_until(condition):
    begin = time.monotonic()
    while not condition():
        if time.monotonic() - begin > PATIENCE:
            raise AssertionError("waited in vain")
        time.sleep(0.05)


def children(pid):
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if int((folder / "stat").read_text().rsplit(")", 1)[1].split()[1]) == pid:
                found.append(int(folder.name))
    return found


def processes_with(word):
    """Processes that run with this in their command lines."""
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if word.encode() in (folder / "cmdline").read_bytes():
                found.append(int(folder.name))
    return found


class Batches(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"

    def manifest(self, inputs, more="", **cells):
        """Each drive has its input's name."""
        columns = ["drive", "input", *cells]
        lines = [",".join(columns)] + [",".join([name, name, *cells.values()]) for name in inputs]
        (self.folder / "drives.csv").write_text("\n".join(lines) + "\n" + more)

    def command(self, *more):
        return [*BATCH, str(self.folder / "drives.csv"), "--out", str(self.out), "--workers", "2", "--program", FAKE,
                *more]

    def batch(self, *more, code=0):
        result = subprocess.run(self.command(*more), capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(result.returncode, code, result.stderr)
        self.assertNotIn("Traceback", result.stderr)
        return result.stderr

    def table(self):
        with open(self.out / "table.csv", encoding="utf-8", newline="") as file:
            return {row["drive"]: row for row in csv.DictReader(file)}

    def starts(self, name):
        return len(list((self.folder / "starts").glob(f"{name}-*")))

    def assert_whole(self, names):
        for name in names:
            self.assertEqual((self.out / name / "trajectory.tum").read_text(), f"whole of {name}")
        self.assertEqual(processes_with(str(self.out)), [], "something still runs")
        self.assertEqual({path.name for path in (self.out / ".batch").iterdir()} - {"dask.log"}, {"lock"})

    def test_failures_cost_one_drive_each_and_are_listed(self):
        good = ["sleep-0.1-a", "sleep-0-b"]
        self.manifest([good[0], "bad-1", "hang-1", "once-1", "full-1", "crash-1", good[1]])
        said = self.batch("--timeout", "2", code=1)
        table = self.table()
        self.assertEqual([row["exit_code"] for row in table.values()], ["0", "2", "-9", "0", "1", "-6", "0"])
        self.assertIn("cannot be read", table["bad-1"]["error"])
        self.assertIn("--timeout", table["hang-1"]["error"])
        self.assertIn("No space left", table["full-1"]["error"])
        self.assertIn("SIGABRT", table["crash-1"]["error"])
        self.assertEqual(table["once-1"]["attempts"], "2", "its worker was killed")
        self.assertIn("4 of 7 drives failed", said)
        self.assert_whole([*good, "once-1"])
        self.assertFalse((self.out / "bad-1").exists(), "no half results where whole ones are looked for")
        self.assertEqual((table[good[0]]["length_m"], table[good[0]]["turns_used"]), ("12.500", "1"))
        self.assertEqual((table[good[0]]["scale_known"], table["bad-1"]["scale_known"]), ("1", ""))

        # Nothing is done twice.
        self.batch(code=1)
        for name in (*good, "bad-1", "full-1"):
            self.assertEqual(self.starts(name), 1, name)
        self.batch("--redo-failed", "--timeout", "2", code=1)
        self.assertEqual(self.starts("bad-1"), 2)
        self.assertEqual(self.starts(good[0]), 1)

    def test_long_drives_begin_first(self):
        sizes = {"sleep-0-a": 4, "sleep-0-b": 1, "sleep-0-c": 3, "sleep-0-d": 2}
        for name, size in sizes.items():
            with open(self.folder / name, "wb") as file:
                file.truncate(size * 1_000_000)
        self.manifest([*sizes, "sleep-0-unseen"])
        self.batch("--workers", "1")
        begun = sorted((self.folder / "starts").iterdir(), key=lambda path: path.stat().st_mtime_ns)
        self.assertEqual([path.name.rpartition("-")[0].removeprefix("sleep-0-") for path in begun],
                         ["unseen", "a", "c", "d", "b"])

    def test_a_drive_that_kills_its_workers_is_given_up(self):
        self.manifest(["deadly-1", "sleep-0-a"])
        self.batch("--attempts", "2", code=1)
        self.assertIn("lost in each of 2 attempts", self.table()["deadly-1"]["error"])
        self.assertEqual(self.starts("deadly-1"), 2)
        self.assert_whole(["sleep-0-a"])

    def test_killed_workers_and_an_interruption(self):
        names = [f"sleep-0.4-{i}" for i in range(10)]
        self.manifest(names)
        with subprocess.Popen(self.command("--quiet"), stderr=subprocess.DEVNULL, start_new_session=True) as process:
            for _ in range(3):
                wait_until(lambda: any(self.is_worker(pid) for pid in children(process.pid)))
                time.sleep(0.3)
                os.kill(next(pid for pid in children(process.pid) if self.is_worker(pid)), signal.SIGKILL)
                time.sleep(0.5)
            wait_until(lambda: any((self.out / name).exists() for name in names))
            # As Ctrl-C on a terminal: to all of the group.
            os.killpg(process.pid, signal.SIGINT)
            self.assertEqual(process.wait(PATIENCE), 130)
        wait_until(lambda: not processes_with(str(self.out)))
        done = [name for name in names if (self.out / name).exists()]
        starts = {name: self.starts(name) for name in done}
        self.assertTrue(done)
        self.batch()
        self.assert_whole(names)
        self.assertEqual({name: self.starts(name) for name in done}, starts, "finished results are kept")
        self.assertEqual(set(self.table()), set(names))

    @staticmethod
    def is_worker(pid):
        with contextlib.suppress(OSError):
            return b"--multiprocessing-fork" in pathlib.Path(f"/proc/{pid}/cmdline").read_bytes()
        return False

    def test_a_batch_that_is_killed_leaves_nothing_half(self):
        self.manifest(["sleep-0-a", "sleep-30-b"])
        with subprocess.Popen(self.command("--quiet"), stderr=subprocess.DEVNULL) as process:
            wait_until(lambda: (self.out / "sleep-0-a").exists() and self.starts("sleep-30-b"))
            process.kill()
        wait_until(lambda: not processes_with(str(self.out)))
        self.manifest(["sleep-0-a", "sleep-0-c"])
        self.batch()
        self.assert_whole(["sleep-0-a", "sleep-0-c"])
        self.assertEqual(self.starts("sleep-0-a"), 1)

    def test_two_batches_at_a_time_are_refused(self):
        self.manifest(["sleep-30-a"])
        with subprocess.Popen(self.command("--quiet"), stderr=subprocess.DEVNULL) as process:
            wait_until(lambda: self.starts("sleep-30-a"))
            self.assertIn("another turnscale batch", self.batch(code=2))
            process.send_signal(signal.SIGINT)
            self.assertEqual(process.wait(PATIENCE), 130)
        wait_until(lambda: not processes_with(str(self.out)))

    def test_repeated_requests_to_end_do_not_stop_the_saving(self):
        names = ["sleep-0-a", "sleep-30-b"]
        self.manifest(names)
        with subprocess.Popen(self.command(), stderr=subprocess.PIPE, text=True) as process:
            wait_until(lambda: self.starts(names[1]) and (self.out / names[0]).exists())
            while process.poll() is None:
                process.send_signal(signal.SIGTERM)
                time.sleep(0.05)
            said = process.stderr.read()
        self.assertEqual(process.returncode, 130, said)
        self.assertIn("a second call does what is left", said)
        self.assertEqual(self.table()[names[0]]["exit_code"], "0")
        wait_until(lambda: not processes_with(str(self.out)))

    def test_a_result_whose_record_did_not_arrive_is_in_the_table(self):
        self.manifest(["sleep-0-a", "sleep-0-b"])
        store = Store(self.out)
        batch = Batch(read_manifest(self.folder / "drives.csv"), store, BatchOptions(FAKE))
        run_task(batch.first_tasks()[0])
        batch.settle()
        batch.write_table()
        rows = self.table()
        self.assertEqual((rows["sleep-0-a"]["exit_code"], rows["sleep-0-a"]["length_m"]), ("0", "12.500"))
        self.assertEqual(rows["sleep-0-b"]["error"], "not run yet")

    def test_help_needs_no_packages(self):
        for words, code in ((["--help"], 0), (["--no-such-option"], 2)):
            # Python without its packages.
            result = subprocess.run([sys.executable, "-S", *BATCH[1:], *words], capture_output=True, text=True,
                                    timeout=PATIENCE, check=False)
            self.assertEqual(result.returncode, code, result.stderr)
            self.assertIn("turnscale batch", result.stdout + result.stderr)
            self.assertNotIn("Dask;", result.stderr)

    def test_a_changed_row_is_run_again(self):
        self.manifest(["sleep-0-a", "sleep-0-b"], lever_arm="1.2")
        self.batch()
        (self.folder / "drives.csv").write_text("drive,input,lever_arm\nsleep-0-a,sleep-0-a,1.2\n"
                                                "sleep-0-b,sleep-0-b,1.3\n")
        self.batch()
        self.assertEqual((self.starts("sleep-0-a"), self.starts("sleep-0-b")), (1, 2))
        summary = json.loads((self.out / "sleep-0-b" / "summary.json").read_text())
        self.assertIn("--lever-arm=1.3", summary["arguments"])
        self.assert_whole(["sleep-0-a", "sleep-0-b"])

    def test_a_drive_that_is_renamed_with_its_folder_is_not_run_again(self):
        self.manifest(["sleep-0-a"])
        self.batch()
        (self.out / "sleep-0-a").rename(self.out / "monday")
        (self.folder / "drives.csv").write_text("drive,input\nmonday,sleep-0-a\n")
        self.batch()
        self.assertEqual(self.starts("sleep-0-a"), 1)
        self.assertEqual(self.table()["monday"]["exit_code"], "0")

    def test_drives_of_one_car_are_run_again_with_what_the_others_tell(self):
        names = ["car-0.006-a", "car-0.0062-b", "car-0.0058-c", "sleep-0-tells-nothing"]
        self.manifest(names, vehicle="golf", lever_arm="1.5")
        self.batch()
        self.assertEqual([row["pass"] for row in self.table().values()], ["2"] * 4)
        self.assert_whole(names)
        for name in names:
            arguments = json.loads((self.out / name / "summary.json").read_text())["arguments"]
            self.assertIn("--vehicle=joint_car.yaml", arguments)
            self.assertNotIn("--lever-arm=1.5", arguments, "it would hide the joint one")
            before = json.loads((self.out / "first_pass" / name / "summary.json").read_text())["arguments"]
            self.assertIn("--lever-arm=1.5", before)
        cars = {name: dict(line.split(": ") for line in (self.out / name / "joint_car.yaml").read_text().splitlines()[1:])
                for name in names}
        slips = {name: float(car["side_slip"]) for name, car in cars.items()}
        self.assertLess(slips["car-0.0062-b"], slips["car-0.0058-c"], "a drive's own evidence is left out of its estimate")
        self.assertGreater(float(cars[names[0]]["height_sigma"]), 0)
        with open(self.out / "vehicles.csv", encoding="utf-8", newline="") as file:
            row, = csv.DictReader(file)
        self.assertEqual((row["vehicle"], row["drives"], row["outliers"]), ("golf", "4", ""))
        # Three times the information of a drive, 0.75 of the posterior's, beside the prior's.
        self.assertAlmostEqual(float(row["side_slip"]), 0.0062, delta=0.0003)

        self.batch()
        self.assertEqual([self.starts(name) for name in names], [2] * 4, "nothing is done twice")
        # Another drive of the car changes what the others tell.
        self.manifest([*names, "car-0.0061-d"], vehicle="golf", lever_arm="1.5")
        self.batch()
        self.assertEqual([self.starts(name) for name in names], [3] * 4)
        self.assert_whole([*names, "car-0.0061-d"])

    def test_a_car_with_one_drive_left_has_its_first_pass_again(self):
        names = ["car-0.006-a", "car-0.0062-b"]
        self.manifest(names, vehicle="golf", lever_arm="1.5")
        self.batch()
        self.assertEqual(self.table()[names[0]]["pass"], "2")
        self.manifest(names[:1], vehicle="golf", lever_arm="1.5")
        self.batch()
        self.assertEqual(self.table()[names[0]]["pass"], "1")
        self.assertFalse((self.out / names[0] / "joint_car.yaml").exists())
        self.assertEqual(self.starts(names[0]), 2)
        self.assert_whole(names[:1])

    def test_without_the_second_pass(self):
        self.manifest(["car-0.006-a", "car-0.0062-b"], vehicle="golf", lever_arm="1.5")
        self.batch("--no-second-pass")
        self.assertEqual([row["pass"] for row in self.table().values()], ["1", "1"])
        self.assertFalse((self.out / "first_pass").exists())

    def test_results_of_a_second_pass_stay_where_the_next_is_left_out(self):
        names = ["car-0.006-a", "car-0.0062-b"]
        self.manifest(names, vehicle="golf", lever_arm="1.5")
        self.batch()
        vehicles = (self.out / "vehicles.csv").read_text()
        self.manifest([*names, "car-0.0061-c"], vehicle="golf", lever_arm="1.5")
        self.batch("--no-second-pass")
        self.assertEqual([row["pass"] for row in self.table().values()], ["2", "2", "1"])
        self.assertTrue((self.out / names[0] / "joint_car.yaml").exists())
        self.assertEqual((self.out / "vehicles.csv").read_text(), vehicles)
        self.batch()
        self.assertEqual([row["pass"] for row in self.table().values()], ["2", "2", "2"])
        self.assertEqual([self.starts(name) for name in names], [3, 3])
        self.assert_whole([*names, "car-0.0061-c"])

    def mount(self, size):
        """A disk of so many bytes, at the folder of results."""
        self.out.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(self.out)], check=False,
                                 stderr=subprocess.DEVNULL)
        if mounted.returncode != 0:
            self.skipTest("mounting needs root")
        self.addCleanup(subprocess.run, ["umount", "--lazy", str(self.out)], check=True)

    def test_a_disk_that_is_full(self):
        self.mount(4_000_000)
        names = ["write-1-a", "write-1-b", "write-3-c"]
        self.manifest(names)
        self.batch(code=1)
        table = self.table()
        failed = [name for name in names if table[name]["exit_code"] != "0"]
        self.assertIn("write-3-c", failed)
        for name in failed:
            self.assertIn("No space left", table[name]["error"])
            self.assertFalse((self.out / name).exists())
        self.assert_whole(set(names) - set(failed))

        # Not even the table has room.
        with contextlib.suppress(OSError), open(self.out / "filler", "wb") as file:
            while True:
                file.write(bytes(4096))
        self.manifest([*names, "write-1-d"])
        said = self.batch("--redo-failed", code=1)
        self.assertIn("No space left", said)
        self.assert_whole(set(names) - set(failed))

        (self.out / "filler").unlink()
        subprocess.run(["mount", "-o", "remount,size=40000000", str(self.out)], check=True)
        self.batch("--redo-failed")
        self.assert_whole([*names, "write-1-d"])

    def test_folders_of_others_are_not_touched(self):
        self.manifest(["sleep-0-a"])
        (self.out / "sleep-0-a").mkdir(parents=True)
        (self.out / "sleep-0-a" / "mine.txt").write_text("precious")
        self.assertIn("not from turnscale batch", self.batch(code=2))
        self.assertEqual((self.out / "sleep-0-a" / "mine.txt").read_text(), "precious")

    def test_an_external_scheduler(self):
        names = [f"sleep-0.1-{i}" for i in range(4)]
        self.manifest([*names, "bad-1"])
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        address = f"tcp://127.0.0.1:{port}"
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": self.folder}
        python = [sys.executable, "-m"]
        commands = [[*python, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(port),
                     "--no-dashboard"],
                    [*python, "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard"]]
        with contextlib.ExitStack() as stack:
            for command in commands:
                process = stack.enter_context(subprocess.Popen(command, **quiet))
                stack.callback(process.terminate)
            self.batch("--scheduler", address, code=1)
        self.assert_whole(names)
        self.assertEqual(self.table()["bad-1"]["exit_code"], "2")

    def test_a_scheduler_that_is_not_there(self):
        self.manifest(["sleep-0-a"])
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            said = self.batch("--scheduler", f"tcp://127.0.0.1:{probe.getsockname()[1]}", "--quiet", code=1)
        self.assertIn("cannot be reached", said)

    def test_wrong_arguments_are_one_line(self):
        self.manifest(["sleep-0-a"])
        for more in (["--timeout", "-1"], ["--workers", "0"], ["--sheduler", "x"], ["--program", "/none"]):
            self.assertEqual(self.batch(*more, code=2).count("\n"), 1)


if __name__ == "__main__":
    unittest.main()
