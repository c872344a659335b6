# SPDX-License-Identifier: MIT
"""How far the batch is, on the error stream: a bar on a terminal, plain lines otherwise."""
import time

BAR = 24  # characters
LINE_INTERVAL = 30  # seconds between plain lines, unless a drive fails


def spoken(seconds):
    minutes = int(seconds // 60)
    if minutes == 0:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 120 else f"{minutes // 60} h {minutes % 60:02d} min"


class Progress:
    """Counts runs: of drives, and their second passes as far as they are expected."""

    def __init__(self, total, workers, quiet, stream, clock=time.monotonic):
        self.total, self.workers = total, max(1, workers)
        self._quiet, self._stream, self._clock = quiet, stream, clock
        self._bar = stream.isatty()
        self._begin = self._last_line = clock()
        self.done = self.failed = 0
        self._wall = 0.0

    def remaining(self):
        """Seconds, from the mean of what has been run; None where nothing has."""
        if self.done == 0:
            return None
        return max(0, self.total - self.done) * self._wall / self.done / self.workers

    def add(self, record):
        self.done += 1
        self._wall += record["wall_s"]
        if record["exit_code"] != 0:
            self.failed += 1
            self.say(f"{record['drive']}: {record['error']}")
        self.show()

    def text(self):
        parts = [f"{self.done} of {self.total} runs"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        remaining = self.remaining()
        if self.done < self.total:
            parts.append("end not known yet" if remaining is None else f"about {spoken(remaining)} left")
        return ", ".join(parts)

    def show(self, ended=False):
        if self._quiet:
            return
        if self._bar:
            full = BAR * self.done // max(1, self.total)
            self._stream.write(f"\r\033[K[{'#' * full}{'.' * (BAR - full)}] {self.text()}" + ("\n" if ended else ""))
            self._stream.flush()
        elif ended or self._clock() - self._last_line >= LINE_INTERVAL:
            self._last_line = self._clock()
            print(self.text(), file=self._stream, flush=True)

    def say(self, text):
        clear = "\r\033[K" if self._bar and not self._quiet else ""
        safe = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
        print(f"{clear}turnscale: {safe}", file=self._stream, flush=True)
