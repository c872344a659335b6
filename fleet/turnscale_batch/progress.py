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
    """Counts runs."""

    def __init__(self, left, quiet, stream, clock=time.monotonic):
        self._left, self._seconds_left = left, None
        self._quiet, self._stream, self._clock = quiet, stream, clock
        self._bar = stream.isatty()
        self._last_line = clock()
        self._done = self._failed = 0

    def expect(self, left, seconds):
        """So many runs are left, which will take so long; None where that is not known yet."""
        self._left, self._seconds_left = left, seconds

    def add(self, record):
        self._done += 1
        if record["exit_code"] != 0:
            self._failed += 1
            self.say(f"{record['drive']}: {record['error']}")

    def text(self, ended=False):
        parts = [f"{self._done} of {self._done + self._left} runs"]
        if self._failed:
            parts.append(f"{self._failed} failed")
        if self._left and not ended:
            parts.append("end not known yet" if self._seconds_left is None
                         else f"about {spoken(self._seconds_left)} left")
        return ", ".join(parts)

    def show(self, ended=False):
        if self._quiet:
            return
        if self._bar:
            full = BAR * self._done // max(1, self._done + self._left)
            self._stream.write(f"\r\033[K[{'#' * full}{'.' * (BAR - full)}] {self.text(ended)}" + ("\n" if ended else ""))
            self._stream.flush()
        elif ended or self._clock() - self._last_line >= LINE_INTERVAL:
            self._last_line = self._clock()
            print(self.text(ended), file=self._stream, flush=True)

    def say(self, text):
        clear = "\r\033[K" if self._bar and not self._quiet else ""
        safe = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)
        print(f"{clear}turnscale: {safe}", file=self._stream, flush=True)
