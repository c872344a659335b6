# SPDX-License-Identifier: MIT
"""Runs tasks on a Dask cluster, be it this machine's or another's."""
import collections
import contextlib
import queue
import signal
import tempfile
import threading
import time
from multiprocessing import resource_tracker

import cloudpickle
import dask
import distributed
import psutil

from . import attempt
from .errors import BatchError, InputError

TICK = 1.0  # seconds
MOST_SUBMISSIONS = 20
WORKER_START = 30.0  # seconds that a worker has
CLOSE = 10.0  # seconds that Dask has for its end


async def _block_interrupts():
    """Ctrl-C on the terminal is for the batch. Processes that this thread starts never see it."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


def _client_of(address):
    try:
        return distributed.Client(address, timeout="15s")
    except ValueError as error:
        raise InputError(f"--scheduler {address}: {error}; give an address such as tcp://host:8786") from error
    except OSError as error:
        raise BatchError(f"--scheduler {address}: cannot be reached: {error or type(error).__name__}") from error


def _local_cluster(stack):
    """A client and a cluster of this machine, without a worker yet: one that dies while the cluster starts would hold it
    up forever."""
    folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="turnscale-batch-", ignore_cleanup_errors=True))
    # No worker has a task in stock: the next one goes to the first worker that is free.
    dask.config.set({"distributed.scheduler.worker-saturation": 1.0})
    cluster = stack.enter_context(distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0,
        local_directory=folder))
    client = stack.enter_context(distributed.Client(cluster))
    # Starting the tracker later would unblock interrupts again.
    resource_tracker.ensure_running()
    cluster.sync(_block_interrupts)
    return client, cluster


class Scheduler:
    """A client of the scheduler at an address, or of a cluster of this machine's cores."""

    def __init__(self, address, workers):
        # Workers need nothing of turnscale's Python: what they run is sent to them.
        cloudpickle.register_pickle_by_value(attempt)
        self._address = address
        with contextlib.ExitStack() as stack:
            if address:
                self._client = stack.enter_context(_client_of(address))
                self._cluster = None
            else:
                self._client, self._cluster = _local_cluster(stack)
                self._wanted = workers
                self._cluster.scale(workers)
            self._exit = stack.pop_all()
        self._complete = time.monotonic()  # when all workers were last there

    def _replace_lost_workers(self):
        """A worker that dies later is started again by its nanny; one that dies while it starts is not."""
        if self._cluster is None:
            return
        alive = len(self._client.scheduler_info()["workers"])
        if alive >= self._wanted:
            self._complete = time.monotonic()
        elif time.monotonic() - self._complete > WORKER_START:
            self._complete = time.monotonic()
            self._cluster.scale(alive)
            self._cluster.scale(self._wanted)

    def threads(self):
        """How many drives run at a time; 0 while there is no worker."""
        return sum(worker["nthreads"] for worker in self._client.scheduler_info()["workers"].values())

    def run(self, tasks, on_record, on_tick):
        """Runs tasks, and those that `on_record`, called with the record of each, returns: those of the highest priority
        first, as far as Dask knows of them. Calls `on_tick` about once a second. A task whose worker dies is given to
        another one; `run_task` counts its attempts."""
        results = queue.Queue()
        submissions = collections.Counter()  # by drive and key
        pending = {}

        def submit_all(tasks):
            # A worker that is free takes the first one at once.
            for task in sorted(tasks, key=lambda task: task["priority"], reverse=True):
                submit(task)

        def submit(task):
            submissions[task["drive"], task["key"]] += 1
            # Dask takes names that begin alike for one group of tasks, which it holds back until workers are free.
            name = f"turnscale-{task['session']}-{submissions.total()}-{task['drive']}"
            pending[name] = self._client.submit(attempt.run_task, task, key=name, pure=False, priority=task["priority"])
            pending[name].add_done_callback(lambda future: results.put((task, future)))

        submit_all(tasks)
        ticked = time.monotonic()
        try:
            while pending:
                if time.monotonic() - ticked > TICK:
                    ticked = time.monotonic()
                    self._check()
                    on_tick()
                try:
                    task, future = results.get(timeout=TICK)
                except queue.Empty:
                    continue
                del pending[future.key]
                record, lost = self._record(task, future)
                if lost and submissions[task["drive"], task["key"]] < MOST_SUBMISSIONS:
                    submit(task)
                    continue
                submit_all(on_record(record))
        finally:
            if pending:
                with contextlib.suppress(Exception):
                    self._client.cancel(list(pending.values()), force=True)

    def _check(self):
        if self._client.status not in ("running", "connecting"):
            raise BatchError(f"the scheduler {self._address or ''} is gone; a second call does what is left")
        self._replace_lost_workers()

    def _record(self, task, future):
        """The record, and whether the task has to be given to a worker again."""
        if future.status == "finished":
            return future.result(), False
        error = None if future.cancelled() else future.exception()
        if future.cancelled() and self._client.status != "running":
            raise BatchError(f"the scheduler {self._address or ''} is gone; a second call does what is left")
        # A worker may see late, over a network, that this batch has begun.
        lost = error is None or isinstance(error, distributed.KilledWorker) or type(error).__name__ == "Stopped"
        message = "its workers were lost" if lost else f"{type(error).__name__}: {error}"
        return {"drive": task["drive"], "key": task["key"], "pass": task["pass"], "attempts": 0, "host": "",
                "wall_s": 0.0, "cpu_s": 0.0, "exit_code": 1, "error": " ".join(message.split())}, lost

    def close(self):
        """Ends the local workers, also where Dask hangs."""
        def end():
            with contextlib.suppress(Exception):
                self._exit.close()

        closing = threading.Thread(target=end, daemon=True)
        closing.start()
        closing.join(CLOSE)
        if not closing.is_alive():
            return
        for process in psutil.Process().children(recursive=True):
            with contextlib.suppress(psutil.Error):
                process.kill()
        closing.join(CLOSE)
