# SPDX-License-Identifier: MIT
"""Which drives have to be run, first on their own and then with what all drives of their car tell."""
import dataclasses

from .evidence import estimates_of
from .vehicles import Vehicle


@dataclasses.dataclass
class BatchOptions:
    program: str
    threads: str = "1"
    timeout: float | None = None
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
        self._waiting = {}  # by vehicle: names of the drives whose first pass is not known yet
        if options.second_pass:
            for drive in drives:
                if drive.vehicle:
                    self._waiting.setdefault(drive.vehicle, set()).add(drive.name)
            self._waiting = {name: waiting for name, waiting in self._waiting.items() if len(waiting) > 1}

    def expected_runs(self, tasks):
        """With the second passes that the tasks of the first lead to."""
        vehicles = {self._drive[task["drive"]].vehicle for task in tasks if task["pass"] == 1}
        seconds = sum(drive.vehicle in vehicles & self._waiting.keys() for drive in self.drives)
        return len(tasks) + seconds

    def first_tasks(self):
        """Of the drives that are not finished, and the second passes of vehicles whose drives all are."""
        tasks = []
        for drive in self.drives:
            record = self._store.finished(drive, drive.key())
            if record is None:
                tasks.append(self._task(drive, 1))
            else:
                tasks += self.take(record)
        return tasks

    def take(self, record):
        """A drive has been run; returns the tasks that follow from it."""
        drive = self._drive[record["drive"]]
        self.records[drive.name] = record
        waiting = self._waiting.get(drive.vehicle)
        if waiting is None or drive.name not in waiting:
            return []
        waiting.discard(drive.name)
        return [] if waiting else self._second_pass(drive.vehicle)

    def _second_pass(self, name):
        drives = [drive for drive in self.drives if drive.vehicle == name]
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
            task = self._task(drive, 2, files, replaced)
            record = self._store.finished(drive, task["key"])
            if record is None:
                tasks.append(task)
            else:
                self.records[drive.name] = record
        return tasks

    def _task(self, drive, number, files=(), replaced=()):
        arguments = drive.arguments(replaced)
        if drive.option("--threads") is None:
            arguments.append(f"--threads={self._options.threads}")
        return {"out": str(self._store.places.out), "drive": drive.name, "pass": number,
                "key": drive.key(*[text for _, _, text in files]), "files": list(files),
                "command": [self._options.program, "run", "--quiet", *arguments], "session": self._store.token,
                "timeout": self._options.timeout, "most_attempts": self._options.most_attempts}

    def settle(self):
        """Drives whose joint estimates have gone have the results of their first pass."""
        for record in self.records.values():
            if record["exit_code"] == 0 and record["pass"] == 1:
                self._store.restore_first_pass(record)

    def write_table(self):
        self._store.write_table([self._store.row(drive, self.records.get(drive.name), self.doubts.get(drive.name, ()))
                                 for drive in self.drives])
