# SPDX-License-Identifier: MIT
"""The command line of `turnscale batch`."""
import argparse
import contextlib
import math
import os
import pathlib
import shutil
import signal
import sys
import time

from .dask_log import stderr_in_file
from .errors import BatchError, InputError
from .manifest import COLUMNS, read_manifest
from .progress import Progress
from .store import Store

INTERRUPTED = 130
SAVE_INTERVAL = 10  # seconds between tables, at least
SAVE_SHARE = 20  # times the seconds that a table takes to write, likewise
WORKERS_EXPECTED = 10  # seconds after which the user is told that there are none


class _Parser(argparse.ArgumentParser):
    def error(self, message):
        raise InputError(f"batch: {message}; see turnscale batch --help")


def _number(text, kind):
    try:
        return kind(text)
    except ValueError:
        what = "whole number" if kind is int else "number"
        raise argparse.ArgumentTypeError(f"'{text}': has to be a {what}") from None


def _seconds(text):
    value = _number(text, float)
    if not (math.isfinite(value) and value > 0):
        raise argparse.ArgumentTypeError(f"'{text}': has to be a positive number of seconds")
    return value


def _count(text):
    value = _number(text, int)
    if value < 1:
        raise argparse.ArgumentTypeError(f"'{text}': give at least 1")
    return value


def _parser():
    parser = _Parser(
        prog="turnscale batch", formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False,
        description="Run many drives, on all cores of this machine or on a Dask cluster. A second call does what is "
                    "left.",
        epilog="Columns of the manifest: drive, input (several separated by ';'), vehicle (name of the car), "
               "vehicle_file (--vehicle of run), and options of turnscale run: "
               f"{', '.join(COLUMNS[4:])}. Paths are relative to the manifest.\n\n"
               "Example:\n  turnscale batch drives.csv --out results\n\n"
               "Exit codes: 0 every drive is done, 1 drives have failed (table.csv says why), disk full, out of memory or "
               "internal error, 2 unusable input, 130 interrupted.")
    parser.add_argument("manifest", type=pathlib.Path, help="CSV file with one drive per row")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="DIR",
                        help="Folder for the results; on a cluster, all workers need it, and the images, under the "
                             "same path")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="Dask scheduler, such as tcp://host:8786 [workers on "
                                                               "this machine]")
    parser.add_argument("--workers", type=_count, metavar="N", help="Drives at a time on this machine [its cores]")
    parser.add_argument("--threads", type=_count, default=1, metavar="N", help="Threads of each run; does not affect "
                                                                               "the result [1]")
    parser.add_argument("--timeout", type=_seconds, metavar="S", help="Kill a run after S seconds and count it as failed")
    parser.add_argument("--redo-failed", action="store_true", help="Run drives again that have failed before")
    parser.add_argument("--no-second-pass", action="store_true",
                        help="Do not run drives again with the joint estimates of their vehicle; keep the results of "
                             "earlier second passes")
    parser.add_argument("--attempts", type=_count, default=5, metavar="N",
                        help="Attempts per run of a drive if its worker dies [5]")
    parser.add_argument("--program", metavar="FILE", default=os.environ.get("TURNSCALE_PROGRAM", "turnscale"),
                        help="The program turnscale on the workers [this one]")
    parser.add_argument("--quiet", action="store_true", help="Print failures and errors only")
    return parser


def _program(name):
    found = shutil.which(name)
    if found is None:
        raise InputError(f"--program {name}: is no program")
    return str(pathlib.Path(found).absolute())


def _cores():
    return len(os.sched_getaffinity(0))


def _interrupt(_signal, _frame):
    # The next Ctrl-C does not wait for anything. A service manager may repeat SIGTERM while results are being saved.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    raise KeyboardInterrupt


class _Watch:
    """Keeps the table and the progress up to date while drives are run."""

    def __init__(self, batch, progress, scheduler, address):
        self._batch, self._progress, self._scheduler, self._address = batch, progress, scheduler, address
        self._next_save = time.monotonic() + SAVE_INTERVAL
        self._workers_missed = time.monotonic() + WORKERS_EXPECTED

    def on_record(self, record):
        tasks = self._batch.take(record)
        self._progress.add(record)
        return tasks

    def on_tick(self):
        threads = self._scheduler.threads()
        self._progress.expect(self._batch.left(), self._batch.seconds_left(max(1, threads)))
        self._progress.show()
        if self._address and threads == 0 and time.monotonic() > self._workers_missed:
            self._workers_missed = math.inf
            self._progress.say(f"--scheduler {self._address}: has no worker yet; waiting")
        if time.monotonic() > self._next_save:
            self._save()

    def _save(self):
        begin = time.monotonic()
        # A disk that is full now may not be at the end.
        with contextlib.suppress(BatchError):
            self._batch.write_table()
        now = time.monotonic()
        self._next_save = now + max(SAVE_INTERVAL, SAVE_SHARE * (now - begin))


def _run(batch, tasks, store, arguments, messages):
    """Returns whether it was interrupted. Messages go to that stream."""
    # Takes a second to load.
    from .schedule import Scheduler
    progress = Progress(batch.left(), arguments.quiet, messages)
    scheduler = None
    try:
        scheduler = Scheduler(arguments.scheduler, min(arguments.workers or _cores(), batch.left()))
        watch = _Watch(batch, progress, scheduler, arguments.scheduler)
        scheduler.run(tasks, watch.on_record, watch.on_tick)
    except KeyboardInterrupt:
        return True
    finally:
        store.end_session()
        if scheduler:
            scheduler.close()
        progress.expect(batch.left(), None)
        progress.show(ended=True)
    return False


def run_batch(arguments):
    # They need numpy and yaml.
    from .batch import Batch, BatchOptions
    from .vehicles import write_vehicles
    drives = read_manifest(arguments.manifest)
    options = BatchOptions(_program(arguments.program), str(arguments.threads), arguments.timeout,
                           not arguments.no_second_pass, arguments.attempts)
    store = Store(arguments.out)
    store.refuse_strangers(drives)
    batch = Batch(drives, store, options)
    if arguments.redo_failed:
        for drive in drives:
            store.forget_failure(drive)
    tasks = batch.first_tasks()
    interrupted = False
    try:
        if tasks:
            with stderr_in_file(store.places.dask_log) as messages:
                interrupted = _run(batch, tasks, store, arguments, messages)
    finally:
        store.end_session()
        try:
            batch.settle()
            batch.write_table()
            if batch.vehicles_known():
                write_vehicles(store.places.out / "vehicles.csv", batch.vehicles.values())
        finally:
            store.clean()
    failed = sum(record["exit_code"] != 0 for record in batch.records.values())
    table = arguments.out / "table.csv"
    if interrupted:
        left = len(drives) - len(batch.records)
        print(f"turnscale: interrupted; a second call does what is left; {table} has the "
              f"{len(drives) - left} drives so far", file=sys.stderr)
        return INTERRUPTED
    if failed:
        print(f"turnscale: {failed} of {len(drives)} drives failed; {table} says why, and --redo-failed tries them "
              "again", file=sys.stderr)
        return 1
    if not arguments.quiet:
        print(f"{len(drives)} drives, {len(tasks)} of them run now\ntable   {table}")
    return 0


def _manifest_name(words):
    return words[0] if words else "batch"


def main(words, require_modules):
    """Returns the exit code. `require_modules()` is called once the arguments are known to be good."""
    signal.signal(signal.SIGINT, _interrupt)
    signal.signal(signal.SIGTERM, _interrupt)
    try:
        arguments = _parser().parse_args(words)
        require_modules()
        return run_batch(arguments)
    except BatchError as error:
        print("turnscale: " + " ".join(str(error).split()), file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("turnscale: interrupted", file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        print(f"turnscale: {error.filename or _manifest_name(words)}: {error.strerror or error}", file=sys.stderr)
        return 1
