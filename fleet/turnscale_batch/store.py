# SPDX-License-Identifier: MIT
"""The folder of results: its lock, its records, and the table."""
import csv
import fcntl
import io
import json
import os
import shutil
import uuid

from .attempt import Places, discard, finished, read_record
from .errors import BatchError, InputError

TABLE_COLUMNS = ("drive", "vehicle", "exit_code", "error", "pass", "seconds", "frames", "tracked", "length_m",
                 "length_sigma", "scale_state", "scale_known", "turns_found", "turns_used", "warnings", "wall_s", "cpu_s",
                 "attempts", "host")


def write_whole(path, text):
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        raise BatchError(f"{path}: cannot be written: {error.strerror}") from error


class Store:
    """The results folder, held for this batch alone as long as it lives."""

    def __init__(self, out):
        self.places = Places(out.absolute())
        self.token = uuid.uuid4().hex[:12]
        try:
            self.places.hidden.mkdir(parents=True, exist_ok=True)
            self._lock = open(self.places.hidden / "lock", "a", encoding="utf-8")
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{out}: another turnscale batch is writing there; wait for its end, or choose another "
                             "--out") from None
        except OSError as error:
            raise InputError(f"{out}: cannot be used: {error.strerror}; choose another --out") from error
        # What an earlier call left behind ends, and its remains go.
        for old in self.places.hidden.glob("session-*"):
            old.unlink()
        self.clean()
        self.places.session(self.token).touch()

    def end_session(self):
        """Attempts that still run on any worker stop."""
        self.places.session(self.token).unlink(missing_ok=True)

    def clean(self):
        for folder in (self.places.attempts, self.places.started, self.places.trash):
            shutil.rmtree(folder, ignore_errors=True)

    def refuse_strangers(self, drives):
        """No folder that something else made is replaced."""
        for drive in drives:
            folder = self.places.final(drive.name)
            if folder.exists() and read_record(folder) is None:
                raise InputError(f"{folder}: is there already, but not from turnscale batch; choose another --out, or "
                                 "remove it")

    def finished(self, drive, key):
        return finished(self.places, drive.name, key)

    def records(self, drive):
        """Of earlier runs, of this row of the manifest or of one of the same name."""
        for folder in (self.places.failed(drive.name), self.places.first_pass(drive.name), self.places.final(drive.name)):
            if record := read_record(folder):
                yield record

    def forget_failure(self, drive):
        shutil.rmtree(self.places.failed(drive.name), ignore_errors=True)

    def folder_of(self, record):
        """Where the results lie that the record describes."""
        name = record["drive"]
        if record["exit_code"] != 0:
            return self.places.failed(name)
        for folder in (self.places.final(name), self.places.first_pass(name)):
            if (read_record(folder) or {}).get("key") == record["key"]:
                return folder
        return self.places.final(name)

    def _has_made_way(self, record):
        """Whether the results of this first pass have made way for those of a second."""
        return (read_record(self.places.first_pass(record["drive"])) or {}).get("key") == record["key"]

    def restore_first_pass(self, record):
        """Puts the results back in their place."""
        if self._has_made_way(record):
            discard(self.places, self.places.final(record["drive"]))
            os.rename(self.places.first_pass(record["drive"]), self.places.final(record["drive"]))

    def second_of(self, record):
        """The record of an earlier second pass after this first one; None if there is none."""
        return read_record(self.places.final(record["drive"])) if self._has_made_way(record) else None

    def summary(self, record):
        try:
            return json.loads((self.folder_of(record) / "summary.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    def row(self, drive, record, doubts=()):
        """Of the table, as text."""
        row = dict.fromkeys(TABLE_COLUMNS, "")
        row |= {"drive": drive.name, "vehicle": drive.vehicle}
        if record is None:
            return row | {"error": "not run yet"}
        summary = self.summary(record)
        frames, turns, scale = (summary.get(name) or {} for name in ("frames", "turns", "scale"))
        sigma = summary.get("path_sigma")
        length = summary.get("distance_m")
        seconds = (summary.get("missing") or {}).get("of_s")
        row |= {"exit_code": record["exit_code"], "error": record["error"], "pass": record["pass"],
                "seconds": "" if seconds is None else f"{seconds:.3f}", "frames": frames.get("total", ""),
                "tracked": frames.get("tracked", ""), "length_m": "" if length is None else f"{length:.3f}",
                "length_sigma": "" if sigma is None or length is None else f"{sigma:.5f}",
                "scale_state": scale.get("state", ""),
                "scale_known": int(scale["known"]) if "known" in scale else "", "turns_found": turns.get("found", ""),
                "turns_used": turns.get("used", ""), "warnings": " | ".join([*summary.get("warnings", []), *doubts]),
                "wall_s": f"{record['wall_s']:.2f}", "cpu_s": f"{record['cpu_s']:.2f}",
                "attempts": record["attempts"], "host": record["host"]}
        return row

    def write_table(self, rows):
        text = io.StringIO()
        writer = csv.DictWriter(text, TABLE_COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        write_whole(self.places.out / "table.csv", text.getvalue())
