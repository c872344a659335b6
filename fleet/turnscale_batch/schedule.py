# SPDX-License-Identifier: MIT
"""Runs tasks on a Dask cluster, be it this machine's or another's."""
import contextlib
import queue
import signal
import tempfile
import threading
import time
from multiprocessing import resource_tracker

import cloudpickle
import distributed
import psutil

from . import attempt
from .errors import BatchError

TICK = 1.0  # seconds
MOST_SUBMISSIONS = 20
WORKER_START = 30.0  # seconds that a worker has
CLOSE = 10.0  # seconds that Dask has for its end


async def _block_interrupts():
    """Ctrl-C on the terminal is for the batch. Processes that this thread starts never see it."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})


class Scheduler:
    """A client of the scheduler at an address, or of a cluster of this machine's cores."""

    def __init__(self, address, workers):
        # Workers need nothing of turnscale's Python: what they run is sent to them.
        cloudpickle.register_pickle_by_value(attempt)
        self._exit = contextlib.ExitStack()
        self._address = address
        self._cluster = None
        self._complete = time.monotonic()  # when all workers were last there
        if address:
            try:
                self._client = self._exit.enter_context(distributed.Client(address, timeout="15s"))
            except (OSError, ValueError) as error:
                raise BatchError(f"--scheduler {address}: cannot be reached: {error or type(error).__name__}") from error
            return
        folder = self._exit.enter_context(tempfile.TemporaryDirectory(prefix="turnscale-batch-",
                                                                      ignore_cleanup_errors=True))
        # A worker that dies while it starts must not hold up the others, so the cluster begins without any.
        self._cluster = self._exit.enter_context(distributed.LocalCluster(
            n_workers=0, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0,
            local_directory=folder))
        self._client = self._exit.enter_context(distributed.Client(self._cluster))
        # Starting the tracker would unblock them again.
        resource_tracker.ensure_running()
        self._cluster.sync(_block_interrupts)
        self._wanted = workers
        self._cluster.scale(workers)

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

    def workers(self):
        """How many drives run at a time; 0 while there is no worker."""
        return sum(worker["nthreads"] for worker in self._client.scheduler_info()["workers"].values())

    def run(self, tasks, on_record, on_tick=lambda: None):
        """Runs tasks, and those that `on_record`, called with the record of each, returns. A task whose worker dies is
        given to another one; `run_task` counts its attempts."""
        results = queue.Queue()
        submitted = {}
        pending = {}

        def submit(task):
            count = submitted[task["drive"], task["key"]] = submitted.get((task["drive"], task["key"]), 0) + 1
            name = f"{task['drive']}-{task['key']}-{task['session']}-{count}"
            pending[name] = self._client.submit(attempt.run_task, task, key=name, pure=False)
            pending[name].add_done_callback(lambda future: results.put((task, future)))

        for task in tasks:
            submit(task)
        try:
            while pending:
                try:
                    task, future = results.get(timeout=TICK)
                except queue.Empty:
                    if self._client.status not in ("running", "connecting"):
                        raise BatchError(f"the scheduler {self._address or ''} is gone; a second call does what is left")
                    self._replace_lost_workers()
                    on_tick()
                    continue
                del pending[future.key]
                record, lost = self._record(task, future)
                if lost and submitted[task["drive"], task["key"]] < MOST_SUBMISSIONS:
                    submit(task)
                    continue
                for more in on_record(record):
                    submit(more)
        finally:
            if pending:
                with contextlib.suppress(Exception):
                    self._client.cancel(list(pending.values()), force=True)

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
