# SPDX-License-Identifier: MIT
"""Which drives have to be run, first on their own and then with what all drives of their car tell."""
import dataclasses

from .durations import Durations
from .evidence import estimates_of
from .vehicles import Vehicle

BEFORE_ALL = 1e9  # a priority, in seconds


@dataclasses.dataclass
class BatchOptions:
    program: str
    threads: str = "1"
    timeout: float | None = None  # seconds
    second_pass: bool = True
    most_attempts: int = 5


class Batch:
    """The drives of a manifest and what is known of each."""

    def __init__(self, drives, store, options):
        self.drives, self._store, self._options = drives, store, options
        self.records = {}  # by name of the drive: of its latest pass
        self.doubts = {}
        self.vehicles = {}  # that have a second pass
        self._drive = {drive.name: drive for drive in drives}
        self._of_vehicle = {}  # drives, by vehicles that can have a second pass
        if options.second_pass:
            for drive in drives:
                if drive.vehicle:
                    self._of_vehicle.setdefault(drive.vehicle, []).append(drive)
            self._of_vehicle = {name: of_one for name, of_one in self._of_vehicle.items() if len(of_one) > 1}
        # By vehicle: names of the drives whose first pass is not known yet.
        self._waiting = {name: {drive.name for drive in of_one} for name, of_one in self._of_vehicle.items()}
        self._longest_runs = {}  # by vehicle: seconds
        self._left = set()  # pairs of drive and pass
        self._durations = Durations(drives, options.timeout)
        for drive in drives:
            for record in store.records(drive):
                self._durations.learn(record)

    def first_tasks(self):
        """Of the drives that are not finished, and the second passes of vehicles whose drives all are."""
        tasks = []
        for drive in self.drives:
            record = self._store.finished(drive, drive.key())
            if record is None:
                tasks.append(self._task(drive, 1))
                self._left |= {(other.name, 2) for other in self._of_vehicle.get(drive.vehicle, ())}
            else:
                tasks += self._take(record)
        return tasks

    def take(self, record):
        """A drive has been run; returns the tasks that follow from it."""
        self._left.discard((record["drive"], record["pass"]))
        self._durations.learn(record)
        return self._take(record)

    def left(self):
        """Number of runs, with the second passes that are expected."""
        return len(self._left)

    def seconds_left(self, workers):
        """Until the end, with so many runs at a time; None before any run has ended."""
        if not self._durations.known():
            return None
        seconds = [self._durations.seconds(name) for name, _ in self._left]
        return max(sum(seconds) / workers, max(seconds, default=0))

    def _take(self, record):
        drive = self._drive[record["drive"]]
        self.records[drive.name] = record
        waiting = self._waiting.get(drive.vehicle)
        if waiting is None or drive.name not in waiting:
            return []
        waiting.discard(drive.name)
        return [] if waiting else self._second_pass(drive.vehicle)

    def _second_pass(self, name):
        drives = self._of_vehicle[name]
        self._left -= {(drive.name, 2) for drive in drives}
        done = [(drive, self.records[drive.name]) for drive in drives if self.records[drive.name]["exit_code"] == 0]
        vehicle = Vehicle(name, [estimates_of(drive, self._store.summary(record), self._store.folder_of(record))
                                 for drive, record in done])
        self.vehicles[name] = vehicle
        tasks = []
        for drive in drives:
            self.doubts[drive.name] = vehicle.doubts(drive)
            files, replaced = vehicle.joint_files(drive)
            if not files:
                continue
            key = drive.key(*[text for _, _, text in files])
            record = self._store.finished(drive, key)
            if record is None:
                tasks.append(self._task(drive, 2, files, replaced))
            else:
                self.records[drive.name] = record
        return tasks

    def _task(self, drive, number, files=(), replaced=()):
        self._left.add((drive.name, number))
        arguments = drive.arguments(replaced)
        if drive.option("--threads") is None:
            arguments.append(f"--threads={self._options.threads}")
        return {"out": str(self._store.places.out), "drive": drive.name, "pass": number,
                "key": drive.key(*[text for _, _, text in files]), "files": list(files),
                "command": [self._options.program, "run", "--quiet", *arguments], "session": self._store.token,
                "timeout": self._options.timeout, "most_attempts": self._options.most_attempts,
                "priority": self._priority(drive, number)}

    def _priority(self, drive, number):
        """Seconds of the longest sequence of runs that begins with this one, so that no worker is left with a long one at
        the end. Where nothing can be told, the run either fails at once, or may hang until its timeout."""
        if not self._durations.seen(drive.name):
            return BEFORE_ALL
        return self._durations.seconds(drive.name) + (self._longest(drive.vehicle) if number == 1 else 0)

    def _longest(self, vehicle):
        """Seconds of the longest second pass of a vehicle, as expected before the first run."""
        if vehicle not in self._longest_runs:
            self._longest_runs[vehicle] = max(
                (self._durations.seconds(drive.name) for drive in self._of_vehicle.get(vehicle, ())), default=0)
        return self._longest_runs[vehicle]

    def settle(self):
        """At the end, drives that have no second pass any more have the results of their first. Where a second pass is
        left out or left to do, the results of an earlier one stay."""
        for drive in self.drives:
            # Its worker may have ended just before an interruption, and its record been on its way.
            if drive.name not in self.records and (record := self._store.finished(drive, drive.key())):
                self.records[drive.name] = record
        for name, record in self.records.items():
            if record["exit_code"] == 0 and record["pass"] == 1:
                if self._options.second_pass and (name, 2) not in self._left:
                    self._store.restore_first_pass(record)
                else:
                    self.records[name] = self._store.second_of(record) or record

    def vehicles_known(self):
        """Whether `vehicles` has all of them."""
        return self._options.second_pass and not any(self._waiting.values())

    def write_table(self):
        self._store.write_table([self._store.row(drive, self.records.get(drive.name), self.doubts.get(drive.name, ()))
                                 for drive in self.drives])
