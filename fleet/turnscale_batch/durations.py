# SPDX-License-Identifier: MIT
"""How long runs take, as far as that can be told before: for their order, and for the estimate of the end."""
import os

IMAGES = (".png", ".jpg", ".jpeg", ".bmp", ".pgm", ".ppm", ".pnm", ".tif", ".tiff")
BAGS = (".bag", ".mcap", ".db3")
BYTES_OF_FRAME = {"video": 30e3, "bag": 300e3}
SECONDS_OF_FRAME = 0.03  # until a run has ended
LEVELS = 3  # of folders, such as DCIM, its folders, and their clips


def _frames_of_file(name, size):
    """Roughly. `size()`, in bytes, is not asked for images: a folder on a network may have many."""
    if name.lower().endswith(IMAGES):
        return 1
    return size() / BYTES_OF_FRAME["bag" if name.lower().endswith(BAGS) else "video"]


def _frames_of_folder(path, levels):
    with os.scandir(path) as entries:
        return sum(_frames_of_file(entry.name, lambda entry=entry: entry.stat().st_size) if not entry.is_dir()
                   else _frames_of_folder(entry.path, levels - 1) if levels > 1 else 0 for entry in entries)


def frames(path):
    """Roughly how many frames an input has; 0 if there is nothing to be seen."""
    try:
        if os.path.isdir(path):
            return _frames_of_folder(path, LEVELS)
        return _frames_of_file(path, lambda: os.stat(path).st_size)
    except OSError:
        return 0


class Durations:
    """Of runs: as the drive's last run took, or else by the number of its frames."""

    def __init__(self, drives, timeout=None):
        self._inputs = {drive.name: drive.inputs for drive in drives}
        self._timeout = timeout
        self._frames = {}  # by drive
        self._took = {}  # by drive: seconds
        self._seconds = self._seconds_frames = 0.0  # of runs that ended well, and their frames

    def learn(self, record):
        """From a run, of either pass."""
        name, seconds = record["drive"], record["wall_s"]
        if record["exit_code"] == 0:
            self._took[name] = seconds
            if self._frames.get(name):
                self._seconds += seconds
                self._seconds_frames += self._frames[name]
        else:
            # A drive that failed early may take longer once the cause is gone.
            self._took[name] = max(seconds, self._by_frames(name))

    def known(self):
        """Whether any run has ended yet."""
        return bool(self._took)

    def seen(self, name):
        """Whether anything is known of this drive."""
        return name in self._took or self._frames_of(name) > 0

    def seconds(self, name):
        """That a run of this drive is expected to take."""
        took = self._took.get(name)
        if took is None:
            took = self._by_frames(name)
        return took if self._timeout is None else min(took, self._timeout)

    def _frames_of(self, name):
        if name not in self._frames:
            self._frames[name] = sum(frames(path) for path in self._inputs[name])
        return self._frames[name]

    def _by_frames(self, name):
        of_frame = self._seconds / self._seconds_frames if self._seconds_frames else SECONDS_OF_FRAME
        return of_frame * self._frames_of(name)
