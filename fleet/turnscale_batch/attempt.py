# SPDX-License-Identifier: MIT
"""One attempt at one drive: `turnscale run` as a child process, in a folder of its own that gets its final name when it
is whole. Runs on the workers, to which this module is sent: it uses the standard library only."""
import contextlib
import datetime
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time
import uuid

RECORD = "batch.json"  # of a finished drive, in its folder
# The worker's death ends the child: else two children would work on the drive.
DIES_WITH_WORKER = ("setpriv", "--pdeathsig", "KILL", "--")
POLL = 0.05  # seconds
SESSION_POLL = 1.0
KILL_PATIENCE = 30.0  # seconds for a process to die
STOPPED = "stopped"
NOT_RUN = -1


class Stopped(Exception):
    """The batch that asked for the drive has ended."""


class Places:
    """Where the results lie."""

    def __init__(self, out):
        self.out = pathlib.Path(out)
        self.hidden = self.out / ".batch"
        self.attempts = self.hidden / "attempts"
        self.started = self.hidden / "started"
        self.trash = self.hidden / "trash"
        self.dask_log = self.hidden / "dask.log"

    def final(self, drive):
        return self.out / drive

    def first_pass(self, drive):
        return self.out / "first_pass" / drive

    def failed(self, drive):
        return self.out / "failed" / drive

    def log(self, drive):
        return self.out / "logs" / f"{drive}.log"

    def session(self, token):
        return self.hidden / f"session-{token}"


def read_record(folder):
    """What is known of a finished drive, whose name the folder has; None where it holds no record."""
    try:
        record = json.loads((folder / RECORD).read_text())
    except (OSError, ValueError):
        return None
    # Users rename drives, and folders with them.
    return record | {"drive": folder.name} if isinstance(record, dict) and "key" in record else None


def finished(places, drive, key):
    """The record of a drive that has been run with this key, well or not; None if it has not."""
    for folder in (places.final(drive), places.first_pass(drive), places.failed(drive)):
        record = read_record(folder)
        if record and record["key"] == key:
            return record
    return None


def _write_whole(path, text):
    part = path.with_name(f"{path.name}.{uuid.uuid4().hex[:8]}.part")
    with open(part, "w", encoding="utf-8") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def discard(places, folder):
    """Out of sight at once, then removed."""
    places.trash.mkdir(parents=True, exist_ok=True)
    gone = places.trash / uuid.uuid4().hex
    try:
        os.rename(folder, gone)
    except FileNotFoundError:
        return
    shutil.rmtree(gone, ignore_errors=True)


def _publish(places, task, record, folder):
    """Gives the attempt its final name, unless another attempt of the same was faster. Returns the record that
    stands."""
    drive, key = task["drive"], task["key"]
    if record["exit_code"] == 0:
        final = places.final(drive)
        if task["pass"] == 2 and not places.first_pass(drive).exists():
            places.first_pass(drive).parent.mkdir(exist_ok=True)
            # Another attempt of the same may be doing this too.
            with contextlib.suppress(OSError):
                os.rename(final, places.first_pass(drive))
        if task["pass"] == 1:
            discard(places, places.first_pass(drive))
    else:
        final = places.failed(drive)
        final.parent.mkdir(exist_ok=True)
    for _ in range(10):
        try:
            os.rename(folder, final)
            break
        except OSError:
            standing = read_record(final)
            if standing and standing["key"] == key:
                discard(places, folder)
                return standing
            discard(places, final)
    else:
        raise OSError(f"{final}: cannot be replaced")
    if record["exit_code"] == 0:
        discard(places, places.failed(drive))
    elif task["pass"] == 1:
        # Results of an earlier version of the row are not this drive's.
        for stale in (places.final(drive), places.first_pass(drive)):
            discard(places, stale)
    return record


class _Child:
    """`turnscale run` in a process group of its own."""

    def __init__(self, command, log, folder):
        setpriv = shutil.which(DIES_WITH_WORKER[0])
        prefix = [setpriv, *DIES_WITH_WORKER[1:]] if setpriv else []
        self._process = subprocess.Popen([*prefix, *command], stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                         cwd=folder, start_new_session=True)
        self.exit_code = None
        self.cpu_seconds = 0.0

    def poll(self):
        if self.exit_code is None:
            pid, status, usage = os.wait4(self._process.pid, os.WNOHANG)
            if pid:
                self.exit_code = self._process.returncode = os.waitstatus_to_exitcode(status)
                self.cpu_seconds = usage.ru_utime + usage.ru_stime
        return self.exit_code

    def kill(self):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self._process.pid, signal.SIGKILL)
        begin = time.monotonic()
        while self.poll() is None:
            if time.monotonic() - begin > KILL_PATIENCE:
                # It waits for a disk or a network that does not answer.
                self.exit_code = -signal.SIGKILL
            time.sleep(POLL)


def _wait(child, timeout, session):
    """Returns why the child was ended early; empty where it ended by itself."""
    begin = time.monotonic()
    looked = begin
    while child.poll() is None:
        now = time.monotonic()
        if timeout and now - begin > timeout:
            child.kill()
            return f"ended after {timeout:g} s (--timeout)"
        if now - looked > SESSION_POLL:
            looked = now
            if not session.exists():
                child.kill()
                return STOPPED
        time.sleep(POLL)
    return ""


def _last_line(log, start):
    """The error's line: the program prints it last."""
    try:
        with open(log, "rb") as file:
            file.seek(max(start, os.path.getsize(log) - 65536))
            lines = file.read().decode(errors="replace").splitlines()
    except OSError:
        return ""
    said = [line.strip() for line in lines if line.strip()]
    errors = [line for line in said if line.startswith("turnscale: ")]
    line = (errors or said or [""])[-1]
    return line.removeprefix("turnscale: ")


def _error(child, ended, log, start):
    if ended:
        return ended
    if child.exit_code < 0:
        return f"killed by {signal.Signals(-child.exit_code).name}"
    return _last_line(log, start) if child.exit_code else ""


def _now():
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


def _base_record(task, attempts):
    return {"drive": task["drive"], "key": task["key"], "pass": task["pass"], "attempts": attempts,
            "host": socket.gethostname(), "wall_s": 0.0, "cpu_s": 0.0, "exit_code": NOT_RUN, "error": "",
            "finished": _now()}


def _keep_failure(places, task, record):
    """A failure without results."""
    folder = places.attempts / f"{task['drive']}-{uuid.uuid4().hex[:8]}"
    folder.mkdir(parents=True)
    _write_whole(folder / RECORD, json.dumps(record, indent=1))
    return _publish(places, task, record, folder)


def _attempt(places, task, attempts):
    folder = places.attempts / f"{task['drive']}-{uuid.uuid4().hex[:8]}"
    results = folder / "results"
    folder.mkdir(parents=True)
    log_path = places.log(task["drive"])
    record = _base_record(task, attempts)
    try:
        # Named without the attempt's folder, so that the results are the same in each attempt.
        files = []
        for option, name, text in task.get("files", ()):
            (folder / name).write_text(text)
            files.append(f"{option}={name}")
        command = [*task["command"], *files, f"--out={results}"]
        log_path.parent.mkdir(exist_ok=True)
        with open(log_path, "ab", buffering=0) as log:
            log.write(f"== {_now()} {record['host']}, pass {task['pass']}, attempt {attempts}: "
                      f"{' '.join(command)}\n".encode(errors="surrogateescape"))
            start = log.tell()
            begin = time.monotonic()
            child = _Child(command, log, folder)
            ended = _wait(child, task.get("timeout"), places.session(task["session"]))
        if ended == STOPPED:
            raise Stopped("the batch has ended")
        # Partial results of a failure move with it.
        error = _error(child, ended, log_path, start).replace(str(results), str(places.failed(task["drive"])))
        record |= {"wall_s": time.monotonic() - begin, "cpu_s": child.cpu_seconds, "exit_code": child.exit_code,
                   "error": error, "finished": _now()}
        summary = results / "summary.json"
        if record["exit_code"] == 0 and not summary.is_file():
            record |= {"exit_code": 1, "error": "the program wrote no summary.json"}
        results.mkdir(exist_ok=True)
        for _, name, _ in task.get("files", ()):
            os.rename(folder / name, results / name)
        # Last: a folder with a record is whole.
        _write_whole(results / RECORD, json.dumps(record, indent=1))
        return _publish(places, task, record, results)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def run_task(task):
    """Runs a drive unless its result is there already, and returns its record. `task` has `out`, `drive`, `key`,
    `pass`, `command` (without --out), `session`, and optionally `timeout` (seconds), `files` (option of run, name,
    text) and `most_attempts`; `priority` is the scheduler's."""
    places = Places(task["out"])
    if standing := finished(places, task["drive"], task["key"]):
        return standing
    if not places.session(task["session"]).exists():
        raise Stopped("the batch has ended")
    started = places.started / f"{task['drive']}-{task['key']}"
    attempts = 0
    try:
        started.mkdir(parents=True, exist_ok=True)
        attempts = len(os.listdir(started)) + 1
        if attempts > task.get("most_attempts", 5):
            record = _base_record(task, attempts - 1)
            record["error"] = f"the worker was lost in each of {attempts - 1} attempts"
            record = _keep_failure(places, task, record)
        else:
            (started / uuid.uuid4().hex).touch()
            record = _attempt(places, task, attempts)
    except OSError as error:
        # A full disk costs this drive; what it did not write cannot be found, so a later call tries again.
        return _base_record(task, attempts) | {"exit_code": 1, "error": f"{error.strerror or error}: "
                                               f"{error.filename or places.out}"}
    shutil.rmtree(started, ignore_errors=True)
    return record
